#include "simulate/worlds/random_floor.hpp"

#include <string>
#include <vector>

#include "simulate/worlds/random_look.hpp"
#include "simulate/worlds/random_scene.hpp"
#include "simulate/worlds/walls.hpp"

namespace extperfc::simulate {

namespace {

constexpr double kThick = 0.12;      // of inner walls [m]
constexpr double kHeight = 2.6;      // [m]
constexpr double kDoorWidth = 0.95;  // [m]
constexpr double kClear = 1.1;       // kept free around a door [m]

/// What all rooms of a floor share.
struct Plan {
  double length_m;         ///< along the corridor
  double corridor_half_m;  ///< half its width
  double depth_m;          ///< of the rooms
  Material wall;
};

/// Divides the length into rooms; the borders between them.
std::vector<double> borders(Rng& rng, double length) {
  std::vector<double> result{-length / 2};
  while (length / 2 - result.back() > 7.5) result.push_back(result.back() + rng.uniform(3.2, 5.5));
  result.push_back(length / 2);
  return result;
}

void keep_free(RandomScene& scene, const Eigen::Vector2d& at) {
  scene.reserve(at - Eigen::Vector2d::Constant(kClear), at + Eigen::Vector2d::Constant(kClear));
}

void put_door(RandomScene& scene, const WallParams& wall, const Opening& opening, double side) {
  Rng& rng = scene.rng();
  DoorParams params;
  params.width_m = opening.width_m;
  params.height_m = opening.top_m;
  params.hinge_right = rng.chance(0.5);
  const double open = rng.chance(0.25) ? 0 : rng.uniform(0.9, 1.7);
  const Pose pose = opening_pose(wall, opening) * door_pose(params, side * open);
  scene.put(door(params, random_furniture(rng)), "door", pose);
}

/// The wall between corridor and rooms on one side (+1: north), a door per room.
void put_corridor_wall(RandomScene& scene, const Plan& plan, const std::vector<double>& rooms, double side) {
  WallParams wall;
  wall.thickness_m = kThick;
  const double y = side * plan.corridor_half_m;
  wall.path_m = {{-plan.length_m / 2, y}, {plan.length_m / 2, y}};
  Rng& rng = scene.rng();
  for (std::size_t i = 0; i + 1 < rooms.size(); ++i) {
    Opening opening;
    opening.width_m = kDoorWidth;
    const double x = rng.uniform(rooms[i] + 0.9, rooms[i + 1] - 0.9);
    opening.at_m = x + plan.length_m / 2;
    wall.openings.push_back(opening);
    keep_free(scene, {x, y});
    if (rng.chance(0.8)) put_door(scene, wall, opening, side);
  }
  scene.put(walls(wall, plan.wall), "wall", Pose::Identity());
}

/// Walls between neighbours, every other one with a passage.
void put_partitions(RandomScene& scene, const Plan& plan, const std::vector<double>& rooms, double side) {
  for (std::size_t i = 1; i + 1 < rooms.size(); ++i) {
    WallParams wall;
    wall.thickness_m = kThick;
    const double near = side * (plan.corridor_half_m + kThick / 2);
    wall.path_m = {{rooms[i], near}, {rooms[i], near + side * (plan.depth_m - kThick / 2)}};
    if (scene.rng().chance(0.5)) {
      Opening passage;
      passage.width_m = scene.rng().uniform(0.95, 1.8);
      passage.at_m = plan.depth_m * scene.rng().uniform(0.4, 0.7);
      wall.openings.push_back(passage);
      keep_free(scene, {rooms[i], near + side * passage.at_m});
    }
    scene.put(walls(wall, plan.wall), "wall", Pose::Identity());
  }
}

void furnish(RandomScene& scene, const Plan& plan, const std::vector<double>& rooms, double side) {
  const double inset = kThick / 2 + 0.02;
  for (std::size_t i = 0; i + 1 < rooms.size(); ++i) {
    const double near = plan.corridor_half_m + inset;
    const double far = plan.corridor_half_m + plan.depth_m - inset;
    const Eigen::Vector2d low(rooms[i] + inset, side > 0 ? near : -far);
    const Eigen::Vector2d high(rooms[i + 1] - inset, side > 0 ? far : -near);
    furnish_walls(scene, low, high, scene.rng().integer(3, 7), kHeight);
  }
}

void put_shell(RandomScene& scene, const Plan& plan) {
  WorldSpec& world = scene.world();
  const Eigen::Vector2d half(plan.length_m / 2 + kThick / 2,
                             plan.corridor_half_m + plan.depth_m + kThick / 2);
  world.min_m = -half - Eigen::Vector2d::Constant(kThick / 2);
  world.max_m = half + Eigen::Vector2d::Constant(kThick / 2);
  ObjectModel floor;
  add(floor, Box{{2 * half.x() + kThick, 2 * half.y() + kThick, 0.1}}, {0, 0, -0.05},
      random_floor(scene.rng()));
  scene.put(floor, "floor", Pose::Identity());
  WallParams outer;
  outer.closed = true;
  outer.thickness_m = kThick;
  outer.path_m = {-half, {half.x(), -half.y()}, half, {-half.x(), half.y()}};
  scene.put(walls(outer, plan.wall), "outer_wall", Pose::Identity());
}

}  // namespace

WorldSpec floor_world(const RandomWorldParams& params, std::uint64_t seed) {
  RandomScene scene("random_floor_" + std::to_string(seed), seed);
  Rng& rng = scene.rng();
  const Plan plan{rng.uniform(14, 26), rng.uniform(0.9, 1.3), rng.uniform(3.6, 6.0), random_wall(rng)};
  scene.world().light = {{0, 0, 6}, 0.3F, 0.65F, {0.85F, 0.87F, 0.9F}};
  put_shell(scene, plan);
  scene.reserve({-plan.length_m / 2, -plan.corridor_half_m}, {plan.length_m / 2, plan.corridor_half_m});
  for (const double side : {1.0, -1.0}) {
    const auto rooms = borders(rng, plan.length_m);
    put_corridor_wall(scene, plan, rooms, side);
    put_partitions(scene, plan, rooms, side);
    furnish(scene, plan, rooms, side);
  }
  if (rng.chance(params.person)) {
    const double end = plan.length_m / 2 - 0.8;
    scene.world().people.push_back({"person_1", {{end, 0.3}, {-end, 0.3}}, rng.uniform(0.5, 1.2), false, {}});
    scene.world().people.back().colour = random_colour(rng, {0.2, 0.8, 0.3, 0.8});
  }
  return scene.world();
}

}  // namespace extperfc::simulate
