#include <cmath>

#include <gtest/gtest.h>

#include "simulate/control/gripper_controller.hpp"

namespace extperfc::simulate {
namespace {

using Kind = GripperCommand::Kind;
constexpr double kStep = 1.0 / 240;
constexpr double kStroke = 0.02;

/// Fingers that go where they shall, down to `obstacle_m` when something lies between them.
class GripperControllerTest : public testing::Test {
 protected:
  void run(double seconds, bool may_move = true) {
    for (int i = 0; i < std::lround(seconds / kStep); ++i) {
      const auto target = gripper_.step(kStep, may_move, measured_);
      effort_ = target.max_effort;
      target_m_ = target.position;
      measured_.finger_m = std::max(target.position, obstacle_m_);
      measured_.touches = obstacle_m_ > 0 && target.position <= obstacle_m_;
      measured_.force_n = measured_.touches ? effort_ : 0;
    }
  }
  void go_to(double percent) {
    GripperCommand command{Kind::kGoTo, percent, {}, {}, {}, {}};
    ASSERT_TRUE(gripper_.command(command)) << "go to " << percent;
  }

  GripperMeasurement measured_{kStroke, false, 0};
  double obstacle_m_{0};
  double effort_{0};
  double target_m_{0};
  GripperController gripper_{MotionLimits{0, kStroke, 0.08, 1.0}, 20.0, kStroke};
};

TEST_F(GripperControllerTest, RefusesToMoveBeforeItsCalibration) {
  const auto refused = gripper_.command({Kind::kGoTo, 50, {}, {}, {}, {}});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("calibrate"), std::string::npos);
  EXPECT_FALSE(gripper_.state().calibrated);
}

TEST_F(GripperControllerTest, CalibrationClosesAndOpens) {
  ASSERT_TRUE(gripper_.command({Kind::kCalibrate, 0, {}, {}, {}, {}}));
  run(0.3);
  EXPECT_LT(gripper_.state().position_percent, 60);
  EXPECT_FALSE(gripper_.state().calibrated);
  run(2.0);
  EXPECT_TRUE(gripper_.state().calibrated);
  EXPECT_NEAR(gripper_.state().position_percent, 100, 1e-6);
}

TEST_F(GripperControllerTest, GoesWhereItShall) {
  gripper_.calibrate_at_once();
  go_to(25);
  run(0.05);
  EXPECT_TRUE(gripper_.state().moving);
  run(2.0);
  EXPECT_NEAR(gripper_.state().position_percent, 25, 1e-6);
  EXPECT_FALSE(gripper_.state().moving);
  EXPECT_FALSE(gripper_.state().gripping);
}

TEST_F(GripperControllerTest, GripsWhatIsBetweenItsFingersWithTheHoldingForce) {
  gripper_.calibrate_at_once();
  obstacle_m_ = 0.012;
  GripperCommand command{Kind::kGoTo, 0, {}, 50, 25, {}};
  ASSERT_TRUE(gripper_.command(command));
  run(2.0);
  EXPECT_TRUE(gripper_.state().gripping);
  EXPECT_FALSE(gripper_.state().missed);
  EXPECT_DOUBLE_EQ(effort_, 5.0) << "25 % of 20 N";
  EXPECT_NEAR(gripper_.state().force_percent, 25, 1e-6);
  EXPECT_GE(target_m_, 0.012 - 0.005 - 1e-9) << "no farther than 5 mm into the object";
  go_to(100);
  run(2.0);
  EXPECT_FALSE(gripper_.state().gripping);
  EXPECT_NEAR(gripper_.state().position_percent, 100, 1e-6);
}

TEST_F(GripperControllerTest, SaysWhenItClosedOnNothing) {
  gripper_.calibrate_at_once();
  go_to(0);
  run(2.0);
  EXPECT_TRUE(gripper_.state().missed);
  go_to(50);
  run(2.0);
  EXPECT_FALSE(gripper_.state().missed);
}

TEST_F(GripperControllerTest, StaysWhileItMayNotMove) {
  gripper_.calibrate_at_once();
  go_to(0);
  run(1.0, false);
  EXPECT_NEAR(gripper_.state().position_percent, 100, 1e-6);
}

TEST_F(GripperControllerTest, RefusesPercentagesOutOfRange) {
  gripper_.calibrate_at_once();
  EXPECT_FALSE(gripper_.command({Kind::kGoTo, 101, {}, {}, {}, {}}));
  EXPECT_FALSE(gripper_.command({Kind::kGoTo, std::nan(""), {}, {}, {}, {}}));
  EXPECT_FALSE(gripper_.command({Kind::kConfigure, 0, -1, {}, {}, {}}));
}

}  // namespace
}  // namespace extperfc::simulate
