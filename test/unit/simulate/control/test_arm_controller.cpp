#include <cmath>

#include <gtest/gtest.h>

#include "simulate/control/arm_controller.hpp"

namespace extperfc::simulate {
namespace {

constexpr double kStep = 1.0 / 240;

std::array<MotionLimits, kArmJoints> limits() {
  std::array<MotionLimits, kArmJoints> all;
  all.fill({-2.0, 2.0, 1.5, 4.0});
  return all;
}

/// An arm whose joints are where their targets say, unless something holds them.
class ArmControllerTest : public testing::Test {
 protected:
  void run(double seconds, bool may_move = true) {
    for (int i = 0; i < std::lround(seconds / kStep); ++i) {
      now_ += kStep;
      targets_ = arm_.step(now_, kStep, may_move, measured_);
      for (int j = 0; j < kArmJoints; ++j)
        if (targets_[j].drive == Drive::kPosition && !held_) measured_.position[j] = targets_[j].position;
    }
  }
  /// Commands as a driver does, 60 times a second.
  void run_with(const ArmCommand& command, double seconds) {
    for (int i = 0; i < std::lround(seconds * 60); ++i) {
      arm_.command(command, now_);
      run(4 * kStep);
    }
  }
  static ArmCommand all(ArmMode mode, double value) {
    ArmCommand command{mode, {}};
    command.values.fill(value);
    return command;
  }

  double now_{1};
  bool held_{false};
  ArmMeasurement measured_;
  ArmController arm_{limits(), ArmValues{}, 0.2};
  ArmController::Targets targets_;
};

TEST_F(ArmControllerTest, PositionModeArrives) {
  run_with(all(ArmMode::kPosition, 0.5), 3.0);
  for (const double position : measured_.position) EXPECT_DOUBLE_EQ(position, 0.5);
}

TEST_F(ArmControllerTest, SpeedRatioSlowsPositionMoves) {
  arm_.set_speed_ratio(0.1);
  run_with(all(ArmMode::kPosition, 1.0), 1.0);
  EXPECT_NEAR(measured_.position[0], 0.15, 0.01) << "0.1 of 1.5 rad/s for a second";
}

TEST_F(ArmControllerTest, HoldsWhereItIsAfterTheTimeOut) {
  arm_.command(all(ArmMode::kVelocity, 1.0), now_);
  run(0.2);
  const double there = measured_.position[0];
  EXPECT_GT(there, 0.05);
  run(1.0);
  const double stopped = measured_.position[0];
  EXPECT_LT(stopped - there, 1.0 / (2 * 4.0) + 0.01) << "not farther than it takes to brake";
  run(1.0);
  EXPECT_EQ(measured_.position[0], stopped);
}

TEST_F(ArmControllerTest, ALongerTimeOutCounts) {
  arm_.set_timeout(0.9);
  arm_.command(all(ArmMode::kVelocity, 0.5), now_);
  run(0.8);
  EXPECT_NEAR(targets_[0].velocity, 0.5, 1e-9);
}

TEST_F(ArmControllerTest, JointsWithoutAValueStay) {
  ArmCommand command{ArmMode::kPosition, {}};
  command.values[3] = 0.4;
  run_with(command, 2.0);
  for (int j = 0; j < kArmJoints; ++j) EXPECT_EQ(measured_.position[j], j == 3 ? 0.4 : 0.0);
}

TEST_F(ArmControllerTest, DisabledArmStopsAtOnceAndStays) {
  arm_.set_timeout(1.0);
  arm_.command(all(ArmMode::kVelocity, 1.0), now_);
  run(0.5);
  const double there = measured_.position[0];
  run(0.3, false);
  EXPECT_EQ(measured_.position[0], there);
}

TEST_F(ArmControllerTest, TorqueModeAddsGravityAndThenHoldsWhereTheArmIs) {
  measured_.gravity.fill(3.0);
  arm_.command(all(ArmMode::kTorque, 1.5), now_);
  run(0.1);
  EXPECT_EQ(targets_[2].drive, Drive::kEffort);
  EXPECT_DOUBLE_EQ(targets_[2].effort, 4.5);
  measured_.position.fill(0.3);  // the torque has moved it
  run(0.3);
  EXPECT_EQ(targets_[2].drive, Drive::kPosition);
  EXPECT_DOUBLE_EQ(targets_[2].position, 0.3);
}

TEST_F(ArmControllerTest, SetPointDoesNotRunAwayFromABlockedJoint) {
  held_ = true;
  run_with(all(ArmMode::kPosition, 1.5), 4.0);
  EXPECT_NEAR(targets_[0].position, 0.2, 1e-9);
}

TEST_F(ArmControllerTest, StuckJointStaysAndTheOthersMove) {
  arm_.set_stuck(1, true);
  run_with(all(ArmMode::kPosition, 0.5), 3.0);
  EXPECT_EQ(measured_.position[1], 0.0);
  EXPECT_EQ(measured_.position[2], 0.5);
  arm_.set_stuck(1, false);
  run_with(all(ArmMode::kPosition, 0.5), 3.0);
  EXPECT_EQ(measured_.position[1], 0.5);
}

}  // namespace
}  // namespace extperfc::simulate
