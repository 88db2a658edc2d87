// Finding a robot that was never known, or is lost.
#include <gtest/gtest.h>

#include "test/unit/localize/drive.hpp"

namespace extperfc::localize {
namespace {

/// Poses in rooms with distinct features, and in the corridor.
std::vector<Pose2> start_poses() {
  return {{2.6, 4.5, 1},    {10.5, 3.5, -2}, {12.8, 4.8, 0.3}, {4.5, 9.5, 2.5},
          {16.4, 11, -0.7}, {22.5, 9, 3},    {10.8, 11.5, 0.5}};
}

TEST(Lost, GlobalLocalizationOnTheMove) {
  const Plan plan = building();
  auto params = test_params();
  params.max_particles = 5000;
  auto localizer = Localizer::make(params, plan.map());
  ASSERT_TRUE(localizer);
  for (const Pose2& start : start_poses()) {
    Drive drive(plan, start, 21);
    localizer->initialize_globally();
    for (int i = 0; i < 10; ++i) {
      drive.move({0.05, 0, 0.25});
      ASSERT_TRUE(localizer->update(drive.scan(), drive.odom()));
    }
    EXPECT_TRUE(at_truth(localizer->estimate(), drive.truth()))
        << start.x << " " << start.y << ": " << localizer->estimate().pose.x << " "
        << localizer->estimate().pose.y;
    EXPECT_GT(localizer->estimate().cluster_weight, 0.9);
  }
}

TEST(Lost, GlobalLocalizationWithTheBeamModel) {
  const Plan plan = room();
  auto params = test_params();
  params.sensor_model = SensorModel::kBeam;
  params.laser_max_beams = 30;
  auto localizer = Localizer::make(params, plan.map());
  ASSERT_TRUE(localizer);
  Drive drive(plan, {5, 4.5, 2}, 22);
  EXPECT_TRUE(updates_until_found(*localizer, drive, 40));
}

TEST(Lost, KidnappedAndSetDownSomewhereElse) {
  const Plan plan = building();
  auto localizer = Localizer::make(test_params(), plan.map());
  ASSERT_TRUE(localizer);
  Drive drive(plan, {12, 7, 0}, 23);
  ASSERT_TRUE(localizer->set_pose(drive.truth(), 0.01 * Eigen::Matrix3d::Identity()));
  for (int i = 0; i < 20; ++i) {
    drive.move({0.2, 0, 0});
    ASSERT_TRUE(localizer->update(drive.scan(), drive.odom()));
  }
  ASSERT_TRUE(at_truth(localizer->estimate(), drive.truth()));
  for (const Pose2& start : start_poses()) {
    drive.carry_to(start);
    const auto updates = updates_until_found(*localizer, drive, 100);  // 10 s of scans at 10 Hz
    EXPECT_TRUE(updates) << start.x << " " << start.y << ": " << localizer->estimate().pose.x << " "
                         << localizer->estimate().pose.y << " fit " << localizer->estimate().fit;
    RecordProperty("updates", updates.value_or(-1));
  }
}

/// A wrong room that looks nearly alike fits well enough for the averages to recover.
TEST(Lost, KidnappedIntoRoomsThatLookAlike) {
  const Plan plan = building();
  for (const std::uint64_t seed : {1, 9}) {
    auto params = test_params();
    params.seed = seed;
    auto localizer = Localizer::make(params, plan.map());
    ASSERT_TRUE(localizer);
    Drive drive(plan, {12, 7, 0}, 23 + seed);
    ASSERT_TRUE(localizer->set_pose(drive.truth(), 0.01 * Eigen::Matrix3d::Identity()));
    for (int i = 0; i < 20; ++i) {
      drive.move({0.2, 0, 0});
      ASSERT_TRUE(localizer->update(drive.scan(), drive.odom()));
    }
    for (const Pose2& start : start_poses()) {
      drive.carry_to(start);
      EXPECT_TRUE(updates_until_found(*localizer, drive, 30))
          << "seed " << seed << ": " << start.x << " " << start.y << " taken for "
          << localizer->estimate().pose.x << " " << localizer->estimate().pose.y;
    }
  }
}

TEST(Lost, WrongFirstPose) {
  const Plan plan = building();
  auto localizer = Localizer::make(test_params(), plan.map());
  ASSERT_TRUE(localizer);
  Drive drive(plan, {2.6, 4.5, 1}, 24);
  ASSERT_TRUE(localizer->set_pose({16.4, 11, 0}, 0.01 * Eigen::Matrix3d::Identity()));
  EXPECT_TRUE(updates_until_found(*localizer, drive, 100));
}

TEST(Lost, WithoutRecoveryTheRobotStaysWhereItIsThoughtToBe) {
  const Plan plan = building();
  auto params = test_params();
  params.recovery_alpha_slow = 0;
  auto localizer = Localizer::make(params, plan.map());
  ASSERT_TRUE(localizer);
  Drive drive(plan, {2.6, 4.5, 1}, 25);
  const Pose2 wrong{16.4, 11, 0};
  ASSERT_TRUE(localizer->set_pose(wrong, 0.01 * Eigen::Matrix3d::Identity()));
  for (int i = 0; i < 60; ++i) ASSERT_TRUE(localizer->update(drive.scan(), drive.odom(), true));
  EXPECT_LT(apart_m(localizer->estimate().pose, wrong), 3);
}

TEST(Lost, WheelsThatTurnWhileTheRobotIsStuck) {
  const Plan plan = building();
  auto params = test_params();
  params.odom_alpha1 = params.odom_alpha2 = params.odom_alpha3 = params.odom_alpha4 = params.odom_alpha5 =
      0.005;
  auto localizer = Localizer::make(params, plan.map());
  ASSERT_TRUE(localizer);
  for (const Pose2& start : start_poses())
    for (const double yaw : {0.35, -0.35}) {
      Drive drive(plan, start, 28);
      ASSERT_TRUE(localizer->set_pose(start, 0.002 * Eigen::Matrix3d::Identity()));
      for (int i = 0; i < 10; ++i) ASSERT_TRUE(localizer->update(drive.scan(), drive.odom(), true));
      drive.slip({0.25, 0, yaw});
      const auto updates = updates_until_found(*localizer, drive, 20);
      EXPECT_TRUE(updates) << start.x << " " << start.y << ": " << localizer->estimate().pose.x << " "
                           << localizer->estimate().pose.y << " " << localizer->estimate().pose.yaw;
      RecordProperty("updates", updates.value_or(-1));
    }
}

TEST(Lost, PeopleAroundARobotThatStandsDoNotMoveIt) {
  const Plan plan = building();
  auto localizer = Localizer::make(test_params(), plan.map());
  ASSERT_TRUE(localizer);
  Drive drive(plan, {10.5, 3.5, -2}, 26);
  ASSERT_TRUE(localizer->set_pose(drive.truth(), 0.01 * Eigen::Matrix3d::Identity()));
  Rng rng(27);
  for (int i = 0; i < 100; ++i) {
    auto scan = drive.scan();
    const int from = rng.integer(0, 179);
    for (int k = 0; k < 54; ++k) {  // three tenths of the view
      float& range = scan.ranges[static_cast<std::size_t>((from + k) % 180)];
      range = std::min(range, static_cast<float>(0.8 + rng.normal(0, 0.05)));
    }
    ASSERT_TRUE(localizer->update(scan, drive.odom(), true));
    ASSERT_LT(apart_m(localizer->estimate().pose, drive.truth()), 0.2) << i;
  }
}

}  // namespace
}  // namespace extperfc::localize
