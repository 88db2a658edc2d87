// The back end alone: key frames of a room and steps between them that drift, as a tracker's do.
#include <numeric>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "mapping/path_filter.hpp"
#include "test/support/planar_world.hpp"

namespace extperfc::mapping {
namespace {

struct Drifting {
  std::vector<Pose2> truth;  ///< seen from the first
  std::vector<TrackedStep> steps;
  std::vector<KeyFrame> frames;
};

/// Rounds through the room. Each step is rotated a little too far to the left.
Drifting drive(int rounds, std::uint64_t seed) {
  std::vector<Eigen::Vector2d> corners{{-3, -1.5}};
  for (int i = 0; i < rounds; ++i)
    for (const Eigen::Vector2d& corner : {Eigen::Vector2d(2, -1.5), Eigen::Vector2d(3, 1),
                                          Eigen::Vector2d(0, 1.2), Eigen::Vector2d(-3, -1.5)})
      corners.push_back(corner);
  const auto route = planar_drive(corners, 0.3, 0.3);
  const PlanarWorld room = planar_room();
  const PlanarScanner scanner;
  Rng rng(seed);
  Drifting drive;
  double distance_m = 0;
  for (std::size_t i = 0; i < route.size(); ++i) {
    drive.truth.push_back(between(route.front(), route[i]));
    const Pose2 step = i == 0 ? Pose2{} : between(route[i - 1], route[i]);
    const double step_m = std::hypot(step.x, step.y);
    distance_m += step_m;
    TrackedStep tracked;
    tracked.step = {step.x + rng.normal(0, 0.002), step.y + rng.normal(0, 0.002),
                    step.yaw + 0.002 + rng.normal(0, 0.001)};
    tracked.information = Eigen::Vector3d(1e4, 1e4, 1e5).asDiagonal();
    tracked.distance_m = step_m;
    drive.steps.push_back(tracked);
    drive.frames.push_back({i, distance_m, scan_points(scanner.scan(room, route[i], rng), {})});
  }
  return drive;
}

double error_m(const Pose2& truth, const Pose2& pose) {
  const Pose2 off = between(truth, pose);
  return std::hypot(off.x, off.y);
}

TEST(PathFilter, BeginsAtTheGivenPose) {
  const auto driven = drive(1, 1);
  PathFilter filter({7, 0.5, 1});
  filter.begin({1, 2, 0.5}, driven.frames[0]);
  ASSERT_EQ(filter.poses().size(), 1U);
  EXPECT_EQ(filter.poses()[0].x, 1);
  ASSERT_EQ(filter.particles().size(), 7U);
  EXPECT_NEAR(filter.effective_particles(), 7, 1e-9);
  EXPECT_NEAR(filter.entropy(), std::log(7.0), 1e-9);
  EXPECT_LT(filter.covariance().cwiseAbs().maxCoeff(), 1e-20);
}

TEST(PathFilter, FollowsTheStepsWhereNothingIsOld) {
  const auto driven = drive(1, 2);
  PathFilter filter({50, 0.5, 1});
  filter.begin({}, driven.frames[0]);
  Pose2 expected;
  for (std::size_t i = 1; i < 12; ++i) {
    expected = compose(expected, driven.steps[i].step);
    const auto step = filter.add(driven.steps[i], driven.frames[i]);
    EXPECT_FALSE(step.accepted) << i;
    EXPECT_NEAR(filter.poses().back().x, expected.x, 1e-9);
    EXPECT_NEAR(filter.poses().back().yaw, expected.yaw, 1e-9);
  }
  // Each step spreads the particles by a centimetre or less: some centimetres after eleven.
  const double spread = std::sqrt(filter.covariance()(0, 0) + filter.covariance()(1, 1));
  EXPECT_GT(spread, 0.01);
  EXPECT_LT(spread, 0.15);
}

TEST(PathFilter, RoundsDoNotDriftApart) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SCOPED_TRACE(seed);
    const auto driven = drive(4, seed);
    PathFilter filter({30, 0.5, seed});
    filter.begin({}, driven.frames[0]);
    Pose2 dead_reckoned;
    std::size_t accepted_loops = 0;
    for (std::size_t i = 1; i < driven.steps.size(); ++i) {
      dead_reckoned = compose(dead_reckoned, driven.steps[i].step);
      if (filter.add(driven.steps[i], driven.frames[i]).accepted) ++accepted_loops;
      const auto weights = filter.weights();
      ASSERT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0), 1.0, 1e-9);
      const Eigen::Matrix3d covariance = filter.covariance();
      ASSERT_TRUE(covariance.allFinite());
      ASSERT_EQ(Eigen::LLT<Eigen::Matrix3d>(covariance + 1e-12 * Eigen::Matrix3d::Identity()).info(),
                Eigen::Success);
    }
    filter.finish();
    EXPECT_GT(accepted_loops, 0U);
    EXPECT_GT(error_m(driven.truth.back(), dead_reckoned), 0.6) << "the steps alone drift";
    for (std::size_t i = 0; i < driven.truth.size(); ++i)
      ASSERT_LT(error_m(driven.truth[i], filter.poses()[i]), 0.15) << i;
  }
}

TEST(PathFilter, SameSeedSamePath) {
  const auto driven = drive(2, 4);
  PathFilter first({20, 0.5, 9});
  PathFilter second({20, 0.5, 9});
  first.begin({}, driven.frames[0]);
  second.begin({}, driven.frames[0]);
  for (std::size_t i = 1; i < driven.steps.size(); ++i) {
    (void)first.add(driven.steps[i], driven.frames[i]);
    (void)second.add(driven.steps[i], driven.frames[i]);
    ASSERT_EQ(first.poses().back().x, second.poses().back().x) << i;
    ASSERT_EQ(first.effective_particles(), second.effective_particles()) << i;
  }
}

TEST(PathFilter, GoesOnAfterRestore) {
  const auto driven = drive(3, 5);
  const std::size_t half = driven.steps.size() / 2;
  PathFilter filter({30, 0.5, 1});
  filter.begin({}, driven.frames[0]);
  for (std::size_t i = 1; i < half; ++i) (void)filter.add(driven.steps[i], driven.frames[i]);
  PathFilter restored({30, 0.5, 1});
  restored.restore(filter.frames(), filter.graph());
  EXPECT_EQ(restored.poses().size(), filter.poses().size());
  EXPECT_EQ(restored.poses().back().x, filter.poses().back().x);
  for (std::size_t i = half; i < driven.steps.size(); ++i)
    (void)restored.add(driven.steps[i], driven.frames[i]);
  restored.finish();
  EXPECT_LT(error_m(driven.truth.back(), restored.poses().back()), 0.15);
  EXPECT_EQ(restored.frames().size(), driven.frames.size());
}

}  // namespace
}  // namespace extperfc::mapping
