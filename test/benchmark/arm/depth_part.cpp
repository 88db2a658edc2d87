#include "test/benchmark/arm/depth_part.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/depth_obstacles.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/base/stopwatch.hpp"

#include "test/unit/arm/perception/depth_scene.hpp"

namespace extperfc::benchmark {
namespace {

using namespace arm;
using arm::test::both_arms;
using arm::test::DepthScene;

constexpr double kTable = 0.8;  // [m]

/// A table, a wall behind it, and objects of all kinds.
DepthScene scene() {
  DepthScene scene;
  scene.add(Box{{1.0, 1.6, 0.04}}, make_pose({1.0, 0, kTable - 0.02}));
  scene.add(Box{{0.1, 4, 3}}, make_pose({2.2, 0, 1.5}));
  Rng rng(4);
  for (int i = 0; i < 16; ++i) {
    const double size = rng.uniform(0.04, 0.2), x = rng.uniform(0.6, 1.4), y = rng.uniform(-0.7, 0.7);
    const Pose pose = make_pose({x, y, kTable + size / 2}, {0, 0, rng.uniform(-3, 3)});
    if (i % 4 == 0) scene.add(Sphere{size / 2}, pose);
    if (i % 4 == 1) scene.add(Box{{size, size / 2, size}}, pose);
    if (i % 4 == 2) scene.add(Cylinder{size / 4, size}, pose);
    if (i % 4 == 3) scene.add(Cone{size / 3, size}, pose);
  }
  scene.add(both_arms(), arm::test::reaching());
  return scene;
}

struct DepthImage {
  CameraModel camera;
  Pose root_T_camera;
  std::vector<std::uint16_t> depth;
};

/// With noise that grows with the square of the depth: 2 mm at 1 m.
DepthImage image() {
  DepthImage made{arm::test::small_camera(640), arm::test::looking({0.32, 0, 1.55}, {0.95, 0, kTable}), {}};
  auto depth = scene().render(made.camera, made.root_T_camera, 6, 2);
  Rng rng(9);
  for (float& value : depth) value += static_cast<float>(rng.normal(0, 0.002)) * value * value;
  for (float& value : depth) value = std::max(value, 0.0F);
  made.depth = arm::test::in_millimetres(depth);
  return made;
}

DepthObstaclesParams params_of(int pixel_step) {
  DepthObstaclesParams params;
  params.pixel_step = pixel_step;
  return params;
}

Result<void> images(const DepthImage& image, int runs, std::vector<Row>& rows) {
  for (const int step : {1, 2}) {
    auto obstacles = DepthObstacles::make(both_arms(), params_of(step));
    if (!obstacles) return tl::unexpected<Error>(obstacles.error());
    double largest = 0, sum = 0;
    DepthUpdate last;
    for (int i = 0; i < runs + 1; ++i) {
      const CpuStopwatch watch;
      const auto update = obstacles->update(arm::test::view_of(image.depth, image.camera), image.camera,
                                            image.root_T_camera, arm::test::reaching(), {}, 0.03 * i);
      if (!update) return tl::unexpected<Error>(update.error());
      last = *update;
      if (i == 0) continue;  // the first one makes the rays
      largest = std::max(largest, watch.seconds());
      sum += watch.seconds();
    }
    const std::string name = "depth image, every " + std::string(step == 1 ? "" : "second ") + "pixel";
    rows.push_back(at_most({name, "time, mean", "ms", 1e3 * sum / runs}, 30));
    rows.push_back({name, "time, longest", "ms", 1e3 * largest});
    rows.push_back({name, "voxels", "", static_cast<double>(last.voxels)});
    rows.push_back({name, "boxes", "", static_cast<double>(last.boxes)});
    rows.push_back({name, "points on the robot", "", static_cast<double>(last.robot_points)});
  }
  return {};
}

JointVector random_state(const JointLimits& limits, Rng& rng) {
  JointVector state(limits.lower.size());
  for (Eigen::Index i = 0; i < state.size(); ++i) state[i] = rng.uniform(limits.lower[i], limits.upper[i]);
  return state;
}

/// The world with the table and `boxes` of depth.
Result<CollisionWorld> world_with(const std::optional<WorldObject>& boxes) {
  CollisionWorld world;
  Shape table;
  table.geometry = Box{{1.0, 1.6, 0.04}};
  if (auto ok = world.add({"table", {table}, make_pose({1.0, 0, kTable - 0.02})}); !ok)
    return tl::unexpected<Error>(ok.error());
  if (boxes)
    if (auto ok = world.add(*boxes); !ok) return tl::unexpected<Error>(ok.error());
  return world;
}

Result<void> checks(const std::string& name, const std::optional<WorldObject>& boxes, int states,
                    std::vector<Row>& rows) {
  const auto world = world_with(boxes);
  if (!world) return tl::unexpected<Error>(world.error());
  const CpuStopwatch making;
  auto checker = CollisionChecker::make(both_arms(), *world);
  if (!checker) return tl::unexpected<Error>(checker.error());
  rows.push_back({name, "making the checker", "ms", 1e3 * making.seconds()});
  Rng rng(2);
  std::vector<JointVector> free;
  while (static_cast<int>(free.size()) < states) {
    // Half of them anywhere, half with the hands over the table.
    JointVector state = random_state(both_arms().limits(), rng);
    if (free.size() % 2 == 1) state = arm::test::reaching() + 0.1 * state;
    if (checker->is_free(state)) free.push_back(state);
  }
  const CpuStopwatch one_by_one;
  for (const JointVector& state : free) (void)checker->is_free(state);
  rows.push_back({name, "is_free, free states", "us", 1e6 * one_by_one.seconds() / states});
  const CpuStopwatch many;
  (void)checker->are_free(free);
  rows.push_back({name, "are_free, per state", "us", 1e6 * many.seconds() / states});
  double spent = 0;
  int proven = 0;
  for (const JointVector& from : free) {
    JointVector delta = random_state({JointVector::Constant(14, -1), JointVector::Constant(14, 1)}, rng);
    delta *= 0.5 / delta.norm();
    const CpuStopwatch watch;
    if (!checker->motion_free(from, from + delta)) continue;
    spent += watch.seconds();
    ++proven;
  }
  rows.push_back({name, "motion of 0.5 rad proven", "us", 1e6 * spent / std::max(proven, 1)});
  return {};
}

}  // namespace

Result<std::vector<Row>> depth_rows(bool quick) {
  std::vector<Row> rows;
  const DepthImage seen = image();
  if (auto ok = images(seen, quick ? 10 : 100, rows); !ok) return tl::unexpected<Error>(ok.error());
  const int states = quick ? 500 : 4000;
  if (auto ok = checks("both arms, a table", {}, states, rows); !ok) return tl::unexpected<Error>(ok.error());
  for (const double voxel_m : {0.02, 0.01}) {
    DepthObstaclesParams params = params_of(1);
    params.voxel_m = voxel_m;
    params.max_boxes = 5000;
    auto obstacles = DepthObstacles::make(both_arms(), params);
    if (!obstacles) return tl::unexpected<Error>(obstacles.error());
    const auto update = obstacles->update(arm::test::view_of(seen.depth, seen.camera), seen.camera,
                                          seen.root_T_camera, arm::test::reaching(), {}, 0);
    if (!update) return tl::unexpected<Error>(update.error());
    if (auto ok = checks("the same and " + std::to_string(update->boxes) + " boxes", obstacles->object(),
                         states, rows);
        !ok)
      return tl::unexpected<Error>(ok.error());
  }
  return rows;
}

}  // namespace extperfc::benchmark
