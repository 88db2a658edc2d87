#include <gtest/gtest.h>

#include "ros/simulate/pacer.hpp"

namespace extperfc::ros_simulate {
namespace {

using namespace std::chrono_literals;

class PacerTest : public testing::Test {
 protected:
  const Pacer::Time start_{1000s};
  static constexpr double kStepS = 0.01;
};

TEST_F(PacerTest, StepsAreDueOneStepApart) {
  Pacer pacer(1.0);
  pacer.restart(start_);
  EXPECT_EQ(pacer.due(start_), start_);
  pacer.advance(kStepS);
  EXPECT_EQ(pacer.due(start_), start_ + 10ms);
  pacer.advance(kStepS);
  EXPECT_EQ(pacer.due(start_ + 10ms), start_ + 20ms);
}

TEST_F(PacerTest, TheFactorStretchesOrShortensTheSteps) {
  Pacer pacer(0.5);
  pacer.restart(start_);
  pacer.advance(kStepS);
  EXPECT_EQ(pacer.due(start_), start_ + 20ms);
  pacer.set_factor(2.0, start_ + 1s);
  pacer.advance(kStepS);
  EXPECT_EQ(pacer.due(start_ + 1s), start_ + 1s + 5ms);
}

TEST_F(PacerTest, ZeroIsAsFastAsPossible) {
  Pacer pacer(0.0);
  pacer.restart(start_);
  for (int i = 0; i < 100; ++i) pacer.advance(kStepS);
  EXPECT_EQ(pacer.due(start_), start_);
  EXPECT_EQ(pacer.debts_dropped(), 0U);
}

TEST_F(PacerTest, ALittleDebtIsCaughtUp) {
  Pacer pacer(1.0);
  pacer.restart(start_);
  EXPECT_EQ(pacer.due(start_ + 90ms), start_) << "nine steps at once";
  EXPECT_EQ(pacer.debts_dropped(), 0U);
}

TEST_F(PacerTest, ALargeDebtIsDropped) {
  Pacer pacer(1.0);
  pacer.restart(start_);
  EXPECT_EQ(pacer.due(start_ + 5s), start_ + 5s);
  pacer.advance(kStepS);
  EXPECT_EQ(pacer.due(start_ + 5s), start_ + 5s + 10ms) << "no race after what was lost";
  EXPECT_EQ(pacer.debts_dropped(), 1U);
}

TEST_F(PacerTest, APauseIsNoDebt) {
  Pacer pacer(1.0);
  pacer.restart(start_);
  pacer.restart(start_ + 60s);
  EXPECT_EQ(pacer.due(start_ + 60s), start_ + 60s);
  EXPECT_EQ(pacer.debts_dropped(), 0U);
}

TEST_F(PacerTest, MeterGivesSimulatedSecondsPerSecond) {
  FactorMeter meter;
  meter.restart(start_);
  EXPECT_FALSE(meter.stepped(0.25, start_ + 500ms));
  const auto factor = meter.stepped(0.25, start_ + 1s);
  ASSERT_TRUE(factor);
  EXPECT_DOUBLE_EQ(*factor, 0.5);
  EXPECT_FALSE(meter.stepped(0.25, start_ + 1500ms)) << "a new stretch";
  EXPECT_DOUBLE_EQ(meter.stepped(1.75, start_ + 2s).value_or(-1), 2.0);
}

}  // namespace
}  // namespace extperfc::ros_simulate
