#include "test/benchmark/arm/collision_part.hpp"

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/srdf.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::benchmark {

namespace {

using namespace arm;

double now_s() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Shortest time of five runs [s].
template <typename Run>
double best_s(const Run& run) {
  double best = 1e9;
  for (int i = 0; i < 5; ++i) {
    const double start = now_s();
    run();
    best = std::min(best, now_s() - start);
  }
  return best;
}

JointVector random_state(const JointLimits& limits, Rng& rng) {
  JointVector state = JointVector::Zero(limits.lower.size());
  for (Eigen::Index i = 0; i < state.size(); ++i) state[i] = rng.uniform(limits.lower[i], limits.upper[i]);
  return state;
}

CollisionWorld world_of(std::vector<WorldObject> objects, const Pose& root_T_base) {
  CollisionWorld world;
  for (WorldObject& object : objects) {
    object.root_T_object = root_T_base * object.root_T_object;
    if (const auto added = world.add(object); !added) throw std::runtime_error(added.error().message);
  }
  return world;
}

/// Three boards with four cylinders on each, in front of the arms, in the frame of `base`.
std::vector<WorldObject> shelf() {
  std::vector<WorldObject> objects;
  const auto add = [&](const Geometry& geometry, const Eigen::Vector3d& position) {
    Shape shape;
    shape.geometry = geometry;
    objects.push_back({"object_" + std::to_string(objects.size()), {shape}, make_pose(position)});
  };
  for (int board = 0; board < 3; ++board) {
    const double z = -0.3 + 0.3 * board;
    add(Box{{0.6, 1.0, 0.04}}, {1.1, 0, z});
    for (int i = 0; i < 4; ++i) add(Cylinder{0.03, 0.14}, {0.9 + 0.1 * (i % 2), -0.35 + 0.23 * i, z + 0.09});
  }
  return objects;
}

struct Bench {
  CollisionModel model;
  CollisionWorld world;
  Rng rng;
  std::vector<Row> rows;

  void run(int states) {
    CollisionChecker checker = CollisionChecker::make(model, world).value();
    CollisionChecker bullet = CollisionChecker::make(model, world, {1e-3, false}).value();
    std::vector<JointVector> free;
    while (free.size() < 2000)
      if (auto state = random_state(model.limits(), rng); checker.is_free(state)) free.push_back(state);
    rates(checker, bullet, free);
    motions(checker, free);
    safety(checker, bullet, states);
  }

  void rates(CollisionChecker& checker, CollisionChecker& bullet, const std::vector<JointVector>& free) {
    const auto per_second = [](const std::vector<JointVector>& states, double seconds) {
      return static_cast<double>(states.size()) / seconds;
    };
    std::vector<JointVector> near;
    for (const auto& state : free)
      for (int i = 0; i < 8; ++i) near.push_back(state + JointVector::Constant(state.size(), 0.02 * i));
    const double exact = per_second(free, best_s([&] { (void)bullet.are_free(free); }));
    const auto row = [&](const char* name, const std::vector<JointVector>& states, double seconds) {
      rows.push_back({name, "states", "1/s", per_second(states, seconds), exact, "Bullet alone"});
    };
    row("spheres, free states", free, best_s([&] { (void)checker.spheres_free(free); }));
    row("spheres, states along motions", near, best_s([&] { (void)checker.spheres_free(near); }));
    row("spheres then Bullet, free states", free, best_s([&] { (void)checker.are_free(free); }));
    row("one by one, free states", free, best_s([&] {
          for (const auto& state : free) (void)checker.is_free(state);
        }));
  }

  void motions(CollisionChecker& checker, const std::vector<JointVector>& free) {
    std::vector<std::pair<JointVector, JointVector>> proven;
    for (const auto& from : free) {
      JointVector delta =
          random_state({JointVector::Constant(from.size(), -1), JointVector::Constant(from.size(), 1)}, rng);
      delta *= 0.5 / delta.norm();
      if (checker.motion_free(from, from + delta)) proven.emplace_back(from, from + delta);
    }
    const double seconds = best_s([&] {
      for (const auto& [from, to] : proven) (void)checker.motion_free(from, to);
    });
    rows.push_back(
        {"proven motion of 0.5 rad", "time", "us", 1e6 * seconds / static_cast<double>(proven.size())});
  }

  void safety(CollisionChecker& checker, CollisionChecker& bullet, int count) {
    int unsafe = 0, cleared = 0, free = 0;
    constexpr int kBatch = 1000;
    for (int done = 0; done < count; done += kBatch) {
      std::vector<JointVector> states;
      for (int i = 0; i < kBatch; ++i) states.push_back(random_state(model.limits(), rng));
      const auto spheres = checker.spheres_free(states), exact = bullet.are_free(states);
      for (int i = 0; i < kBatch; ++i) {
        unsafe += spheres[i] && !exact[i] ? 1 : 0;
        cleared += spheres[i] ? 1 : 0;
        free += exact[i] ? 1 : 0;
      }
    }
    rows.push_back(
        at_most({"random states: " + std::to_string(count), "unsafe", "1", static_cast<double>(unsafe)}, 0));
    rows.push_back({"free states that spheres clear", "fraction", "1",
                    static_cast<double>(cleared) / std::max(1, free)});
  }
};

}  // namespace

Result<std::vector<Row>> collision_rows(bool quick) {
  const std::filesystem::path root = EXTPERFC_SOURCE_DIR;
  auto robot = RobotModel::from_file(root / "urdf/mobile_baxter.urdf", root);
  if (!robot) return tl::unexpected(robot.error());
  auto srdf = read_srdf(root / "config/robots/baxter/mobile_baxter.srdf");
  if (!srdf) return tl::unexpected(srdf.error());
  auto joints = joints_of_group(*srdf, *robot, "both_arms");
  if (!joints) return tl::unexpected(joints.error());
  CollisionModelParams params;
  params.joints = *joints;
  params.allowed = allowed_pairs(*srdf);
  auto model = CollisionModel::make(*robot, params);
  if (!model) return tl::unexpected(model.error());
  const Pose root_T_base = *model->link_pose(JointVector::Zero(model->joint_count()), "base");
  Bench bench{*model, world_of(shelf(), root_T_base), Rng(1), {}};
  bench.run(quick ? 50'000 : 1'000'000);
  return bench.rows;
}

}  // namespace extperfc::benchmark
