#include "simulate/worlds/objects.hpp"

#include <cmath>

#include "simulate/worlds/materials.hpp"
#include "simulate/worlds/solid.hpp"

namespace extperfc::simulate {

namespace {

constexpr double kHollow = 0.35;  // fraction of the volume that cups, cans and bottles weigh

ObjectModel loose(const Geometry& geometry, const Pose& pose, const Material& material, const char* label) {
  ObjectModel model;
  model.mobility = Mobility::kLoose;
  model.label = label;
  add(model, geometry, pose, material);
  model.mass_kg = kDensity * volume_m3(geometry);
  return model;
}

double weigh(const ObjectModel& model, double fraction) {
  double volume = 0;
  for (const Shape& shape : model.shapes) volume += volume_m3(shape.geometry);
  return kDensity * volume * fraction;
}

}  // namespace

ObjectModel cone(double diameter_m, double height_m, const Material& material) {
  return loose(Cone{diameter_m / 2, height_m}, upright(0, 0, height_m / 2, 0), material, "cone");
}

ObjectModel lying_cone(double diameter_m, double height_m, const Material& material) {
  // Tip and rim touch the ground: the axis falls towards the tip by half the opening angle.
  const double fall = std::atan2(diameter_m / 2, height_m);
  const double z = height_m / 2 * std::sin(fall);  // of the middle of the axis above the tip
  return loose(Cone{diameter_m / 2, height_m}, make_pose({0, 0, z}, {0, kRightAngle + fall, 0}), material,
               "cone");
}

ObjectModel cube(double edge_m, const Material& material) {
  ObjectModel model = block(Eigen::Vector3d::Constant(edge_m), material);
  model.label = "cube";
  return model;
}

ObjectModel sphere(double diameter_m, const Material& material) {
  return loose(Sphere{diameter_m / 2}, upright(0, 0, diameter_m / 2, 0), material, "sphere");
}

ObjectModel block(const Eigen::Vector3d& size_m, const Material& material) {
  ObjectModel model = loose(Box{size_m}, upright(0, 0, size_m.z() / 2, 0), material, "");
  model.surfaces.push_back({size_m.z(), size_m.head<2>() / 2});
  return model;
}

ObjectModel cylinder(double diameter_m, double height_m, const Material& material) {
  ObjectModel model = loose(Cylinder{diameter_m / 2, height_m}, upright(0, 0, height_m / 2, 0), material, "");
  model.surfaces.push_back({height_m, Eigen::Vector2d::Constant(diameter_m * 0.35)});
  return model;
}

ObjectModel roll(double diameter_m, double length_m, const Material& material) {
  return loose(Cylinder{diameter_m / 2, length_m}, make_pose({0, 0, diameter_m / 2}, {kRightAngle, 0, 0}),
               material, "");
}

ObjectModel bottle(double height_m, const Material& material) {
  const double radius = height_m * 0.15;
  ObjectModel model = loose(Cylinder{radius, height_m * 0.6}, upright(0, 0, height_m * 0.3, 0), material, "");
  add(model, Cone{radius, height_m * 0.3}, {0, 0, height_m * 0.75}, material);
  add(model, Cylinder{radius * 0.38, height_m * 0.26}, {0, 0, height_m * 0.83}, material);
  add(model, Cylinder{radius * 0.45, height_m * 0.06}, {0, 0, height_m * 0.97},
      known_materials().at("white"));
  add(model, Cylinder{radius * 1.01, height_m * 0.25}, {0, 0, height_m * 0.32},
      known_materials().at("white"));
  model.mass_kg = weigh(model, kHollow);
  return model;
}

ObjectModel cup(double height_m, const Material& material) {
  const double radius = height_m * 0.42;
  ObjectModel model = loose(Cylinder{radius, height_m}, upright(0, 0, height_m / 2, 0), material, "");
  add(model, Cylinder{radius * 0.9, height_m * 0.02}, {0, 0, height_m}, shaded(material, 0.25F));
  const double reach = height_m * 0.28;
  for (const double z : {0.28, 0.75})
    add(model, Box{{reach, height_m * 0.12, height_m * 0.1}}, {radius + reach / 2 - 0.003, 0, z * height_m},
        material);
  add(model, Box{{height_m * 0.1, height_m * 0.12, height_m * 0.5}},
      {radius + reach - 0.003, 0, height_m * 0.52}, material);
  model.mass_kg = weigh(model, kHollow);
  return model;
}

ObjectModel book(const Eigen::Vector3d& size_m, const Material& cover) {
  ObjectModel model = loose(Box{size_m}, upright(0, 0, size_m.z() / 2, 0), cover, "");
  // The pages show at three edges.
  const Eigen::Vector3d pages(size_m.x() + 0.001, size_m.y() - 0.004, size_m.z() * 0.7);
  add(model, Box{pages}, {0, 0.0026, size_m.z() / 2}, known_materials().at("white"));
  model.surfaces.push_back({size_m.z(), size_m.head<2>() / 2});
  return model;
}

ObjectModel standing_book(const Eigen::Vector3d& size_m, const Material& cover) {
  ObjectModel model = loose(Box{size_m}, upright(0, 0, size_m.z() / 2, 0), cover, "");
  const Eigen::Vector3d pages(size_m.x() - 0.004, size_m.y() * 0.7, size_m.z() + 0.001);
  add(model, Box{pages}, {-0.0026, 0, size_m.z() / 2 + 0.0005}, known_materials().at("white"));
  return model;
}

ObjectModel can(double diameter_m, double height_m, const Material& material) {
  ObjectModel model = loose(Cylinder{diameter_m / 2, height_m}, upright(0, 0, height_m / 2, 0), material, "");
  const Material& metal = known_materials().at("metal");
  add(model, Cylinder{diameter_m * 0.505, height_m * 0.03}, {0, 0, height_m * 0.97}, metal);
  add(model, Cylinder{diameter_m * 0.505, height_m * 0.03}, {0, 0, height_m * 0.03}, metal);
  add(model, Cylinder{diameter_m * 0.45, 0.001}, {0, 0, height_m + 0.0005}, shaded(metal, 0.8F));
  model.mass_kg = weigh(model, kHollow);
  return model;
}

ObjectModel step_pyramid(double edge_m, double height_m, const Material& material) {
  constexpr int kSteps = 5;
  const double step = height_m / kSteps;
  ObjectModel model = loose(Box{{edge_m, edge_m, step}}, upright(0, 0, step / 2, 0), material, "");
  for (int i = 1; i < kSteps; ++i) {
    const double edge = edge_m * (kSteps - i) / kSteps;
    add(model, Box{{edge, edge, step}}, {0, 0, step * (i + 0.5)},
        shaded(material, 1.0F + 0.05F * static_cast<float>(i)));
  }
  model.mass_kg = weigh(model, 1);
  return model;
}

}  // namespace extperfc::simulate
