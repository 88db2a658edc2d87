#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/arm/joint_path.hpp"

#include "test/unit/arm/trajectory/random_motion.hpp"

namespace extperfc::arm {
namespace {

JointVector pair_of(double a, double b) {
  JointVector vector(2);
  vector << a, b;
  return vector;
}

JointPath make(const std::vector<JointVector>& waypoints, double deviation_rad) {
  JointPathParams params;
  params.deviation_rad = deviation_rad;
  const auto path = JointPath::make(waypoints, params);
  EXPECT_TRUE(path) << path.error().message;
  return *path;
}

std::size_t stops(const JointPath& path) {
  std::size_t count = 0;
  for (const auto& piece : path.pieces()) count += piece.stop_after ? 1 : 0;
  return count;
}

TEST(JointPath, TwoWaypointsAreOneLine) {
  const auto path = make({pair_of(0, 1), pair_of(3, 5)}, 0.1);
  EXPECT_DOUBLE_EQ(path.length(), 5);
  ASSERT_EQ(path.pieces().size(), 1U);
  EXPECT_TRUE(path.at(2.5).position.isApprox(pair_of(1.5, 3)));
  EXPECT_TRUE(path.at(2.5).tangent.isApprox(pair_of(0.6, 0.8)));
  EXPECT_EQ(path.at(99).position, pair_of(3, 5));
  EXPECT_EQ(path.deviation_rad(), 0);
}

// A right angle with room: the middle of the corner is 3/16 L sqrt(2) from the waypoint, by the header's
// formula, and no place is further from the lines than the waypoint's bound.
TEST(JointPath, RightAngleLeavesTheCornerByThePermittedDeviation) {
  const double permitted = 0.05;
  const auto path = make({pair_of(0, 0), pair_of(1, 0), pair_of(1, 1)}, permitted);
  EXPECT_NEAR(path.deviation_rad(), permitted, 1e-12);
  EXPECT_NEAR((path.at(1.0).position - pair_of(1, 0)).norm(), permitted, 1e-12);
  ASSERT_EQ(path.pieces().size(), 3U);
  EXPECT_NEAR(path.pieces()[1].length, 2 * permitted * 16 / (3 * std::sqrt(2.0)), 1e-12);
}

TEST(JointPath, DerivativesAndBordersAreSmooth) {
  Rng rng(11);
  for (int trial = 0; trial < 50; ++trial) {
    const auto path = make(random_waypoints(rng, 7, 6, 1.0), 0.1);
    const double step = 1e-5;
    for (int i = 1; i < 400; ++i) {
      const double s = path.length() * i / 400;
      const auto before = path.at(s - step);
      const auto here = path.at(s);
      const auto behind = path.at(s + step);
      const JointVector slope = (behind.position - before.position) / (2 * step);
      const JointVector bend = (behind.tangent - before.tangent) / (2 * step);
      EXPECT_LT((slope - here.tangent).norm(), 1e-6) << "trial " << trial << " s " << s;
      // The third derivative jumps at the borders of corners: up to 6 |direction_change| / length^2 times the
      // step.
      EXPECT_LT((bend - here.curvature).norm(), 0.02) << "trial " << trial << " s " << s;
    }
    for (std::size_t p = 1; p < path.pieces().size(); ++p) {
      const auto& piece = path.pieces()[p - 1];
      if (piece.stop_after) continue;
      const auto left = evaluate(piece, piece.length);
      const auto right = evaluate(path.pieces()[p], 0);
      EXPECT_LT((left.position - right.position).norm(), 1e-12);
      EXPECT_LT((left.tangent - right.tangent).norm(), 1e-12);
      EXPECT_LT((left.curvature - right.curvature).norm(), 1e-9);
    }
  }
}

TEST(JointPath, StaysWithinTheDeviationOfTheLinesAndInsideTheirBox) {
  Rng rng(12);
  for (int trial = 0; trial < 100; ++trial) {
    const double permitted = std::pow(10.0, rng.uniform(-4, -0.3));
    const auto waypoints = random_waypoints(rng, trial % 2 ? 7 : 14, 8, 0.8);
    const auto path = make(waypoints, permitted);
    EXPECT_LE(path.deviation_rad(), permitted * (1 + 1e-12));
    JointVector low = waypoints[0];
    JointVector high = waypoints[0];
    for (const auto& waypoint : waypoints) {
      low = low.cwiseMin(waypoint).eval();
      high = high.cwiseMax(waypoint).eval();
    }
    double furthest = 0;
    for (int i = 0; i <= 1000; ++i) {
      const auto q = path.at(path.length() * i / 1000).position;
      furthest = std::max(furthest, distance_to_polyline(q, waypoints));
      EXPECT_TRUE((q.array() >= low.array() - 1e-12).all() && (q.array() <= high.array() + 1e-12).all());
    }
    EXPECT_LE(furthest, path.deviation_rad() + 1e-12) << "trial " << trial;
    EXPECT_EQ(path.at(0).position, waypoints.front());
    EXPECT_EQ(path.at(path.length()).position, waypoints.back());
  }
}

TEST(JointPath, WithoutDeviationItStopsAtCorners) {
  const auto path = make({pair_of(0, 0), pair_of(1, 0), pair_of(1, 1), pair_of(0, 1)}, 0);
  EXPECT_EQ(stops(path), 2U);
  EXPECT_EQ(path.pieces().size(), 3U);
  EXPECT_EQ(path.deviation_rad(), 0);
}

TEST(JointPath, AWaypointOnTheLineIsNoCorner) {
  std::vector<JointVector> waypoints;
  for (int i = 0; i <= 20; ++i) waypoints.push_back(pair_of(0.1 * i, 0.3 * i / 7));
  const auto path = make(waypoints, 0);
  EXPECT_EQ(stops(path), 0U);
  EXPECT_LT(path.deviation_rad(), 1e-9);
}

TEST(JointPath, TurningBackStopsAtTheWaypointRegardlessOfDeviation) {
  const auto path = make({pair_of(0, 0), pair_of(1, 0), pair_of(0, 0.01)}, 0.2);
  EXPECT_EQ(stops(path), 1U);
  EXPECT_EQ(path.deviation_rad(), 0);
}

TEST(JointPath, EachCornerMayHaveItsOwnDeviation) {
  JointPathParams params;
  params.corner_deviation_rad = {0, 0.01, 0, 0.04, 0};
  const std::vector<JointVector> waypoints{pair_of(0, 0), pair_of(1, 0), pair_of(1, 1), pair_of(2, 1),
                                           pair_of(2, 2)};
  const auto path = JointPath::make(waypoints, params);
  ASSERT_TRUE(path);
  EXPECT_EQ(stops(*path), 1U);
  EXPECT_NEAR((path->at(1).position - waypoints[1]).norm(), 0.01, 1e-12);
  EXPECT_NEAR((path->at(2).position - waypoints[2]).norm(), 0, 1e-12);
  EXPECT_NEAR((path->at(3).position - waypoints[3]).norm(), 0.04, 1e-12);
}

TEST(JointPath, RepeatedWaypointsCollapse) {
  const auto path = make(
      {pair_of(0, 0), pair_of(0, 0), pair_of(1, 0), pair_of(1, 1e-10), pair_of(1, 1), pair_of(1, 1)}, 0.05);
  EXPECT_NEAR(path.length(), 2, 1e-9);
  EXPECT_EQ(path.pieces().size(), 3U);
}

TEST(JointPath, OnePlaceIsAPathWithoutLength) {
  for (const auto& waypoints : {std::vector<JointVector>{pair_of(1, 2)},
                                std::vector<JointVector>{pair_of(1, 2), pair_of(1, 2), pair_of(1, 2)}}) {
    const auto path = make(waypoints, 0.05);
    EXPECT_EQ(path.length(), 0);
    EXPECT_TRUE(path.pieces().empty());
    EXPECT_EQ(path.at(0).position, pair_of(1, 2));
  }
}

TEST(JointPath, BadInputIsNamed) {
  const auto message = [](const std::vector<JointVector>& waypoints, const JointPathParams& params = {}) {
    const auto path = JointPath::make(waypoints, params);
    if (path) return std::string("none");
    EXPECT_EQ(path.error().code, ErrorCode::kInvalidArgument);
    return path.error().message;
  };
  EXPECT_NE(message({}).find("no waypoint"), std::string::npos);
  EXPECT_NE(message({JointVector()}).find("without joints"), std::string::npos);
  EXPECT_NE(message({pair_of(0, 0), JointVector::Zero(3)}).find("waypoint 1 has 3 joints"),
            std::string::npos);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message({pair_of(0, 0), pair_of(0, nan)}).find("waypoint 1 is not finite"), std::string::npos);
  JointPathParams params;
  for (const double bad : {-0.1, 1.5, nan}) {
    params.deviation_rad = bad;
    EXPECT_NE(message({pair_of(0, 0)}, params).find("deviation_rad"), std::string::npos) << bad;
  }
  params.deviation_rad = 0.1;
  params.corner_deviation_rad = {0.1};
  EXPECT_NE(message({pair_of(0, 0), pair_of(1, 0)}, params).find("1 values for 2"), std::string::npos);
}

}  // namespace
}  // namespace extperfc::arm
