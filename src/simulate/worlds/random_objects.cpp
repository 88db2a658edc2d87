#include "simulate/worlds/random_objects.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "extperfc/base/math.hpp"

#include "simulate/worlds/objects.hpp"
#include "simulate/worlds/random_look.hpp"

namespace extperfc::simulate {

namespace {
constexpr double kGap = 0.003;  // minimum distance between objects [m]
constexpr int kTries = 60;

struct Object {
  ObjectModel model;
  std::string kind;
  double reach_m{0};
};

struct Standing {
  Eigen::Vector2d at_m;  ///< on the table top
  double reach_m;
  std::vector<Surface> surfaces;
  bool carries{false};
};

Object labelled_object(Rng& rng) {
  switch (rng.integer(0, 2)) {
    case 0: {
      const double diameter = rng.uniform(0.045, 0.10);
      const double height = diameter * rng.uniform(0.9, 1.9);
      const bool lying = rng.chance(0.15);
      const Material paint = random_paint(rng);
      return {lying ? lying_cone(diameter, height, paint) : cone(diameter, height, paint), "cone"};
    }
    case 1: {
      const double edge = rng.uniform(0.035, 0.09);
      return {cube(edge, random_paint(rng)), "cube"};
    }
    default: {
      const double diameter = rng.uniform(0.035, 0.10);
      return {sphere(diameter, random_paint(rng)), "sphere"};
    }
  }
}

/// A cuboid that is clearly no cube: an edge at least 1.7 times as long as another.
Object random_block(Rng& rng) {
  const double edge = rng.uniform(0.03, 0.08);
  const double ratio = rng.uniform(1.7, 3.5);
  Eigen::Vector3d size{edge, edge * rng.uniform(0.8, 1.2), edge * ratio};
  if (rng.chance(0.6)) std::swap(size.z(), size.x());
  return {block(size, random_paint(rng)), "block"};
}

Object distractor(Rng& rng) {
  const Material paint = random_paint(rng);
  switch (rng.integer(0, 8)) {
    case 0:
      return {bottle(rng.uniform(0.15, 0.3), paint), "bottle"};
    case 1:
      return {cup(rng.uniform(0.07, 0.12), paint), "cup"};
    case 2: {
      const double diameter = rng.uniform(0.05, 0.09);
      return {can(diameter, diameter * rng.uniform(1.2, 2.2), paint), "can"};
    }
    case 3:
      return random_block(rng);
    case 4: {
      const Eigen::Vector3d size{rng.uniform(0.15, 0.28), rng.uniform(0.1, 0.2), rng.uniform(0.012, 0.05)};
      return {book(size, paint), "book"};
    }
    case 5: {
      const Eigen::Vector3d size{rng.uniform(0.1, 0.2), rng.uniform(0.03, 0.06), rng.uniform(0.15, 0.28)};
      return {standing_book(size, paint), "standing_book"};
    }
    case 6: {
      const double diameter = rng.uniform(0.03, 0.07);
      return {roll(diameter, diameter * rng.uniform(1.5, 3.5), paint), "roll"};
    }
    case 7: {
      const double edge = rng.uniform(0.05, 0.11);
      return {step_pyramid(edge, edge * rng.uniform(0.5, 0.9), paint), "step_pyramid"};
    }
    default: {
      const double diameter = rng.uniform(0.04, 0.12);
      return {cylinder(diameter, diameter * rng.uniform(0.15, 2.5), paint), "cylinder"};
    }
  }
}

bool free_at(const std::vector<Standing>& standing, const Eigen::Vector2d& at, double reach) {
  return std::all_of(standing.begin(), standing.end(), [&](const Standing& other) {
    return (other.at_m - at).norm() >= other.reach_m + reach + kGap;
  });
}

/// A place on the top itself, with luck close to another object.
bool find_place(Rng& rng, const RandomWorldParams& params, const TableTop& top,
                const std::vector<Standing>& standing, double reach, Eigen::Vector2d& at) {
  const Eigen::Vector2d half = top.half_m - Eigen::Vector2d::Constant(reach + 0.005);
  if (half.minCoeff() <= 0) return false;
  for (int attempt = 0; attempt < kTries; ++attempt) {
    at = {rng.uniform(-half.x(), half.x()), rng.uniform(-half.y(), half.y())};
    if (!standing.empty() && rng.chance(params.crowded)) {
      const auto& friendly =
          standing.at(static_cast<std::size_t>(rng.integer(0, static_cast<int>(standing.size()) - 1)));
      const double angle = rng.uniform(0, kTwoPi);
      const double apart = friendly.reach_m + reach + kGap + std::abs(rng.normal(0, 0.03));
      at = friendly.at_m + apart * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
    if ((at.cwiseAbs() - half).maxCoeff() <= 0 && free_at(standing, at, reach)) return true;
  }
  return false;
}

/// Something flat and large enough that carries nothing yet.
Standing* find_support(std::vector<Standing>& standing, double reach) {
  for (Standing& other : standing)
    if (!other.carries && !other.surfaces.empty() && other.surfaces.back().half_m.minCoeff() > reach * 0.8)
      return &other;
  return nullptr;
}

void put_on_top(RandomScene& scene, const TableTop& top, const Object& object, Standing& support) {
  const double z = support.surfaces.back().z_m;
  const double yaw = scene.rng().uniform(0, kTwoPi);
  scene.put(object.model, object.kind,
            top.world_T_surface * upright(support.at_m.x(), support.at_m.y(), z, yaw));
  support.carries = true;
}

void put_object(RandomScene& scene, const RandomWorldParams& params, const TableTop& top, Object object,
                std::vector<Standing>& standing) {
  Rng& rng = scene.rng();
  object.reach_m = reach_m(object.model);
  if (rng.chance(params.stacked))
    if (Standing* support = find_support(standing, object.reach_m))
      return put_on_top(scene, top, object, *support);
  Eigen::Vector2d at(0, 0);
  if (!find_place(rng, params, top, standing, object.reach_m, at)) return;
  const double yaw = rng.uniform(0, kTwoPi);
  scene.put(object.model, object.kind, top.world_T_surface * upright(at.x(), at.y(), 0, yaw));
  standing.push_back({at, object.reach_m, object.model.surfaces});
}

}  // namespace

void put_objects(RandomScene& scene, const RandomWorldParams& params, const TableTop& top) {
  Rng& rng = scene.rng();
  int objects = rng.integer(params.min_objects, params.max_objects);
  int distractors = rng.integer(params.min_distractors, params.max_distractors);
  std::vector<Standing> standing;
  while (objects + distractors > 0) {
    const bool labelled = rng.integer(1, objects + distractors) <= objects;
    put_object(scene, params, top, labelled ? labelled_object(rng) : distractor(rng), standing);
    (labelled ? objects : distractors) -= 1;
  }
}

}  // namespace extperfc::simulate
