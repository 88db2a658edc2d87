#include "test/unit/simulate/control/simulator_test.hpp"

namespace extperfc::simulate {
namespace {

using FaultTest = SimulatorTest;

TEST_F(FaultTest, StuckJointStaysUntilTheFaultIsOver) {
  ASSERT_TRUE(simulator_->set_fault({FaultKind::kJointStuck, "left_s1", 1, 1.0}));
  const double start = left().position[1];
  hold_command(ArmMode::kPosition, 1, -0.6, 0.9);
  EXPECT_EQ(left().position[1], start);
  EXPECT_EQ(simulator_->faults().size(), 1U);
  hold_command(ArmMode::kPosition, 1, -0.6, 3.0);
  EXPECT_NEAR(left().position[1], -0.6, 1e-6);
  EXPECT_TRUE(simulator_->faults().empty());
}

TEST_F(FaultTest, StuckHeadAndFinger) {
  ASSERT_TRUE(simulator_->set_fault({FaultKind::kJointStuck, "head_pan", 1, 0}));
  simulator_->command_head_pan(1.0, 1.0);
  run(1.0);
  EXPECT_EQ(joint("head_pan"), 0.0);
}

TEST_F(FaultTest, SlippingWheelTurnsTheRobotAndOdometryDoesNotKnow) {
  ASSERT_TRUE(simulator_->set_fault({FaultKind::kWheelSlip, "fl", 0.6, 0}));
  for (int i = 0; i < 40; ++i) {
    simulator_->command_base({0.4, 0, 0});
    run(0.05);
  }
  EXPECT_GT(std::abs(simulator_->base_state().truth.yaw - simulator_->base_state().odometry.yaw), 0.05);
}

TEST_F(FaultTest, EndsOneKindOrAll) {
  ASSERT_TRUE(simulator_->set_fault({FaultKind::kCameraDrop, "", 0.5, 0}));
  ASSERT_TRUE(simulator_->set_fault({FaultKind::kLidarRings, "3, 7", 1, 0}));
  ASSERT_TRUE(simulator_->set_fault({FaultKind::kWheelSlip, "all", 0.1, 0}));
  EXPECT_EQ(simulator_->faults().size(), 3U);
  ASSERT_TRUE(simulator_->set_fault({FaultKind::kCameraDrop, "", 0, -1}));
  EXPECT_EQ(simulator_->faults().size(), 2U);
  ASSERT_TRUE(simulator_->set_fault({}));
  EXPECT_TRUE(simulator_->faults().empty());
}

TEST_F(FaultTest, ASecondFaultOfAKindReplacesTheFirst) {
  ASSERT_TRUE(simulator_->set_fault({FaultKind::kCameraNan, "", 0.5, 0}));
  ASSERT_TRUE(simulator_->set_fault({FaultKind::kCameraNan, "", 0.9, 0}));
  ASSERT_EQ(simulator_->faults().size(), 1U);
  EXPECT_EQ(simulator_->faults()[0].value, 0.9);
}

TEST_F(FaultTest, RefusesWhatCannotBe) {
  const auto message = [this](const Fault& fault) {
    const auto refused = simulator_->set_fault(fault);
    return refused ? std::string() : refused.error().message;
  };
  EXPECT_NE(message({FaultKind::kJointStuck, "left_knee", 1, 0}).find("left_knee"), std::string::npos);
  EXPECT_NE(message({FaultKind::kJointStuck, "torso_t0", 1, 0}).find("torso_t0"), std::string::npos)
      << "fixed";
  EXPECT_NE(message({FaultKind::kWheelSlip, "spare", 0.5, 0}).find("spare"), std::string::npos);
  EXPECT_NE(message({FaultKind::kWheelSlip, "fl", 1.5, 0}).find("0 to 1"), std::string::npos);
  EXPECT_NE(message({FaultKind::kLidarRings, "3,16", 1, 0}).find("16"), std::string::npos);
  EXPECT_NE(message({FaultKind::kCameraDrop, "", std::nan(""), 0}).find("fraction"), std::string::npos);
  EXPECT_NE(message({FaultKind::kClockJump, "", INFINITY, 0}).find("seconds"), std::string::npos);
  EXPECT_NE(message({FaultKind::kDie, "", -1, 0}).find("seconds"), std::string::npos);
  EXPECT_TRUE(simulator_->faults().empty());
}

TEST(RingNumbers, ListsOrAll) {
  EXPECT_EQ(ring_numbers("3, 7").value(), (std::vector<int>{3, 7}));
  EXPECT_EQ(ring_numbers("all").value().size(), 16U);
  EXPECT_EQ(ring_numbers("").value().back(), 15);
  EXPECT_FALSE(ring_numbers("1,,2"));
}

TEST(FaultNames, AreReadAsTheyAreWritten) {
  for (int kind = 0; kind <= static_cast<int>(FaultKind::kDie); ++kind) {
    const auto fault = static_cast<FaultKind>(kind);
    EXPECT_EQ(fault_kind(to_string(fault)), fault);
  }
  EXPECT_FALSE(fault_kind("gremlins"));
}

}  // namespace
}  // namespace extperfc::simulate
