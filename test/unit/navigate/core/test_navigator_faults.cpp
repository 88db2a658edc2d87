// Data that are missing, clocks that jump, and random sequences of events: the robot stands when it is blind,
// obeys its limits, and every task ends.
#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "test/unit/navigate/core/fake_robot.hpp"

namespace extperfc::navigate::test {
namespace {

TEST(NavigatorFaults, ItStandsWhileDataAreMissingAndGoesOnAfterwards) {
  for (const auto code : {NavCode::kNoOdometry, NavCode::kNoTransform, NavCode::kNoScan, NavCode::kNoMap,
                          NavCode::kLocalizationLost}) {
    FakeRobot robot;
    robot.drive_to({2, 0, 0});
    robot.run_for(1.0);
    ASSERT_GT(robot.velocity.vx, 0.2);
    robot.input.fault = NavError{code, "silent"};
    robot.input.costs = nullptr;
    robot.input.footprint = nullptr;
    EXPECT_TRUE(is_zero(robot.cycle().command)) << "at once";
    EXPECT_EQ(robot.events.back(), "stopped: silent");
    EXPECT_EQ(robot.navigator.reason(), "silent");
    robot.run_for(5.0);
    EXPECT_TRUE(robot.ends.empty());
    robot.input.fault.reset();
    robot.input.costs = &robot.costs;
    robot.input.footprint = &robot.footprint;
    ASSERT_TRUE(robot.run());
    EXPECT_EQ(robot.ends[0].error.code, NavCode::kSuccess);
  }
}

TEST(NavigatorFaults, ItGivesUpAfterItsPatience) {
  FakeRobot robot;
  robot.drive_to({2, 0, 0});
  robot.run_for(0.5);
  robot.input.fault = NavError{NavCode::kNoScan, "the lidar is silent"};
  const double since_s = robot.now_s;
  ASSERT_TRUE(robot.run(100));
  EXPECT_NEAR(robot.now_s - since_s, robot.params_.data_patience_s, 0.2);
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kNoScan);
}

TEST(NavigatorFaults, DataThatComeAndGoDoNotMakePatienceEndless) {
  const NavError blocked{NavCode::kGoalBlocked, "the goal is blocked"};
  double lasted_s[2];
  for (const bool flickers : {false, true}) {
    FakeRobot robot;
    robot.plan_error = blocked;
    robot.drive_to({2, 0, 0});
    const double begin_s = robot.now_s;
    for (int i = 0; robot.ends.empty() && robot.now_s < begin_s + 600; ++i) {
      robot.input.fault.reset();
      if (flickers && i % 20 < 4)
        robot.input.fault = NavError{NavCode::kNoScan, "the newest scan is 0.36 s old"};
      robot.cycle();
    }
    ASSERT_EQ(robot.ends.size(), 1U) << flickers;
    EXPECT_EQ(robot.ends[0].error.code, NavCode::kGoalBlocked);
    lasted_s[flickers ? 1 : 0] = robot.now_s - begin_s;
  }
  EXPECT_LT(lasted_s[1], 1.5 * lasted_s[0]) << "a fifth of the time it was blind";
}

TEST(NavigatorFaults, AWaypointTaskEndsAsAWholeWithoutData) {
  FakeRobot robot;
  (void)robot.navigator.start({1, {{2, 0, 0}, {3, 0, 0}}, false});
  robot.input.fault = NavError{NavCode::kNoScan, "the lidar is silent"};
  ASSERT_TRUE(robot.run(100));
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kNoScan);
  EXPECT_FALSE(robot.navigator.active());
}

TEST(NavigatorFaults, JumpsOfTheClockAreNoTime) {
  for (const double jump_s : {-1000.0, 1000.0, -1e9, 1e9}) {
    FakeRobot robot;
    robot.drive_to({2, 0, 0});
    robot.run_for(0.5);
    robot.now_s += jump_s;
    ASSERT_TRUE(robot.run(60)) << jump_s;
    EXPECT_EQ(robot.ends[0].error.code, NavCode::kSuccess) << jump_s;
    EXPECT_TRUE(robot.events.empty()) << robot.events.front();
  }
}

TEST(NavigatorFaults, AfterAJumpOfThePoseItPlansAgain) {
  FakeRobot robot;
  robot.drive_to({2, 0, 0});
  robot.run_for(1.0);
  robot.pose = {-2, 2, 1};
  robot.input.jumped = true;
  const auto before = robot.wishes.size();
  (void)robot.cycle();
  ASSERT_EQ(robot.wishes.size(), before + 1);
  EXPECT_EQ(robot.wishes.back().request.start.x, -2);
  EXPECT_TRUE(robot.wishes.back().current.poses.empty());
  ASSERT_TRUE(robot.run());
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kSuccess);
}

TEST(NavigatorFaults, APlannerThatNeverAnswersEndsTheGoal) {
  FakeRobot robot;
  robot.answers = false;
  robot.drive_to({2, 0, 0});
  ASSERT_TRUE(robot.run(300));
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kPlanTimeout);
}

TEST(NavigatorFaults, AWildLocalPlannerIsLimited) {
  FakeRobot robot;
  robot.control->velocity = Twist2{50, -50, 50};
  robot.drive_to({3, 0, 0});
  const auto& limits = robot.params_.limits;
  for (int i = 0; i < 100; ++i) {
    const auto before = robot.velocity;
    const auto now = robot.cycle().command;
    const double x = now.vx / limits.max_vx_m_s;
    const double y = now.vy / limits.max_vy_m_s;
    EXPECT_LE(x * x + y * y, 1 + 1e-9);
    EXPECT_LE(std::abs(now.wz), limits.max_wz_rad_s + 1e-9);
    if (is_zero(now)) continue;  // it may always stop
    EXPECT_LE(std::abs(now.vx - before.vx), limits.acc_x_m_s2 * 0.05 + 1e-9);
    EXPECT_LE(std::abs(now.vy - before.vy), limits.acc_y_m_s2 * 0.05 + 1e-9);
    EXPECT_LE(std::abs(now.wz - before.wz), limits.acc_wz_rad_s2 * 0.05 + 1e-9);
  }
}

TEST(NavigatorFaults, AnEmptyOrWildPathIsNoPath) {
  for (const auto& path : {Path{}, Path{{{0, 0, 0}, {std::nan(""), 0, 0}}, 1}}) {
    FakeRobot robot;
    robot.answers = false;
    robot.drive_to({2, 0, 0});
    double until_s = robot.now_s + 100;
    while (robot.ends.empty() && robot.now_s < until_s)
      if (const auto output = robot.cycle(); output.plan)
        robot.navigator.set_plan({output.plan->id, path, {}});
    ASSERT_FALSE(robot.ends.empty());
    EXPECT_EQ(robot.ends[0].error.code, NavCode::kNoPath);
  }
}

/// Something happens to the robot.
void shake(FakeRobot& robot, Rng& rng) {
  const NavError errors[] = {{NavCode::kBlocked, "b"},
                             {NavCode::kNoPath, "n"},
                             {NavCode::kStartBlocked, "s"},
                             {NavCode::kGoalBlocked, "g"},
                             {NavCode::kPlanTimeout, "t"}};
  const NavError faults[] = {
      {NavCode::kNoScan, "scan"}, {NavCode::kNoOdometry, "odometry"}, {NavCode::kLocalizationLost, "lost"}};
  switch (rng.integer(0, 9)) {
    case 0:
      robot.control->error = errors[rng.integer(0, 4)];
      break;
    case 1:
      robot.plan_error = errors[rng.integer(0, 4)];
      break;
    case 2:
      robot.input.fault = faults[rng.integer(0, 2)];
      break;
    case 3:
      robot.control->velocity = Twist2{rng.uniform(-3, 3), rng.uniform(-3, 3), rng.uniform(-3, 3)};
      break;
    case 4:
      robot.now_s += rng.uniform(-100, 100);
      break;
    case 5:
      robot.block({rng.uniform(-3, 3), rng.uniform(-3, 3)}, rng.uniform(0.05, 0.5));
      break;
    case 6:
      robot.input.jumped = robot.input.map_changed = rng.chance(0.5);
      break;
    case 7:
      robot.answers = rng.chance(0.5);
      robot.current_blocked = rng.chance(0.5);
      robot.input.guard_stopped = rng.chance(0.3);
      break;
    default:  // all is well again
      robot.control->error.reset();
      robot.control->velocity.reset();
      robot.plan_error.reset();
      robot.input.fault.reset();
      robot.input.guard_stopped = robot.current_blocked = false;
      robot.costs = make_cost_grid(160, 160, 0.05, {-4, -4}, kFreeCost);
  }
}

TEST(NavigatorFaults, WhateverHappensItEndsStandsWhenBlindAndObeysItsLimits) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    FakeRobot robot;
    (void)robot.navigator.start(
        {seed, {{3, rng.uniform(-3, 3), 0}, {-3, rng.uniform(-3, 3), 1}}, rng.chance(0.5)});
    double elapsed_s = 0;
    while (robot.ends.empty() && elapsed_s < 3600) {
      if (elapsed_s < 100 && rng.chance(0.02)) shake(robot, rng);
      const bool blind = robot.input.fault.has_value();
      const auto output = robot.cycle(0.1);
      elapsed_s += 0.1;
      EXPECT_TRUE(!blind || is_zero(output.command));
      EXPECT_TRUE(output.active || is_zero(output.command));
      EXPECT_LE(std::hypot(output.command.vx / 0.8, output.command.vy / 0.5), 1 + 1e-9);
      EXPECT_LE(std::abs(output.command.wz), 1.2 + 1e-9);
    }
    EXPECT_EQ(robot.ends.size(), 1U) << to_string(robot.navigator.state()) << " " << robot.navigator.reason();
  }
}

}  // namespace
}  // namespace extperfc::navigate::test
