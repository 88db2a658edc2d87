#include "simulate/worlds/random_scene.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "simulate/worlds/furniture.hpp"
#include "simulate/worlds/random_look.hpp"
#include "simulate/worlds/solid.hpp"

namespace extperfc::simulate {

namespace {

constexpr int kFurnitureTries = 12;

/// A wall seen from inside the room: origin at its middle on the floor, x into the room.
struct WallSide {
  Pose pose;
  double length_m;
};

WallSide wall_side(const Eigen::Vector2d& min, const Eigen::Vector2d& max, int side) {
  const Eigen::Vector2d middle = (min + max) / 2;
  switch (side) {
    case 0:
      return {upright(max.x(), middle.y(), 0, 2 * kRightAngle), max.y() - min.y()};
    case 1:
      return {upright(middle.x(), max.y(), 0, -kRightAngle), max.x() - min.x()};
    case 2:
      return {upright(min.x(), middle.y(), 0, 0), max.y() - min.y()};
    default:
      return {upright(middle.x(), min.y(), 0, kRightAngle), max.x() - min.x()};
  }
}

struct Furniture {
  ObjectModel model;
  std::string kind;
  Eigen::Vector2d size_m;
};

Furniture random_shelf(Rng& rng) {
  ShelfParams params;
  params.size_m = {rng.uniform(0.26, 0.4), rng.uniform(0.6, 1.5), rng.uniform(0.9, 2.1)};
  params.levels = std::max(2, static_cast<int>(params.size_m.z() / rng.uniform(0.32, 0.42)));
  params.filled = rng.uniform(0.3, 0.95);
  params.seed = static_cast<std::uint64_t>(rng.integer(0, 100000));
  return {shelf(params, random_furniture(rng)), "shelf", params.size_m.head<2>()};
}

Furniture random_cabinet(Rng& rng) {
  const Eigen::Vector3d size{rng.uniform(0.35, 0.6), rng.uniform(0.5, 1.6), rng.uniform(0.6, 1.9)};
  const int drawers = rng.integer(1, 4);
  return {cabinet(size, random_furniture(rng), drawers), "cabinet", size.head<2>()};
}

Furniture random_table(Rng& rng) {
  const Eigen::Vector3d size{rng.uniform(0.5, 0.9), rng.uniform(0.8, 1.8), rng.uniform(0.4, 0.9)};
  const Material top = random_furniture(rng);
  return {table(size, top, random_furniture(rng)), "side_table", size.head<2>()};
}

Furniture random_sofa(Rng& rng) {
  const Eigen::Vector3d size{rng.uniform(0.8, 1.0), rng.uniform(1.2, 2.2), rng.uniform(0.7, 0.9)};
  return {sofa(size, random_table_top(rng)), "sofa", size.head<2>()};
}

Furniture random_furniture_model(Rng& rng) {
  switch (rng.integer(0, 8)) {
    case 0:
    case 1:
      return random_shelf(rng);
    case 2:
      return random_cabinet(rng);
    case 3:
      return random_table(rng);
    case 4:
      return random_sofa(rng);
    case 5: {
      const double height = rng.uniform(0.7, 1.7);
      return {plant(height, static_cast<std::uint64_t>(rng.integer(0, 100000))), "plant",
              Eigen::Vector2d::Constant(height * 0.5)};
    }
    case 6:
      return {chair(rng.uniform(0.42, 0.5), random_furniture(rng)), "chair", {0.45, 0.45}};
    case 7:
      return {office_chair(rng.uniform(0.44, 0.54), random_table_top(rng)), "office_chair", {0.62, 0.62}};
    default: {
      const Eigen::Vector3d size{rng.uniform(0.25, 0.7), rng.uniform(0.25, 0.7), rng.uniform(0.2, 0.7)};
      ObjectModel carton;
      carton.mobility = Mobility::kMovable;
      add(carton, Box{size}, {0, 0, size.z() / 2}, random_furniture(rng));
      return {carton, "carton", size.head<2>()};
    }
  }
}

Polygon rectangle(const Pose& pose, const Eigen::Vector2d& size) {
  const Eigen::Vector2d half = size / 2;
  Polygon corners;
  for (const auto& corner : Polygon{-half, {half.x(), -half.y()}, half, {-half.x(), half.y()}})
    corners.emplace_back((pose * Eigen::Vector3d(corner.x(), corner.y(), 0)).head<2>());
  return corners;
}

bool any_overlap(const Polygon& area, const std::vector<Polygon>& others) {
  return std::any_of(others.begin(), others.end(),
                     [&area](const Polygon& other) { return overlap(area, other, 0); });
}

/// A painting, window or white board somewhere on a wall.
void hang(RandomScene& scene, const WallSide& wall, double height_m) {
  Rng& rng = scene.rng();
  const auto seed = static_cast<std::uint64_t>(rng.integer(0, 100000));
  const double wide = std::min(rng.uniform(0.5, 1.8), wall.length_m - 0.6);
  const double high = rng.uniform(0.4, 1.2);
  const double along = rng.uniform(-1, 1) * (wall.length_m - wide - 0.3) / 2;
  const double z = std::min(rng.uniform(1.3, 1.7), height_m - high / 2 - 0.1);
  const Pose pose = wall.pose * upright(0, along, z, 0);
  const int kind = rng.integer(0, 3);
  if (scene.reserved(pose, {0.1, wide + 0.2})) return;
  if (kind < 2)
    scene.put(painting(wide, high, seed), "painting", pose);
  else if (kind == 2)
    scene.put(window(wide, high), "window", pose);
  else
    scene.put(whiteboard(wide, high, seed), "whiteboard", pose);
}

}  // namespace

RandomScene::RandomScene(std::string name, std::uint64_t seed) : rng_(seed) {
  world_.name = std::move(name);
  world_.description = "Made from seed " + std::to_string(seed);
}

void RandomScene::put(const ObjectModel& model, const std::string& kind, const Pose& world_T_object) {
  // Numbers run over all objects, so that names are unique.
  world_.bodies.push_back(
      place(model, kind + "_" + std::to_string(world_.bodies.size() + 1), world_T_object));
}

bool RandomScene::put_apart(const ObjectModel& model, const std::string& kind, const Pose& world_T_object,
                            const Eigen::Vector2d& size_m, double gap_m) {
  const Eigen::Vector2d size = size_m + Eigen::Vector2d::Constant(2 * gap_m);
  const Polygon area = rectangle(world_T_object, size);
  if (reserved(world_T_object, size) || any_overlap(area, taken_)) return false;
  taken_.push_back(area);
  put(model, kind, world_T_object);
  return true;
}

void RandomScene::reserve(const Eigen::Vector2d& min_m, const Eigen::Vector2d& max_m) {
  reserved_.push_back({min_m, {max_m.x(), min_m.y()}, max_m, {min_m.x(), max_m.y()}});
}

bool RandomScene::reserved(const Pose& world_T_rectangle, const Eigen::Vector2d& size_m) const {
  return any_overlap(rectangle(world_T_rectangle, size_m), reserved_);
}

double reach_m(const ObjectModel& model) {
  double reach = 0;
  for (const Shape& shape : model.shapes)
    if (const auto polygon = outline(shape.geometry, shape.body_T_shape, -1e3, 1e3))
      for (const auto& point : *polygon) reach = std::max(reach, point.norm());
  return reach;
}

void furnish_walls(RandomScene& scene, const Eigen::Vector2d& min_m, const Eigen::Vector2d& max_m, int count,
                   double height_m) {
  Rng& rng = scene.rng();
  for (int i = 0; i < count; ++i) {
    const Furniture furniture = random_furniture_model(rng);
    for (int attempt = 0; attempt < kFurnitureTries; ++attempt) {
      const WallSide wall = wall_side(min_m, max_m, rng.integer(0, 3));
      const double along = rng.uniform(-1, 1) * (wall.length_m - furniture.size_m.y() - 0.1) / 2;
      const double off = furniture.size_m.x() / 2 + 0.04;
      if (furniture.size_m.y() > wall.length_m - 0.1) continue;
      if (scene.put_apart(furniture.model, furniture.kind, wall.pose * upright(off, along, 0, 0),
                          furniture.size_m, 0.02))
        break;
    }
  }
  for (int side = 0; side < 4; ++side)
    if (rng.chance(0.6)) hang(scene, wall_side(min_m, max_m, side), height_m);
}

}  // namespace extperfc::simulate
