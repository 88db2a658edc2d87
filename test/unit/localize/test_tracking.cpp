// Following a robot that knows about where it starts.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "test/unit/localize/drive.hpp"

namespace extperfc::localize {
namespace {

Localizer localizer_in(const LocalizerParams& params, const std::shared_ptr<const OccupancyGrid>& map) {
  auto made = Localizer::make(params, map);
  EXPECT_TRUE(made) << made.error().message;
  return std::move(*made);
}

const Eigen::Matrix3d kAbout = Eigen::Vector3d(0.09, 0.09, 0.04).asDiagonal();

double weight_sum(const Localizer& localizer) {
  double sum = 0;
  for (const auto& particle : localizer.particles()) sum += particle.weight;
  return sum;
}

struct Errors {
  double mean_m{0};
  double mean_rad{0};
  double worst_m{0};
};

/// A loop of 80 steps through the room, from (3.7, 3) around (4.7, 4).
Errors follow(LocalizerParams params, bool sideways, const Pose2& origin = {}) {
  const Plan plan = room();
  params.update_min_d = 0.1;  // every step of 0.2 m counts, for any odometry error
  auto localizer = localizer_in(params, plan.map(origin));
  Drive drive(plan, {4.7, 3.2, 0}, 3);
  EXPECT_TRUE(localizer.set_pose(compose(origin, {4.9, 3.1, 0.1}), kAbout));
  Errors errors;
  constexpr int kSteps = 80;
  constexpr int kSettled = 5;
  for (int i = 0; i < kSteps; ++i) {
    // The same circle with the nose ahead, or with the nose where it was at the start.
    const double angle = 2 * M_PI * i / 40;
    drive.move(sideways ? Pose2{0.2 * std::cos(angle), 0.2 * std::sin(angle), 0}
                        : Pose2{0.2, 0, 2 * M_PI / 40});
    const auto updated = localizer.update(drive.scan(), drive.odom());
    EXPECT_TRUE(updated && *updated);
    EXPECT_NEAR(weight_sum(localizer), 1, 1e-4);
    if (i < kSettled) continue;
    const Pose2 truth = compose(origin, drive.truth());
    const double off = apart_m(localizer.estimate().pose, truth);
    errors.mean_m += off / (kSteps - kSettled);
    errors.mean_rad += apart_rad(localizer.estimate().pose, truth) / (kSteps - kSettled);
    errors.worst_m = std::max(errors.worst_m, off);
    EXPECT_GT(localizer.estimate().fit, 0.9);
    EXPECT_EQ(localizer.estimate().covariance, localizer.estimate().covariance.transpose());
  }
  return errors;
}

TEST(Tracking, DifferentialDrive) {
  const auto errors = follow(test_params(), false);
  EXPECT_LT(errors.mean_m, 0.03);
  EXPECT_LT(errors.mean_rad, 0.01);
  EXPECT_LT(errors.worst_m, 0.1);
}

TEST(Tracking, SidewaysWithTheOmniModel) {
  auto params = test_params();
  params.odometry_model = OdometryModel::kOmni;
  const auto errors = follow(params, true);
  EXPECT_LT(errors.mean_m, 0.03);
  EXPECT_LT(errors.mean_rad, 0.01);
}

TEST(Tracking, BeamModel) {
  auto params = test_params();
  params.sensor_model = SensorModel::kBeam;
  params.laser_max_beams = 30;
  params.min_particles = 200;
  params.max_particles = 500;
  const auto errors = follow(params, false);
  EXPECT_LT(errors.mean_m, 0.04);
  EXPECT_LT(errors.mean_rad, 0.015);
}

TEST(Tracking, MapWithARotatedAndDistantOrigin) {
  for (const Pose2& origin : {Pose2{-3, 8, 1.1}, Pose2{400000, 5800000, -2.5}}) {
    const auto errors = follow(test_params(), false, origin);
    EXPECT_LT(errors.mean_m, 0.03);
    EXPECT_LT(errors.mean_rad, 0.01);
  }
}

TEST(Tracking, SameSeedSameResult) {
  const Plan plan = room();
  auto params = test_params();
  const auto run = [&](std::uint64_t seed) {
    params.seed = seed;
    auto localizer = localizer_in(params, plan.map());
    Drive drive(plan, {4, 4, 0}, 3);
    EXPECT_TRUE(localizer.set_pose({4, 4, 0}, kAbout));
    for (int i = 0; i < 10; ++i) {
      drive.move({0.2, 0, 0.1});
      EXPECT_TRUE(localizer.update(drive.scan(), drive.odom()));
    }
    return localizer.particles();
  };
  const auto first = run(5);
  const auto second = run(5);
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    ASSERT_EQ(first[i].pose.x, second[i].pose.x);
    ASSERT_EQ(first[i].pose.yaw, second[i].pose.yaw);
    ASSERT_EQ(first[i].weight, second[i].weight);
  }
  EXPECT_NE(run(6)[0].pose.x, first[0].pose.x);
}

TEST(Tracking, ScansThatSayNothingMoveTheParticlesWithOdometry) {
  const Plan plan = room();
  for (const auto model : {SensorModel::kLikelihoodField, SensorModel::kBeam}) {
    auto params = test_params();
    params.sensor_model = model;
    auto localizer = localizer_in(params, plan.map());
    ASSERT_TRUE(localizer.set_pose({4, 4, 0}, 1e-4 * Eigen::Matrix3d::Identity()));
    Drive drive(plan, {4, 4, 0}, 3);
    auto blind = drive.scan();
    ASSERT_TRUE(localizer.update(blind, drive.odom()));
    for (const float useless : {std::numeric_limits<float>::quiet_NaN(), 0.0F, -1.0F, 0.01F}) {
      blind.ranges.assign(blind.ranges.size(), useless);
      drive.move({0.3, 0, 0});
      const auto updated = localizer.update(blind, drive.odom());
      ASSERT_TRUE(updated && *updated);
      EXPECT_FALSE((*updated)->resampled);
      EXPECT_EQ((*updated)->fit, 0);
      EXPECT_NEAR(weight_sum(localizer), 1, 1e-4);
    }
    EXPECT_LT(apart_m(localizer.estimate().pose, drive.truth()), 0.2);
    blind.ranges.assign(blind.ranges.size(), std::numeric_limits<float>::infinity());
    drive.move({0.3, 0, 0});
    ASSERT_TRUE(localizer.update(blind, drive.odom())) << "everything beyond the range";
    EXPECT_TRUE(std::isfinite(localizer.estimate().pose.x));
    blind.ranges.assign(1, 2.0F);
    drive.move({0.3, 0, 0});
    ASSERT_TRUE(localizer.update(blind, drive.odom())) << "a single ray";
    EXPECT_NEAR(weight_sum(localizer), 1, 1e-4);
  }
}

TEST(Tracking, AnUpdateNeedsMotionOrForce) {
  const Plan plan = room();
  auto localizer = localizer_in(test_params(), plan.map());
  ASSERT_TRUE(localizer.set_pose({4, 4, 0}, kAbout));
  Drive drive(plan, {4, 4, 0}, 3);
  EXPECT_TRUE(*localizer.update(drive.scan(), drive.odom())) << "the first one";
  const Pose2 before = localizer.estimate().pose;
  EXPECT_FALSE(*localizer.update(drive.scan(), drive.odom()));
  EXPECT_FALSE(*localizer.update(drive.scan(), compose(drive.odom(), {0.15, 0, 0.1})));
  EXPECT_EQ(localizer.estimate().pose.x, before.x);
  EXPECT_TRUE(*localizer.update(drive.scan(), drive.odom(), true));
  EXPECT_TRUE(*localizer.update(drive.scan(), compose(drive.odom(), {0.21, 0, 0})));
  EXPECT_TRUE(*localizer.update(drive.scan(), compose(drive.odom(), {0.21, 0, 0.21})));
  ASSERT_TRUE(localizer.set_pose({4, 4, 0}, kAbout));
  EXPECT_TRUE(*localizer.update(drive.scan(), drive.odom())) << "the first one after a pose was set";
}

TEST(Tracking, ResamplesAtTheInterval) {
  const Plan plan = room();
  auto params = test_params();
  params.resample_interval = 3;
  auto localizer = localizer_in(params, plan.map());
  ASSERT_TRUE(localizer.set_pose({4, 4, 0}, kAbout));
  Drive drive(plan, {4, 4, 0}, 3);
  for (int i = 1; i <= 9; ++i) {
    const auto updated = localizer.update(drive.scan(), drive.odom(), true);
    ASSERT_TRUE(updated && *updated);
    EXPECT_EQ((*updated)->resampled, i % 3 == 0) << i;
  }
}

TEST(Tracking, FewerParticlesWhenTheyLieCloser) {
  const Plan plan = room();
  auto params = test_params();
  params.min_particles = 50;
  auto localizer = localizer_in(params, plan.map());
  ASSERT_TRUE(localizer.set_pose({4, 4, 0}, Eigen::Vector3d(0.25, 0.25, 0.2).asDiagonal()));
  EXPECT_EQ(localizer.particles().size(), 2000U);
  Drive drive(plan, {4, 4, 0}, 3);
  for (int i = 0; i < 12; ++i) ASSERT_TRUE(localizer.update(drive.scan(), drive.odom(), true));
  EXPECT_LT(localizer.particles().size(), 1500U);
  EXPECT_GE(localizer.particles().size(), 50U);
}

TEST(Tracking, SetPoseHasTheGivenMoments) {
  auto params = test_params();
  params.max_particles = 20000;
  auto localizer = localizer_in(params, room().map({2, 3, 0.8}));
  Eigen::Matrix3d covariance;
  covariance << 0.09, 0.03, 0.01, 0.03, 0.04, -0.005, 0.01, -0.005, 0.02;
  const Pose2 mean{5, 6, 3.1};
  ASSERT_TRUE(localizer.set_pose(mean, covariance));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const auto& p : localizer.particles()) {
    const Eigen::Vector3d off(p.pose.x - mean.x, p.pose.y - mean.y, wrap_angle(p.pose.yaw - mean.yaw));
    sum += p.weight * off;
    squares += p.weight * off * off.transpose();
  }
  const double root_n = std::sqrt(20000);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(sum[i], 0, 5 * std::sqrt(covariance(i, i)) / root_n);
    for (int j = 0; j < 3; ++j)
      EXPECT_NEAR(squares(i, j), covariance(i, j),
                  8 * std::sqrt(covariance(i, i) * covariance(j, j)) / root_n);
  }
}

TEST(Tracking, GlobalInitializationFillsTheFreeSpaceEvenly) {
  const Pose2 origin{-4, 7, 0.6};
  const auto map = room().map(origin);
  auto params = test_params();
  params.max_particles = 20000;
  auto localizer = localizer_in(params, map);
  ASSERT_TRUE(localizer.set_pose({0, 0, 0}, kAbout));
  localizer.initialize_globally();
  ASSERT_EQ(localizer.particles().size(), 20000U);
  EXPECT_NEAR(weight_sum(localizer), 1, 1e-4);
  int left = 0;
  int up = 0;
  for (const auto& p : localizer.particles()) {
    const Pose2 inside = between(origin, p.pose);
    const auto cell = map->cell_of(p.pose.x, p.pose.y);
    ASSERT_TRUE(cell) << inside.x << " " << inside.y;
    left += inside.x < 5.025;
    up += p.pose.yaw > 0;
  }
  EXPECT_NEAR(left, 10000, 400);  // of the free cells some hundred more stand on one side than on the other
  EXPECT_NEAR(up, 10000, 5 * 71);
}

TEST(Tracking, AnotherMapKeepsTheParticles) {
  const Plan plan = room();
  auto localizer = localizer_in(test_params(), plan.map());
  ASSERT_TRUE(localizer.set_pose({4, 4, 0.5}, kAbout));
  const auto before = localizer.particles();
  // The same room on a larger sheet: its corner lies elsewhere and is turned.
  ASSERT_TRUE(localizer.set_map(plan.map({-1, -2, 0.4})));
  const auto after = localizer.particles();
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    ASSERT_LT(apart_m(before[i].pose, after[i].pose), 1e-4);
    ASSERT_LT(apart_rad(before[i].pose, after[i].pose), 1e-5);
  }
}

TEST(Tracking, OdometryThatJumpsIsSurvived) {
  const Plan plan = room();
  auto localizer = localizer_in(test_params(), plan.map());
  Drive drive(plan, {4.5, 4, 0}, 3);
  ASSERT_TRUE(localizer.set_pose({4.5, 4, 0}, kAbout));
  ASSERT_TRUE(localizer.update(drive.scan(), drive.odom()));
  ASSERT_TRUE(localizer.update(drive.scan(), {1e7, -1e7, 3}));
  ASSERT_TRUE(std::isfinite(localizer.estimate().pose.x));
  ASSERT_TRUE(localizer.update(drive.scan(), drive.odom()));
  EXPECT_TRUE(updates_until_found(localizer, drive, 100));
}

}  // namespace
}  // namespace extperfc::localize
