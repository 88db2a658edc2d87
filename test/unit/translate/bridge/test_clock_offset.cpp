// The offset of two clocks from stamps and from NTP: which bound it is, jitter, steps, drift, nonsense.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/translate/clock_offset.hpp"

namespace extperfc::translate {
namespace {

constexpr double kStartS = 1.7e9;
constexpr double kPeriodS = 0.01;
constexpr double kMinDelayS = 0.002;

/// A robot that stamps at 100 Hz, and the network between.
class Robot {
 public:
  explicit Robot(double offset_s) : offset_s_(offset_s) {}

  void run(ClockOffset& clock, double seconds, double jitter_s = 0.0, double extra_delay_s = 0.0) {
    for (const double end_s = now_s_ + seconds; now_s_ < end_s; now_s_ += kPeriodS) {
      const double delay_s = kMinDelayS + extra_delay_s + rng_.uniform(0.0, 1.0) * jitter_s;
      clock.add_stamp_sample(now_s_ + our_step_s_, now_s_ - delay_s + offset_s_);
      offset_s_ += drift_ * kPeriodS;
    }
  }
  void sleep(double seconds) { now_s_ += seconds; }
  void step_robot_clock(double by_s) { offset_s_ += by_s; }
  void step_our_clock(double by_s) { our_step_s_ += by_s; }
  void drift(double seconds_per_second) { drift_ = seconds_per_second; }

  [[nodiscard]] double offset() const { return offset_s_ - our_step_s_; }
  [[nodiscard]] double now() const { return now_s_ + our_step_s_; }

 private:
  Rng rng_{7};
  double now_s_{kStartS};
  double offset_s_;
  double our_step_s_{0.0};
  double drift_{0.0};
};

constexpr double kResolutionS = 1e-6;  ///< of doubles at this year

TEST(ClockOffset, KnowsNothingBeforeTheFirstStampsAgree) {
  ClockOffset clock;
  EXPECT_FALSE(clock.estimate(kStartS));
  for (std::size_t i = 0; i + 1 < ClockOffset::kAgree; ++i) {
    clock.add_stamp_sample(kStartS + 0.01 * static_cast<double>(i), kStartS + 0.01 * static_cast<double>(i));
    EXPECT_FALSE(clock.estimate(kStartS));
  }
  clock.add_stamp_sample(kStartS + 0.1, kStartS + 0.1);
  EXPECT_TRUE(clock.estimate(kStartS));
}

TEST(ClockOffset, StampsGiveALowerBoundThatTheShortestDelaySetsApart) {
  for (const double offset_s : {-3600.0, -0.3, 0.0, 0.004, 2.5, 86400.0}) {
    ClockOffset clock;
    Robot robot(offset_s);
    robot.run(clock, 5.0, 0.02);
    const auto estimate = clock.estimate(robot.now());
    ASSERT_TRUE(estimate);
    EXPECT_EQ(estimate->source, ClockOffset::Source::kStamps);
    EXPECT_LE(estimate->offset_s, offset_s - kMinDelayS + kResolutionS) << "a bound from below";
    EXPECT_NEAR(estimate->offset_s, offset_s - kMinDelayS, 2e-4)
        << "the least of 500 delays is near the least";
    EXPECT_NEAR(estimate->uncertainty_s, 0.01, 0.002) << "mean excess of uniform delays of 0 to 20 ms";
    EXPECT_LT(estimate->age_s, 0.02);
  }
}

TEST(ClockOffset, AShiftedStampIsNeverInTheReceiversFuture) {
  ClockOffset clock;
  Robot robot(1.25);
  robot.run(clock, 5.0, 0.03);
  const double stamp_s = robot.now() - kMinDelayS + 1.25;  // faster than any before it
  clock.add_stamp_sample(robot.now(), stamp_s);
  const double shift_s = clock.estimate(robot.now())->offset_s;
  EXPECT_LE(shift_s, 1.25) << "workstation to robot: now + shift is not ahead of the robot's clock";
  EXPECT_LE(stamp_s - shift_s, robot.now() + kResolutionS)
      << "robot to workstation: even the fastest message is no prophecy";
}

TEST(ClockOffset, StampsThatAreNoneDoNotCount) {
  ClockOffset clock;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 50; ++i)
    for (const double wild : {0.0, -1.0, nan, inf, -inf, 5e9}) {
      clock.add_stamp_sample(kStartS, wild);
      clock.add_stamp_sample(wild, kStartS);
    }
  EXPECT_FALSE(clock.estimate(kStartS));
}

TEST(ClockOffset, AWildStampNowAndThenChangesNothing) {
  ClockOffset clock;
  Robot robot(0.5);
  Rng rng(3);
  for (int i = 0; i < 200; ++i) {
    robot.run(clock, 0.05, 0.005);
    clock.add_stamp_sample(robot.now(), robot.now() + rng.uniform(-1e6, 1e6));
    const auto estimate = clock.estimate(robot.now());
    ASSERT_TRUE(estimate || i < 2);
    EXPECT_NEAR(estimate.value_or(ClockOffset::Estimate{0.5}).offset_s, 0.5, 0.01) << i;
  }
  EXPECT_EQ(clock.steps(), 0U);
}

TEST(ClockOffset, AStepForwardsIsFollowedAtOnce) {
  ClockOffset clock;
  Robot robot(0.0);
  robot.run(clock, 20.0, 0.01);
  robot.step_robot_clock(30.0);
  robot.run(clock, 0.1, 0.01);
  EXPECT_NEAR(clock.estimate(robot.now())->offset_s, 30.0, 0.02);
  EXPECT_EQ(clock.steps(), 1U);
}

TEST(ClockOffset, AStepBackwardsIsFollowedWhenItLasts) {
  ClockOffset clock;
  Robot robot(0.0);
  robot.run(clock, 20.0, 0.01);
  robot.step_robot_clock(-1.0);
  robot.run(clock, 1.0, 0.01);
  EXPECT_NEAR(clock.estimate(robot.now())->offset_s, 0.0, 0.02) << "it may be a jam";
  robot.run(clock, 1.5, 0.01);
  EXPECT_NEAR(clock.estimate(robot.now())->offset_s, -1.0, 0.02);
  EXPECT_EQ(clock.steps(), 1U);
}

TEST(ClockOffset, AJamOfTheNetworkIsNoStep) {
  ClockOffset clock;
  Robot robot(0.1);
  robot.run(clock, 20.0, 0.01);
  for (double extra_s = 4.0; extra_s > 0.0; extra_s -= 0.1) robot.run(clock, 0.1, 0.01, extra_s);
  robot.run(clock, 1.0, 0.01);
  EXPECT_NEAR(clock.estimate(robot.now())->offset_s, 0.1, 0.01);
  EXPECT_EQ(clock.steps(), 0U);
}

TEST(ClockOffset, AfterAnOutageABurstOfOldMessagesIsNotBelieved) {
  ClockOffset clock;
  Robot robot(0.1);
  robot.run(clock, 20.0, 0.01);
  robot.sleep(60.0);
  const auto held = clock.estimate(robot.now());
  ASSERT_TRUE(held);
  EXPECT_NEAR(held->age_s, 60.0, 0.1) << "it stays, and says how old it is";
  for (int i = 0; i < 100; ++i) clock.add_stamp_sample(robot.now(), robot.now() - 60.0 + 0.6 * i + 0.1);
  EXPECT_NEAR(clock.estimate(robot.now())->offset_s, 0.1, 0.01);
  robot.run(clock, 1.0, 0.01);
  EXPECT_NEAR(clock.estimate(robot.now())->offset_s, 0.1, 0.01);
  EXPECT_LT(clock.estimate(robot.now())->age_s, 0.1);
}

TEST(ClockOffset, OurOwnClockMayBeSetToo) {
  for (const double step_s : {-100.0, 100.0}) {
    ClockOffset clock;
    Robot robot(0.0);
    robot.run(clock, 20.0, 0.01);
    robot.step_our_clock(step_s);
    robot.run(clock, 3.0, 0.01);
    EXPECT_NEAR(clock.estimate(robot.now())->offset_s, -step_s, 0.02);
    EXPECT_EQ(clock.steps(), 1U);
  }
}

TEST(ClockOffset, DriftIsFollowed) {
  for (const double drift : {-100e-6, 100e-6}) {
    ClockOffset clock;
    Robot robot(0.0);
    robot.drift(drift);
    robot.run(clock, 600.0, 0.005);
    EXPECT_NEAR(clock.estimate(robot.now())->offset_s, robot.offset(), 0.005);
    EXPECT_EQ(clock.steps(), 0U);
  }
}

TEST(ClockOffset, WhenNothingAgreesTheLatestCounts) {
  ClockOffset clock;
  Rng rng(11);
  double latest_s = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const double now_s = kStartS + 0.01 * i;
    latest_s = rng.uniform(-1e5, 1e5);
    clock.add_stamp_sample(now_s, now_s + latest_s);
  }
  EXPECT_TRUE(clock.estimate(kStartS)) << "an estimate with any uncertainty";
}

TEST(ClockOffset, NtpIsTheMeanOfBothDirectionsBoundedByHalfTheRoundTrip) {
  ClockOffset clock;
  // Old clock 10 s ahead; 30 ms there, 1 ms at the server, 10 ms back.
  clock.add_ntp_sample(kStartS, kStartS + 10.030, kStartS + 10.031, kStartS + 0.041);
  const auto estimate = clock.estimate(kStartS + 0.041);
  ASSERT_TRUE(estimate);
  EXPECT_EQ(estimate->source, ClockOffset::Source::kNtp);
  EXPECT_NEAR(estimate->offset_s, 10.010, kResolutionS);
  EXPECT_NEAR(estimate->uncertainty_s, 0.020, kResolutionS);
  EXPECT_LE(std::abs(estimate->offset_s - 10.0), estimate->uncertainty_s);
}

/// A question with these delays, answered by a clock that is ahead by `offset_s`.
void ask(ClockOffset& clock, double now_s, double offset_s, double there_s, double back_s) {
  clock.add_ntp_sample(now_s, now_s + there_s + offset_s, now_s + there_s + offset_s,
                       now_s + there_s + back_s);
}

TEST(ClockOffset, TheSmallestRoundTripOfTheWindowCounts) {
  ClockOffset clock;
  Rng rng(5);
  for (int i = 0; i < 100; ++i) {
    const double now_s = kStartS + 16.0 * i;
    const bool quiet = i % 8 == 3;
    ask(clock, now_s, 0.25, quiet ? 0.0005 : rng.uniform(0.01, 0.2), quiet ? 0.0005 : rng.uniform(0.01, 0.2));
    const auto estimate = clock.estimate(now_s + 0.5);
    ASSERT_TRUE(estimate);
    EXPECT_LE(std::abs(estimate->offset_s - 0.25), estimate->uncertainty_s) << i;
    if (i > 8) {
      EXPECT_NEAR(estimate->offset_s, 0.25, 0.001) << i;
    }
  }
}

TEST(ClockOffset, NtpBoundHoldsWhileClocksDrift) {
  ClockOffset clock;
  double offset_s = 0.0;
  for (int i = 0; i < 200; ++i) {
    offset_s += 16.0 * 40e-6;
    ask(clock, kStartS + 16.0 * i, offset_s, 0.001, 0.003);
    const auto estimate = clock.estimate(kStartS + 16.0 * i + 0.004);
    EXPECT_LE(std::abs(estimate->offset_s - offset_s), estimate->uncertainty_s + kResolutionS) << i;
  }
  EXPECT_EQ(clock.steps(), 0U);
}

TEST(ClockOffset, NtpSamplesThatCannotBeDoNotCount) {
  ClockOffset clock;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  clock.add_ntp_sample(kStartS, kStartS, kStartS, kStartS - 1.0);        // answered before it was asked
  clock.add_ntp_sample(kStartS, kStartS + 2.0, kStartS, kStartS + 1.0);  // sent before it was received
  clock.add_ntp_sample(kStartS, kStartS, kStartS + 5.0, kStartS + 1.0);  // longer there than in all
  clock.add_ntp_sample(kStartS, kStartS, kStartS, kStartS + 100.0);      // a trip of 100 s
  clock.add_ntp_sample(nan, kStartS, kStartS, kStartS);
  clock.add_ntp_sample(kStartS, nan, kStartS, kStartS);
  EXPECT_FALSE(clock.estimate(kStartS));
}

TEST(ClockOffset, AnNtpStepNeedsASecondWitness) {
  ClockOffset clock;
  for (int i = 0; i < 8; ++i) ask(clock, kStartS + i, 0.0, 0.001, 0.001);
  ask(clock, kStartS + 20.0, 500.0, 0.001, 0.001);
  EXPECT_NEAR(clock.estimate(kStartS + 20.0)->offset_s, 0.0, 0.001);
  ask(clock, kStartS + 36.0, 500.0, 0.001, 0.001);
  EXPECT_NEAR(clock.estimate(kStartS + 36.0)->offset_s, 500.0, 0.001);
  EXPECT_EQ(clock.steps(), 1U);
}

TEST(ClockOffset, NtpComesBeforeStampsUntilItFallsSilent) {
  ClockOffset clock;
  Robot robot(0.5);
  robot.run(clock, 1.0);
  ask(clock, robot.now(), 0.5, 0.01, 0.01);
  EXPECT_EQ(clock.estimate(robot.now())->source, ClockOffset::Source::kNtp);
  robot.run(clock, 400.0);
  EXPECT_EQ(clock.estimate(robot.now())->source, ClockOffset::Source::kStamps);
}

}  // namespace
}  // namespace extperfc::translate
