#include "simulate/worlds/random_room.hpp"

#include "simulate/worlds/furniture.hpp"
#include "simulate/worlds/random_look.hpp"
#include "simulate/worlds/walls.hpp"

namespace extperfc::simulate {

namespace {
constexpr double kRobotFront = 0.5;  // [m] from its origin
}  // namespace

void put_room(RandomScene& scene, double height) {
  WorldSpec& world = scene.world();
  const Eigen::Vector2d size = world.max_m - world.min_m;
  const Eigen::Vector2d middle = (world.max_m + world.min_m) / 2;
  ObjectModel floor;
  add(floor, Box{{size.x(), size.y(), 0.1}}, {0, 0, -0.05}, random_floor(scene.rng()));
  scene.put(floor, "floor", upright(middle.x(), middle.y(), 0, 0));
  WallParams wall;
  wall.closed = true;
  wall.thickness_m = 0.1;
  wall.height_m = height;
  const Eigen::Vector2d low = world.min_m + Eigen::Vector2d::Constant(0.05);
  const Eigen::Vector2d high = world.max_m - Eigen::Vector2d::Constant(0.05);
  wall.path_m = {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
  wall.skirting = scene.rng().chance(0.7);
  scene.put(walls(wall, random_wall(scene.rng())), "walls", Pose::Identity());
}

TableTop put_table(RandomScene& scene) {
  Rng& rng = scene.rng();
  const Eigen::Vector3d size{rng.uniform(0.5, 0.95), rng.uniform(0.8, 1.8), rng.uniform(0.35, 0.95)};
  const double x = kRobotFront + rng.uniform(0.05, 0.25) + size.x() / 2;
  const double y = rng.uniform(-0.25, 0.25);
  const Material top = random_table_top(rng);
  const Material legs = random_furniture(rng);
  scene.put_apart(table(size, top, legs), "table", upright(x, y, 0, 0), size.head<2>(), 0.5);
  return {upright(x, y, size.z(), 0), size.head<2>() / 2};
}

}  // namespace extperfc::simulate
