#include "simulate/worlds/varied_objects.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "extperfc/base/math.hpp"

#include "simulate/worlds/furniture.hpp"
#include "simulate/worlds/lathe.hpp"
#include "simulate/worlds/materials.hpp"
#include "simulate/worlds/objects.hpp"
#include "simulate/worlds/random_look.hpp"

namespace extperfc::simulate {

namespace {

constexpr int kRound = 28;  // corners of a round look-alike

/// Sizes spread over their logarithm: small and large ones alike.
double log_uniform(Rng& rng, double low, double high) {
  return std::exp(rng.uniform(std::log(low), std::log(high)));
}

/// Mostly of the size that a hand can take.
double target_size(Rng& rng) {
  return rng.chance(0.75) ? rng.uniform(0.03, 0.1) : log_uniform(rng, 0.1, 0.3);
}

Eigen::Vector3f any_colour(Rng& rng) {
  const double kind = rng.uniform(0, 1);
  if (kind < 0.5) return random_colour(rng, {0.55, 1.0, 0.35, 1.0});
  if (kind < 0.75) return random_colour(rng, {0.1, 0.55, 0.3, 1.0});
  if (kind < 0.9) return random_colour(rng, {0, 0.08, 0.75, 0.98});
  return random_colour(rng, {0, 0.1, 0.05, 0.7});
}

ObjectModel turned(const TriangleMesh& mesh, const Material& material) {
  ObjectModel model;
  add(model, mesh, {0, 0, mesh.scale.z() / 2}, material);
  return model;
}

ObjectModel round_solid(const char* name, const std::vector<Eigen::Vector2d>& profile, double width,
                        double height, const Material& material) {
  return turned(lathe(name, profile, kRound, {width, width, height}), material);
}

/// The cone of a street or a gym: a foot and bands.
ObjectModel traffic_cone(Rng& rng) {
  const double height = rng.uniform(0.12, 0.35);
  const double width = height * rng.uniform(0.4, 0.6);
  Material paint = varied_material(rng);
  if (rng.chance(0.6)) paint.colour = colour_from_hsv(rng.uniform(0.01, 0.08), 0.9, 0.95);
  paint.texture = rng.chance(0.5) ? Texture::kNone : Texture::kStripes;
  ObjectModel model = cone(width, height, paint);
  add(model, Box{{width * 1.35, width * 1.35, height * 0.05}}, {0, 0, height * 0.025}, paint);
  const double at = rng.uniform(0.3, 0.6);
  const double radius = width / 2 * (1 - at) * 1.02;
  if (rng.chance(0.6))
    add(model, lathe("band", frustum_profile(0.72), kRound, {2 * radius, 2 * radius, height * 0.16}),
        {0, 0, height * (at + 0.08)}, known_materials().at("white"));
  return model;
}

ObjectModel any_cone(Rng& rng) {
  if (rng.chance(0.12)) return traffic_cone(rng);
  const double diameter = target_size(rng);
  const Material material = varied_material(rng);
  return cone(diameter, diameter * log_uniform(rng, 0.75, 2.4), material);
}

ObjectModel any_cube(Rng& rng) {
  const double edge = target_size(rng);
  Material material = varied_material(rng);
  if (material.texture == Texture::kPips) material.texture_size_m = static_cast<float>(edge);
  ObjectModel model = cube(edge, material);
  if (rng.chance(0.1))  // a carton with a strip of tape
    add(model, Box{{edge * 1.002, edge * 0.15, edge * 1.002}}, {0, 0, edge / 2}, shaded(material, 0.8F));
  return model;
}

ObjectModel any_sphere(Rng& rng) {
  const double diameter = target_size(rng);
  Material material = varied_material(rng);
  if (rng.chance(0.1)) material.texture = Texture::kBall;
  if (material.texture != Texture::kNone)
    material.texture_size_m = static_cast<float>(diameter * rng.uniform(0.6, 3.2));
  return sphere(diameter, material);
}

ObjectModel slab(Rng& rng, double size, const Material& material) {
  const Eigen::Vector3d lengths{size * rng.uniform(1.7, 3), size * rng.uniform(0.8, 2.4),
                                size * rng.uniform(0.1, 0.9)};
  ObjectModel model;
  add(model, Box{lengths}, {0, 0, lengths.z() / 2}, material);
  return model;
}

ObjectModel board(Rng& rng, const Material& ground) {
  Material material = ground;
  material.texture = rng.chance(0.6) ? Texture::kChecker : Texture::kPrint;
  const double edge = rng.uniform(0.1, 0.4);
  ObjectModel model;
  add(model, Box{{edge, edge * rng.uniform(0.7, 1.3), rng.uniform(0.002, 0.02)}}, {0, 0, 0.01}, material);
  return model;
}

ObjectModel pyramid(Rng& rng, double size, const Material& material) {
  const double height = size * rng.uniform(0.6, 1.8);
  const int corners = rng.integer(3, 4);
  const double top = rng.chance(0.7) ? 0.0 : 0.4;
  return turned(lathe("pyramid", frustum_profile(top), corners, {size, size, height}), material);
}

ObjectModel prism(Rng& rng, double size, const Material& material) {
  const std::array<int, 4> sides{3, 5, 6, 8};
  const int corners = sides.at(static_cast<std::size_t>(rng.integer(0, 3)));
  return turned(lathe("prism", frustum_profile(1), corners, {size, size, size * rng.uniform(0.4, 2)}),
                material);
}

ObjectModel bucket(Rng& rng, double size, const Material& material) {
  const double top = rng.uniform(0.35, 0.85);
  ObjectModel model =
      round_solid("bucket", frustum_profile(top), size, size * rng.uniform(0.5, 1.6), material);
  if (rng.chance(0.5)) model.shapes[0].body_T_shape.rotate(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()));
  return model;
}

ObjectModel ellipsoid(Rng& rng, double size, const Material& material) {
  const bool flat = rng.chance(0.5);
  const double height = size * (flat ? rng.uniform(0.2, 0.68) : rng.uniform(1.45, 2.6));
  return round_solid("ellipsoid", rng.chance(0.5) ? egg_profile() : ellipse_profile(), size, height,
                     material);
}

void finger(ObjectModel& model, const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius,
            const Material& skin) {
  const Eigen::Vector3d along = to - from;
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), along).toRotationMatrix();
  pose.translation() = (from + to) / 2;
  add(model, Cylinder{radius, along.norm()}, pose, skin);
  add(model, Sphere{radius}, to, skin);
}

}  // namespace

Material varied_material(Rng& rng) {
  constexpr std::array<Texture, 14> kPatterns{
      Texture::kWood,  Texture::kWood,     Texture::kStripes, Texture::kDots,    Texture::kPrint,
      Texture::kPrint, Texture::kPoster,   Texture::kBall,    Texture::kPips,    Texture::kChecker,
      Texture::kCloth, Texture::kBlotches, Texture::kMarble,  Texture::kGradient};
  Material material;
  material.colour = any_colour(rng);
  if (rng.chance(0.42))
    material.texture =
        kPatterns.at(static_cast<std::size_t>(rng.integer(0, static_cast<int>(kPatterns.size()) - 1)));
  material.texture_size_m = static_cast<float>(log_uniform(rng, 0.02, 0.3));
  material.gloss = rng.chance(0.5) ? static_cast<float>(rng.uniform(0, 1)) : 0.03F;
  return material;
}

ObjectModel varied_target(Rng& rng) {
  const int kind = rng.integer(0, 2);
  return kind == 0 ? any_cone(rng) : kind == 1 ? any_cube(rng) : any_sphere(rng);
}

namespace {

struct Kind {
  const char* label;
  ObjectModel (*make)(Rng& rng, double size, const Material& material);
};

/// What look_alike() draws from; what is listed twice comes twice as often.
constexpr std::array<Kind, 16> kLookAlikes{{
    {"can",
     [](Rng& rng, double size, const Material& m) { return can(size, size * rng.uniform(1.1, 2.2), m); }},
    {"cup", [](Rng& rng, double size, const Material& m) { return cup(size * rng.uniform(0.9, 1.4), m); }},
    {"egg", ellipsoid},
    {"egg", ellipsoid},
    {"dome",
     [](Rng& rng, double size, const Material& m) {
       return round_solid("dome", dome_profile(), size, size * rng.uniform(0.3, 0.6), m);
     }},
    {"pyramid", pyramid},
    {"prism", prism},
    {"slab", [](Rng& rng, double size, const Material& m) { return slab(rng, size * 0.7, m); }},
    {"slab", [](Rng& rng, double size, const Material& m) { return slab(rng, size * 0.7, m); }},
    {"bucket", bucket},
    {"board", [](Rng& rng, double /*size*/, const Material& m) { return board(rng, m); }},
    {"vase",
     [](Rng& rng, double size, const Material& m) {
       const double height = size * rng.uniform(1, 2.5);
       return round_solid("vase", vase_profile(rng.uniform(0.3, 0.7)), size, height, m);
     }},
    {"disc", [](Rng& rng, double size,
                const Material& m) { return cylinder(size, size * rng.uniform(0.04, 0.3), m); }},
    {"cylinder", [](Rng& rng, double size,
                    const Material& m) { return cylinder(size, size * rng.uniform(0.6, 1.4), m); }},
    {"bottle",
     [](Rng& rng, double size, const Material& m) { return bottle(size * rng.uniform(1.5, 3), m); }},
    {"roll", [](Rng& rng, double size,
                const Material& m) { return roll(size * 0.7, size * rng.uniform(1.0, 2.5), m); }},
}};

}  // namespace

ObjectModel look_alike(Rng& rng) {
  const Material material = varied_material(rng);
  const double size = target_size(rng);
  const Kind& kind = kLookAlikes.at(static_cast<std::size_t>(rng.integer(0, kLookAlikes.size() - 1)));
  ObjectModel model = kind.make(rng, size, material);
  model.label = kind.label;
  return model;
}

ObjectModel hand(Rng& rng) {
  ObjectModel model;
  Material skin;
  const double value = rng.uniform(0.3, 0.95);
  const double saturation = rng.uniform(0.25, 0.6);
  skin.colour = colour_from_hsv(rng.uniform(0.03, 0.08), saturation, value);
  skin.gloss = 0.1F;
  Material sleeve = rng.chance(0.5) ? varied_material(rng) : skin;
  finger(model, {-0.3, 0, 0.02}, {-0.02, 0, 0.01}, 0.035, sleeve);
  add(model, Box{{0.09, 0.085, 0.028}}, {0.04, 0, 0}, skin);
  for (int i = 0; i < 4; ++i) {
    const double y = 0.021 * (i - 1.5);
    const double bend = rng.uniform(0, 0.05);
    const Eigen::Vector3d knuckle(0.085, y, 0);
    const Eigen::Vector3d middle(0.085 + 0.045, y, -bend * 0.4);
    finger(model, knuckle, middle, 0.009, skin);
    finger(model, middle, {middle.x() + 0.035, y * 0.9, middle.z() - bend}, 0.008, skin);
  }
  finger(model, {0.01, 0.04, -0.005}, {0.075, 0.065, -rng.uniform(0, 0.05)}, 0.011, skin);
  return model;
}

ObjectModel gripper_fingers(Rng& rng, double opening_m) {
  ObjectModel model;
  const auto grey = static_cast<float>(rng.uniform(0.05, 0.6));
  const Material metal{{grey, grey, grey}, Texture::kNone, 1.0F, 0.3F};
  const double width = rng.uniform(0.012, 0.03);
  for (const double side : {-1.0, 1.0})
    add(model, Box{{0.1, 0.012, width}}, {0.08, side * (opening_m / 2 + 0.006), 0}, metal);
  add(model, Box{{0.05, opening_m + 0.06, width * 1.6}}, {0.015, 0, 0}, metal);
  finger(model, {-0.25, 0, 0}, {-0.02, 0, 0}, rng.uniform(0.03, 0.06), shaded(metal, 1.3F));
  return model;
}

ObjectModel cable(Rng& rng) {
  ObjectModel model;
  Material rubber;
  rubber.colour = rng.chance(0.6) ? Eigen::Vector3f(0.08F, 0.08F, 0.08F) : any_colour(rng);
  const double radius = rng.uniform(0.002, 0.006);
  const double y = rng.uniform(-0.2, 0.2);
  Eigen::Vector3d at(rng.uniform(-0.2, 0.2), y, radius);
  double heading = rng.uniform(-kPi, kPi);
  for (int i = 0; i < 14; ++i) {
    const Eigen::Vector3d next = at + 0.04 * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
    finger(model, at, next, radius, rubber);
    at = next;
    heading += rng.normal(0, 0.5);
  }
  return model;
}

}  // namespace extperfc::simulate
