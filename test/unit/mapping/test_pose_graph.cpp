#include <limits>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "mapping/pose_graph.hpp"

namespace extperfc::mapping {
namespace {

Pose2 random_pose(Rng& rng, double m, double rad) {
  return {rng.uniform(-m, m), rng.uniform(-m, m), rng.uniform(-rad, rad)};
}

/// Symmetric and positive, with eigenvalues between 10 and 1000 or so.
Eigen::Matrix3d random_information(Rng& rng) {
  Eigen::Matrix3d root;
  for (int i = 0; i < 9; ++i) root(i / 3, i % 3) = rng.uniform(-15, 15);
  return root * root.transpose() + 10 * Eigen::Matrix3d::Identity();
}

double distance(const Pose2& a, const Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y) + std::abs(wrap_angle(a.yaw - b.yaw));
}

bool same_bits(const Pose2& a, const Pose2& b) {
  return a.x == b.x && a.y == b.y && a.yaw == b.yaw;
}

Constraint measured(const std::vector<Pose2>& truth, std::size_t from, std::size_t to, Rng& rng) {
  return {from, to, between(truth[from], truth[to]), random_information(rng), false};
}

/// Twice the negative log likelihood.
double cost(const PoseGraph& graph) {
  double sum = 0;
  for (const Constraint& constraint : graph.constraints()) sum += graph.squared_error(constraint);
  return sum;
}

TEST(PoseGraph, ErrorOfAConstraint) {
  PoseGraph graph;
  graph.add_node({1, 1, M_PI / 2});
  graph.add_node({1, 3, M_PI});
  Constraint constraint{0, 1, {1.5, 0.25, M_PI / 2 - 0.1}, Eigen::Vector3d(4, 16, 100).asDiagonal(), false};
  const Eigen::Vector3d error = graph.error(constraint);
  EXPECT_NEAR(error.x(), 0.5, 1e-12);
  EXPECT_NEAR(error.y(), -0.25, 1e-12);
  EXPECT_NEAR(error.z(), 0.1, 1e-12);
  EXPECT_NEAR(graph.squared_error(constraint), 1 + 1 + 1, 1e-9);
  constraint.from_T_to.yaw = -M_PI / 2 - 0.2;
  EXPECT_NEAR(std::abs(graph.error(constraint).z()), M_PI - 0.2, 1e-9) << "the short way round";
}

TEST(PoseGraph, ALoopWithoutErrorIsExact) {
  Rng rng(1);
  std::vector<Pose2> truth;
  for (int i = 0; i < 16; ++i) {
    const double angle = 2 * M_PI * i / 16;
    truth.push_back({5 + 3 * std::cos(angle), 3 * std::sin(angle), wrap_angle(angle + M_PI / 2)});
  }
  PoseGraph graph;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Pose2 off = i == 0 ? Pose2{} : random_pose(rng, 0.3, 0.2);
    graph.add_node(compose(truth[i], off));
  }
  for (std::size_t i = 0; i < truth.size(); ++i) graph.add(measured(truth, i, (i + 1) % truth.size(), rng));
  ASSERT_TRUE(graph.optimize(0, 20));
  EXPECT_TRUE(same_bits(graph.poses()[0], truth[0]));
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_LT(distance(graph.poses()[i], truth[i]), 1e-6) << i;
}

TEST(PoseGraph, RandomChainsOptimizeToNoError) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    std::vector<Pose2> truth{random_pose(rng, 10, M_PI)};
    for (int i = 1; i < 40; ++i) truth.push_back(compose(truth.back(), random_pose(rng, 1.0, 1.0)));
    PoseGraph graph;
    for (std::size_t i = 0; i < truth.size(); ++i)
      graph.add_node(i == 0 ? truth[0] : compose(truth[i], random_pose(rng, 0.2, 0.1)));
    for (std::size_t i = 1; i < truth.size(); ++i) graph.add(measured(truth, i - 1, i, rng));
    for (int k = 0; k < 15; ++k) {
      const auto from = static_cast<std::size_t>(rng.integer(0, 39));
      const auto to = static_cast<std::size_t>(rng.integer(0, 39));
      if (from != to) graph.add(measured(truth, from, to, rng));  // backwards, too
    }
    ASSERT_TRUE(graph.optimize(0, 30));
    EXPECT_TRUE(same_bits(graph.poses()[0], truth[0])) << "node 0 stays";
    for (const Constraint& constraint : graph.constraints()) EXPECT_LT(graph.error(constraint).norm(), 1e-6);
  }
}

// The analytic Jacobians lead to where the numeric gradient of the cost is zero, and nowhere else.
TEST(PoseGraph, OptimizedIsWhereTheCostIsStationary) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    PoseGraph graph;
    Pose2 at = random_pose(rng, 3, 3);
    for (int i = 0; i < 8; ++i) {
      graph.add_node(at);
      at = compose(at, random_pose(rng, 1, 1));
    }
    const auto start = graph.poses();
    for (int k = 0; k < 20; ++k) {
      const auto from = static_cast<std::size_t>(k < 7 ? k : rng.integer(0, 7));
      const auto to = static_cast<std::size_t>(k < 7 ? k + 1 : rng.integer(0, 7));
      if (from == to) continue;
      const Pose2 seen =
          compose(between(start[from], start[to]), random_pose(rng, 0.1, 0.05));  // they disagree
      graph.add({from, to, seen, random_information(rng), false});
    }
    const double before = cost(graph);
    ASSERT_TRUE(graph.optimize(0, 50));
    const double after = cost(graph);
    EXPECT_LT(after, before);
    EXPECT_GT(after, 0.01);
    constexpr double kStep = 1e-4;
    const auto optimized = graph.poses();
    for (std::size_t node = 1; node < optimized.size(); ++node)
      for (double Pose2::*coordinate : {&Pose2::x, &Pose2::y, &Pose2::yaw}) {
        auto poses = optimized;
        poses[node].*coordinate += kStep;
        graph.set_poses(poses);
        const double up = cost(graph);
        poses[node].*coordinate -= 2 * kStep;
        graph.set_poses(poses);
        const double down = cost(graph);
        const double gradient = (up - down) / (2 * kStep);
        const double curvature = (up - 2 * after + down) / (kStep * kStep);
        EXPECT_GT(curvature, 0);
        EXPECT_LT(std::abs(gradient / curvature), 1e-4) << "how far off the lowest point is";
      }
  }
}

TEST(PoseGraph, AWrongLoopClosureLosesAgainstManyRight) {
  Rng rng(3);
  std::vector<Pose2> truth;
  for (int i = 0; i < 40; ++i) truth.push_back({0.5 * (i % 20), i < 20 ? 0.0 : 1.0, 0});
  PoseGraph graph;
  const Eigen::Matrix3d step_information = Eigen::Vector3d(2500, 2500, 10000).asDiagonal();
  Pose2 at = truth[0];
  for (std::size_t i = 0; i < truth.size(); ++i) {
    graph.add_node(at);
    if (i + 1 == truth.size()) break;
    Pose2 step = between(truth[i], truth[i + 1]);
    step = {step.x + rng.normal(0, 0.005), step.y + rng.normal(0, 0.005), step.yaw + rng.normal(0, 0.002)};
    graph.add({i, i + 1, step, step_information, false});
    at = compose(at, step);
  }
  const Eigen::Matrix3d loop_closure_information = Eigen::Vector3d(1e4, 1e4, 4e4).asDiagonal();
  for (std::size_t i = 0; i < 10; ++i) {
    const std::size_t to = 20 + 2 * i;
    graph.add({2 * i, to, between(truth[2 * i], truth[to]), loop_closure_information, true});
  }
  graph.add({3, 33, {2.0, 3.0, 1.0}, loop_closure_information, true});
  ASSERT_TRUE(graph.optimize(0, 20));
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_LT(distance(graph.poses()[i], truth[i]), 0.1) << i;
}

TEST(PoseGraph, AWindowLeavesTheOthers) {
  Rng rng(4);
  PoseGraph graph;
  std::vector<Pose2> truth{{}};
  for (int i = 1; i < 30; ++i) truth.push_back(compose(truth.back(), {0.5, 0, 0.1}));
  for (const Pose2& pose : truth) graph.add_node(compose(pose, random_pose(rng, 0.1, 0.05)));
  for (std::size_t i = 1; i < truth.size(); ++i) graph.add(measured(truth, i - 1, i, rng));
  const auto before = graph.poses();
  const double cost_before = cost(graph);
  ASSERT_TRUE(graph.optimize(20, 10));
  for (std::size_t i = 0; i < 20; ++i) EXPECT_TRUE(same_bits(graph.poses()[i], before[i])) << i;
  for (std::size_t i = 20; i < 30; ++i) EXPECT_FALSE(same_bits(graph.poses()[i], before[i])) << i;
  EXPECT_LT(cost(graph), cost_before);
  for (std::size_t i = 20; i < 30; ++i) EXPECT_LT(graph.error(graph.constraints()[i - 1]).norm(), 1e-6);
}

TEST(PoseGraph, SmallAndHostileOnes) {
  PoseGraph graph;
  EXPECT_TRUE(graph.optimize(0, 5));
  graph.add_node({1, 2, 3});
  EXPECT_TRUE(graph.optimize(0, 5));
  graph.add_node({4, 5, 6});
  EXPECT_TRUE(graph.optimize(0, 5)) << "a node that nothing holds";
  EXPECT_NEAR(graph.poses()[1].x, 4, 1e-9);
  EXPECT_TRUE(graph.optimize(7, 5)) << "a window past the end";
  const auto before = graph.poses();
  Constraint broken{0, 1, {1, 0, 0}, Eigen::Matrix3d::Identity(), false};
  broken.information(0, 0) = std::numeric_limits<double>::quiet_NaN();
  graph.add(broken);
  EXPECT_FALSE(graph.optimize(0, 5));
  EXPECT_TRUE(same_bits(graph.poses()[0], before[0]));
  EXPECT_TRUE(same_bits(graph.poses()[1], before[1])) << "nothing moves then";
}

/// A closed square of 40 steps that veer, as an open path.
PoseGraph veering_square(std::vector<Pose2>& truth) {
  PoseGraph graph;
  truth.assign(1, {});
  graph.add_node({});
  for (std::size_t i = 0; i < 40; ++i) {
    const double corner = i % 10 == 9 ? M_PI / 2 : 0.0;
    truth.push_back(compose(truth.back(), {1, 0, corner}));
    const Pose2 step{1, 0, corner + 0.01};
    graph.add_node(compose(graph.poses().back(), step));
    graph.add({i, i + 1, step, Eigen::Vector3d(1e4, 1e4, 1e4).asDiagonal(), false});
  }
  return graph;
}

TEST(PoseGraph, GraduallyClosesALoopThatIsFarOff) {
  std::vector<Pose2> truth;
  PoseGraph graph = veering_square(truth);
  const Eigen::Matrix3d sharp = Eigen::Vector3d(1e6, 1e6, 1e7).asDiagonal();
  graph.add({0, 40, truth[40], sharp, true});
  graph.add({1, 39, between(truth[1], truth[39]), sharp, true});
  ASSERT_GT(distance(graph.poses()[40], truth[40]), 1.0);
  PoseGraph timid = graph;
  ASSERT_TRUE(timid.optimize(0, 20));
  EXPECT_GT(distance(timid.poses()[40], truth[40]), 0.5) << "the robust loss alone takes it for wrong";
  ASSERT_TRUE(graph.optimize_gradually());
  EXPECT_LT(distance(graph.poses()[40], truth[40]), 0.05);
}

TEST(PoseGraph, GraduallyLeavesOutWhatTheOthersContradict) {
  std::vector<Pose2> truth;
  PoseGraph graph = veering_square(truth);
  const Eigen::Matrix3d information = Eigen::Vector3d(1e4, 1e4, 1e4).asDiagonal();
  for (std::size_t i = 0; i < 5; ++i)
    graph.add({i, 40 - i, between(truth[i], truth[40 - i]), information, true});
  const Constraint wrong{5, 35, {3, 7, 1}, information, true};
  graph.add(wrong);
  ASSERT_TRUE(graph.optimize_gradually());
  EXPECT_LT(distance(graph.poses()[40], truth[40]), 0.1);
  EXPECT_GT(graph.squared_error(wrong), PoseGraph::kDoubtfulSquaredError);
}

}  // namespace
}  // namespace extperfc::mapping
