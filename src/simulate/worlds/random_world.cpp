#include "extperfc/simulate/random_world.hpp"

#include "simulate/worlds/furniture.hpp"
#include "simulate/worlds/random_floor.hpp"
#include "simulate/worlds/random_look.hpp"
#include "simulate/worlds/random_objects.hpp"
#include "simulate/worlds/random_room.hpp"
#include "simulate/worlds/random_scene.hpp"

namespace extperfc::simulate {

namespace {

constexpr int kMaxRandomObjects = 40;

Result<void> check(const RandomWorldParams& params) {
  const auto counts = [](int low, int high) { return low >= 0 && low <= high && high <= kMaxRandomObjects; };
  const auto fraction = [](double value) { return value >= 0 && value <= 1; };
  if (!counts(params.min_objects, params.max_objects) ||
      !counts(params.min_distractors, params.max_distractors))
    return fail(ErrorCode::kInvalidArgument,
                "random world: numbers of objects and distractors must be 0 <= min <= max <= 40");
  if (!fraction(params.crowded) || !fraction(params.stacked) || !fraction(params.person))
    return fail(ErrorCode::kInvalidArgument, "random world: crowded, stacked and person must be in [0, 1]");
  return {};
}

void put_person(RandomScene& scene) {
  Rng& rng = scene.rng();
  const WorldSpec& world = scene.world();
  PersonSpec person;
  person.name = "person_1";
  const double x = rng.uniform(1.9, world.max_m.x() - 0.8);
  const double y = rng.uniform(world.min_m.y() + 0.9, world.max_m.y() - 0.9);
  person.path_m = {{x, y}, {x, y + (y > 0 ? -0.3 : 0.3)}};
  person.colour = random_colour(rng, {0.1, 0.9, 0.2, 0.8});
  scene.reserve({x - 0.4, y - 0.7}, {x + 0.4, y + 0.7});
  scene.world().people.push_back(person);
}

WorldSpec table_world(const RandomWorldParams& params, std::uint64_t seed) {
  RandomScene scene("random_table_" + std::to_string(seed), seed);
  Rng& rng = scene.rng();
  WorldSpec& world = scene.world();
  world.min_m = {-rng.uniform(1.2, 2.2), -rng.uniform(1.6, 3.2)};
  world.max_m = {rng.uniform(2.9, 5.0), rng.uniform(1.6, 3.2)};
  const double height = rng.uniform(2.4, 3.0);
  world.light = random_light(rng, world.min_m, world.max_m, height);
  put_room(scene, height);
  const TableTop top = put_table(scene);
  scene.reserve({-0.9, -0.9}, {0.9, 0.9});  // the robot's place
  if (rng.chance(params.person)) put_person(scene);
  const Eigen::Vector2d inset = Eigen::Vector2d::Constant(0.115);
  furnish_walls(scene, world.min_m + inset, world.max_m - inset, rng.integer(3, 9), height);
  put_objects(scene, params, top);
  return world;
}

/// The people of all random worlds have the same names, and another face in each.
WorldSpec with_faces(WorldSpec world, std::uint64_t seed) {
  constexpr std::uint64_t kFaces = static_cast<std::uint64_t>(kMaxFaceSeed) + 1U;
  for (PersonSpec& person : world.people) person.face = static_cast<int>(seed++ % kFaces);
  return world;
}

}  // namespace

Result<WorldSpec> random_world(const RandomWorldParams& params, std::uint64_t seed) {
  if (const auto checked = check(params); !checked) return tl::unexpected(checked.error());
  const bool table = params.kind == RandomWorldParams::Kind::kTable;
  return with_faces(table ? table_world(params, seed) : floor_world(params, seed), seed);
}

}  // namespace extperfc::simulate
