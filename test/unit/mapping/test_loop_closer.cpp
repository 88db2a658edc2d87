// Key frames of simulated buildings, with steps that drift as a tracker's do.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "mapping/loop_closer.hpp"
#include "mapping/pose_distance.hpp"
#include "test/support/planar_world.hpp"

namespace extperfc::mapping {
namespace {

struct Path {
  std::vector<Pose2> truth;  ///< seen from the first
  std::vector<KeyFrame> frames;
  PoseGraph graph;  ///< of the tracked steps
};

/// Every step is rotated by `veer_rad` too far to the left, and known to `sigma_m`.
Path drive(const PlanarWorld& world, const std::vector<Pose2>& route, double veer_rad, std::uint64_t seed,
           double sigma_m = 0.005) {
  PlanarScanner scanner;
  scanner.rays = 180;
  scanner.angle_increment = 2 * M_PI / 180;
  scanner.range_max = 8;
  Rng rng(seed);
  Path path;
  double travelled_m = 0;
  for (std::size_t i = 0; i < route.size(); ++i) {
    path.truth.push_back(between(route.front(), route[i]));
    const Pose2 step = i == 0 ? Pose2{} : between(route[i - 1], route[i]);
    travelled_m += std::hypot(step.x, step.y);
    path.frames.push_back({i, travelled_m, scan_points(scanner.scan(world, route[i], rng), {})});
    if (i == 0) {
      path.graph.add_node({});
      continue;
    }
    const Pose2 tracked{step.x + rng.normal(0, 0.004), step.y + rng.normal(0, 0.004),
                        step.yaw + veer_rad + rng.normal(0, 0.001)};
    path.graph.add_node(compose(path.graph.poses().back(), tracked));
    const double per_m2 = 1 / (sigma_m * sigma_m);
    path.graph.add({i - 1, i, tracked, Eigen::Vector3d(per_m2, per_m2, 1.5e5).asDiagonal(), false});
  }
  return path;
}

Path loop_of_corridors(double veer_rad, std::uint64_t seed) {
  return drive(planar_loop(), planar_loop_route(0.3, 9.0), veer_rad, seed);
}

double worst_error_m(const Path& path) {
  double worst = 0;
  for (std::size_t i = 0; i < path.truth.size(); ++i) {
    const Pose2 off = between(path.truth[i], path.graph.poses()[i]);
    worst = std::max(worst, std::hypot(off.x, off.y));
  }
  return worst;
}

std::size_t closures(const PoseGraph& graph) {
  return static_cast<std::size_t>(std::count_if(graph.constraints().begin(), graph.constraints().end(),
                                                [](const Constraint& c) { return c.is_loop_closure; }));
}

/// Loop closures that are more than 1 m off.
std::size_t wrong_closures(const Path& path) {
  const auto& constraints = path.graph.constraints();
  return static_cast<std::size_t>(
      std::count_if(constraints.begin(), constraints.end(), [&](const Constraint& c) {
        return c.is_loop_closure &&
               distance(between(path.truth[c.from], path.truth[c.to]), c.from_T_to) > 1.0;
      }));
}

/// A loop of corridors that was closed once.
struct ClosedLoop {
  explicit ClosedLoop(std::uint64_t seed) : path(loop_of_corridors(0.0003, seed)) {
    (void)closer.close_all(path.frames, path.graph);
  }

  Path path;
  SubmapCache submaps;
  LoopCloser closer{submaps};
};

class LoopCloserSeeds : public testing::TestWithParam<std::uint64_t> {};

TEST_P(LoopCloserSeeds, ClosesALoopOfCorridors) {
  auto path = loop_of_corridors(0.0004, GetParam());
  const Pose2 end_off = between(path.truth.back(), path.graph.poses().back());
  ASSERT_GT(std::hypot(end_off.x, end_off.y), 0.6) << "the steps alone drift";
  SubmapCache submaps;
  const double score = LoopCloser(submaps).close_all(path.frames, path.graph);
  EXPECT_GT(score, 0);
  EXPECT_GT(closures(path.graph), 10U);
  const Pose2 off = between(path.truth.back(), path.graph.poses().back());
  EXPECT_LT(std::hypot(off.x, off.y), 0.1);
}

INSTANTIATE_TEST_SUITE_P(Seeds, LoopCloserSeeds, testing::Values(1, 2, 3));

/// A corridor around a block, 50 m x 30 m, with recesses of one size at equal distances on both sides.
PlanarWorld alike_loop(double spacing_m) {
  PlanarWorld world;
  world.add_box(-25, -15, 25, 15);
  world.add_box(-23, -13, 23, 13);
  for (double x = -20; x < 20; x += spacing_m) {
    world.add_box(x, -15, x + 1.0, -14.7);
    world.add_box(x, 14.7, x + 1.0, 15);
  }
  for (double y = -10; y < 10; y += spacing_m) {
    world.add_box(-25, y, -24.7, y + 1.0);
    world.add_box(24.7, y, 25, y + 1.0);
  }
  return world;
}

/// The second lap is not closed some recesses off, because a submap that happens to be drawn there shows more
/// of the place than the one at the right place does.
class AlikeRecesses : public testing::TestWithParam<double> {};

TEST_P(AlikeRecesses, AreToldApart) {
  const auto route = planar_drive(
      {{-18, -13.9}, {24, -13.9}, {24, 14}, {-24, 14}, {-24, -13.9}, {24, -13.9}, {24, 0}}, 0.3, 0.15);
  auto path = drive(alike_loop(GetParam()), route, 0.0002, 1, 0.03);
  SubmapCache submaps;
  (void)LoopCloser(submaps).close_all(path.frames, path.graph);
  EXPECT_GT(closures(path.graph), 100U);
  const Pose2 off = between(path.truth.back(), path.graph.poses().back());
  EXPECT_LT(std::hypot(off.x, off.y), 1.0);
}

INSTANTIATE_TEST_SUITE_P(EveryM, AlikeRecesses, testing::Values(3.3, 5.1, 5.7));

TEST(LoopCloser, TakesBackAWrongClosure) {
  auto path = loop_of_corridors(0.0002, 4);
  path.graph.add({10, 150, {0, 0, 0}, Eigen::Vector3d(1e4, 1e4, 1e5).asDiagonal(), true, 1.0});
  SubmapCache submaps;
  (void)LoopCloser(submaps).close_all(path.frames, path.graph);
  for (const Constraint& constraint : path.graph.constraints())
    EXPECT_FALSE(constraint.is_loop_closure && constraint.from == 10 && constraint.to == 150);
  EXPECT_LT(worst_error_m(path), 0.5);
}

/// The end of the path, all of it closed 1.5 m off, and the graph believes it.
TEST(LoopCloser, AStretchThatFitsBadlyIsClosedAgain) {
  ClosedLoop closed(8);
  Path& path = closed.path;
  ASSERT_LT(worst_error_m(path), 0.2);
  for (Constraint& constraint : path.graph.constraints()) {
    if (!constraint.is_loop_closure) continue;
    constraint.from_T_to.x += 1.5;
    constraint.information = 1e5 * Eigen::Matrix3d::Identity();
  }
  ASSERT_TRUE(path.graph.optimize_gradually());
  ASSERT_GT(worst_error_m(path), 1.0) << "the graph was not misled";
  const double before = PassMatcher(closed.submaps).score(path.frames, path.graph);
  std::vector<bool> tried;
  double after = before;
  for (int i = 0; i < 8; ++i) {
    const auto score = closed.closer.close_worst_again(path.frames, path.graph, tried);
    if (!score) break;
    after = *score;
  }
  EXPECT_GT(after, before + 2);
  EXPECT_LT(worst_error_m(path), 0.3);
}

/// The second lap's first side is closed one recess off, the next side rightly: the corner between them is
/// bent.
TEST(LoopCloser, APassThatIsOneDoorOffIsClosedAgain) {
  constexpr double kSpacingM = 4.0;
  const auto route = planar_drive(
      {{-18, -13.9}, {24, -13.9}, {24, 14}, {-24, 14}, {-24, -13.9}, {24, -13.9}, {24, 12}}, 0.3, 0.15);
  auto path = drive(alike_loop(kSpacingM), route, 0.0, 1, 0.03);
  const std::size_t lap = route.size() / 2;
  for (std::size_t i = lap; i < route.size(); i += 4) {
    const auto is_nearer = [&](std::size_t a, std::size_t b) {
      return distance(route[a], route[i]) < distance(route[b], route[i]);
    };
    std::size_t from = 0;
    for (std::size_t k = 1; k < lap; ++k)
      if (is_nearer(k, from)) from = k;
    const bool on_first_side = route[i].y < -13 && route[i].x > -18 && route[i].x < 20;
    const bool on_second_side = route[i].x > 23 && route[i].y > -9;
    if (!on_first_side && !on_second_side) continue;
    Pose2 recognized = between(route[from], route[i]);
    if (on_first_side) recognized.x += kSpacingM;
    path.graph.add({from, i, recognized, 1e4 * Eigen::Matrix3d::Identity(), true, 1.0});
  }
  ASSERT_TRUE(path.graph.optimize_gradually());
  ASSERT_GT(wrong_closures(path), 10U);
  ASSERT_GT(worst_error_m(path), 1.0) << "the graph was not misled";
  SubmapCache submaps;
  LoopCloser closer(submaps);
  const auto passes = LoopCloser::doubtful_passes(path.graph);
  ASSERT_EQ(passes.size(), 2U);
  EXPECT_LT(passes[0].end - passes[0].begin, passes[1].end - passes[1].begin);
  PoseGraph best = path.graph;
  double best_score = PassMatcher(submaps).score(path.frames, best);
  for (const auto& pass : passes) {
    PoseGraph again = path.graph;
    const double score = closer.close_pass_again(pass, path.frames, again);
    if (score <= best_score) continue;
    best_score = score;
    best = std::move(again);
  }
  path.graph = std::move(best);
  EXPECT_EQ(wrong_closures(path), 0U);
  EXPECT_GT(closures(path.graph), 100U);
  EXPECT_LT(worst_error_m(path), 0.6);
  EXPECT_TRUE(LoopCloser::doubtful_passes(path.graph).empty());
}

TEST(LoopCloser, WhatFitsStays) {
  ClosedLoop closed(9);
  Path& path = closed.path;
  const std::size_t constraints = path.graph.constraints().size();
  EXPECT_TRUE(LoopCloser::doubtful_passes(path.graph).empty());
  std::vector<bool> tried;
  EXPECT_FALSE(closed.closer.close_worst_again(path.frames, path.graph, tried));
  EXPECT_EQ(constraints, path.graph.constraints().size());
}

TEST(LoopCloser, ClosesMoreAndKeepsWhatItHas) {
  ClosedLoop closed(10);
  Path& path = closed.path;
  const auto first_closure = std::find_if(path.graph.constraints().begin(), path.graph.constraints().end(),
                                          [](const Constraint& c) { return c.is_loop_closure; });
  const Constraint kept = *first_closure;
  auto& constraints = path.graph.constraints();
  constraints.erase(first_closure + 1, constraints.end());
  (void)closed.closer.close_more(path.frames, path.graph);
  EXPECT_GT(closures(path.graph), 5U);
  EXPECT_TRUE(std::any_of(constraints.begin(), constraints.end(), [&](const Constraint& c) {
    return c.from == kept.from && c.to == kept.to && c.from_T_to.x == kept.from_T_to.x;
  }));
  EXPECT_LT(worst_error_m(path), 0.2);
}

TEST(LoopCloser, ClosesNothingWhereNothingWasSeenTwice) {
  const auto route = planar_loop_route(0.3, 9.0);
  auto path = drive(planar_loop(),
                    {route.begin(), route.begin() + static_cast<std::ptrdiff_t>(route.size() / 2)}, 0.0, 5);
  const auto before = path.graph.poses();
  SubmapCache submaps;
  const double score = LoopCloser(submaps).close_all(path.frames, path.graph);
  EXPECT_EQ(closures(path.graph), 0U);
  EXPECT_EQ(score, 0);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(path.graph.poses()[i].x, before[i].x, 1e-6);
}

TEST(LoopCloser, TheRightGraphScoresHigher) {
  auto right = loop_of_corridors(0.0, 6);
  auto wrong = right;
  right.graph.set_poses(right.truth);
  SubmapCache submaps;
  PassMatcher passes(submaps);
  const double high = passes.score(right.frames, right.graph);
  auto poses = wrong.truth;
  for (std::size_t i = poses.size() / 2; i < poses.size(); ++i) poses[i].y += 1.0;
  wrong.graph.set_poses(poses);
  EXPECT_GT(high, passes.score(wrong.frames, wrong.graph) + 1);
}

TEST(LoopCloser, SamePathSameResult) {
  auto first = loop_of_corridors(0.0004, 7);
  auto second = first;
  SubmapCache one;
  SubmapCache other;
  (void)LoopCloser(one).close_all(first.frames, first.graph);
  (void)LoopCloser(other).close_all(second.frames, second.graph);
  ASSERT_EQ(first.graph.constraints().size(), second.graph.constraints().size());
  for (std::size_t i = 0; i < first.graph.poses().size(); ++i)
    ASSERT_EQ(first.graph.poses()[i].x, second.graph.poses()[i].x) << i;
}

TEST(LoopCloser, AnEmptyPathIsClosed) {
  PoseGraph graph;
  SubmapCache submaps;
  EXPECT_EQ(LoopCloser(submaps).close_all({}, graph), 0);
}

}  // namespace
}  // namespace extperfc::mapping
