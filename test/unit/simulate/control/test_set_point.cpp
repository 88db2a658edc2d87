#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "simulate/control/set_point.hpp"

namespace extperfc::simulate {
namespace {

constexpr double kStep = 1.0 / 240;
constexpr MotionLimits kLimits{-2.0, 2.0, 1.5, 4.0};

TEST(SetPoint, TakesTheTimeOfATrapezoid) {
  SetPoint point;
  int steps = 0;
  while (point.position() != 1.2 && steps < 10000) {
    point.move_to(1.2, kLimits, kStep);
    ++steps;
  }
  // Ramps of v/a each, between them the rest at full speed: t = d/v + v/a.
  EXPECT_NEAR(steps * kStep, 1.2 / 1.5 + 1.5 / 4.0, 0.02);
}

TEST(SetPoint, KeepsItsLimitsAndNeverOvershoots) {
  Rng rng(7);
  for (int trial = 0; trial < 200; ++trial) {
    SetPoint point(rng.uniform(-2, 2));
    const double start = point.position();
    const double goal = rng.uniform(-2, 2);
    double last = 0;
    for (int i = 0; i < 2000; ++i) {
      point.move_to(goal, kLimits, kStep);
      ASSERT_LE(std::abs(point.velocity()), kLimits.max_velocity + 1e-12);
      ASSERT_LE(std::abs(point.velocity() - last), kLimits.max_accel * kStep + 1e-9) << "trial " << trial;
      ASSERT_GE((goal - point.position()) * (goal - start), -1e-12) << "overshoot in trial " << trial;
      last = point.velocity();
    }
    EXPECT_EQ(point.position(), goal);
    EXPECT_EQ(point.velocity(), 0);
  }
}

TEST(SetPoint, AChangedGoalIsReachedToo) {
  SetPoint point;
  for (int i = 0; i < 100; ++i) point.move_to(2.0, kLimits, kStep);
  for (int i = 0; i < 2000; ++i) point.move_to(-1.0, kLimits, kStep);
  EXPECT_EQ(point.position(), -1.0);
}

TEST(SetPoint, StopsBeforeTheEndOfItsRange) {
  SetPoint point;
  double last = 0;
  for (int i = 0; i < 2000; ++i) {
    point.move_at(1.5, kLimits, kStep);
    ASSERT_LE(std::abs(point.velocity() - last), kLimits.max_accel * kStep + 1e-9);
    last = point.velocity();
  }
  EXPECT_NEAR(point.position(), 2.0, 1e-3);
  EXPECT_LE(point.position(), 2.0);
}

TEST(SetPoint, FollowsAsFastAsItMay) {
  SetPoint point;
  point.follow(1.0, kLimits, kStep);
  EXPECT_DOUBLE_EQ(point.position(), 1.5 * kStep);
  point.follow(point.position() + 0.001, kLimits, kStep);
  EXPECT_DOUBLE_EQ(point.position(), 1.5 * kStep + 0.001);
  point.follow(99, MotionLimits{-2, 2, 1e9, 1}, kStep);
  EXPECT_EQ(point.position(), 2.0) << "the range holds";
}

TEST(SetPoint, BrakingSpeedIsTheClosedForm) {
  // Brake from it, step by step: what is left must be nothing but a part of a step.
  for (const double distance : {0.001, 0.1, 1.0}) {
    double v = braking_speed(distance, 4.0, kStep);
    double travelled = 0;
    for (; v > 0; v -= 4.0 * kStep) travelled += v * kStep;
    EXPECT_LE(travelled, distance + 1e-9);
    EXPECT_GE(travelled, distance - 4.0 * kStep * kStep - 1e-9);
  }
}

}  // namespace
}  // namespace extperfc::simulate
