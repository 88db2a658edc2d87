// Joint positions at the time of an image.
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "extperfc/arm/joint_history.hpp"

namespace extperfc::arm {
namespace {

constexpr double kUnheard = std::numeric_limits<double>::quiet_NaN();

JointVector two(double a, double b) {
  JointVector vector(2);
  vector << a, b;
  return vector;
}

TEST(JointHistory, PositionsBetweenMessagesAreInterpolated) {
  JointHistory history({"a", "b"}, two(kUnheard, kUnheard), 2.0);
  history.add(10.0, {"b", "a"}, {1.0, -1.0});
  history.add(10.4, {"a", "other", "b"}, {1.0, 9.0, 2.0});
  EXPECT_TRUE(history.at(10.1, 0)->isApprox(two(-0.5, 1.25), 1e-9));
  EXPECT_TRUE(history.at(10.0, 0)->isApprox(two(-1.0, 1.0)));
  EXPECT_TRUE(history.at(10.4, 0)->isApprox(two(1.0, 2.0)));
}

TEST(JointHistory, NothingIsToldOfTimesThatItDoesNotKnow) {
  JointHistory history({"a", "b"}, two(kUnheard, kUnheard), 1.0);
  EXPECT_FALSE(history.at(0.0, 100.0));
  for (int i = 0; i <= 20; ++i) history.add(0.1 * i, {"a", "b"}, {1.0 * i, 0.0});
  EXPECT_FALSE(history.at(0.95, 0)) << "older than the span";
  EXPECT_NEAR((*history.at(1.05, 0))[0], 10.5, 1e-9);
  EXPECT_EQ((*history.at(2.05, 0.1))[0], 20.0);
  EXPECT_FALSE(history.at(2.15, 0.1)) << "too far behind the newest";
}

TEST(JointHistory, EveryJointMustBeHeardOfThatHasNoInitialPosition) {
  JointHistory history({"a", "finger"}, two(kUnheard, 0.01), 1.0);
  history.add(1.0, {"finger"}, {0.02});
  EXPECT_FALSE(history.at(1.0, 1.0));
  history.add(1.1, {"a"}, {0.5});
  EXPECT_TRUE(history.at(1.1, 0)->isApprox(two(0.5, 0.02)));
  history.add(1.2, {"a"}, {std::numeric_limits<double>::infinity()});
  EXPECT_EQ(history.newest_s(), 1.1);
}

TEST(JointHistory, LateMessagesArePassedOverAndAClockThatWentBackBeginsAnew) {
  JointHistory history({"a", "b"}, two(kUnheard, kUnheard), 1.0);
  history.add(50.0, {"a", "b"}, {1.0, 1.0});
  history.add(49.5, {"a", "b"}, {7.0, 7.0});
  EXPECT_FALSE(history.at(49.5, 0));
  EXPECT_TRUE(history.at(50.0, 0)->isApprox(two(1.0, 1.0)));
  history.add(3.0, {"a"}, {2.0});
  EXPECT_TRUE(history.at(3.0, 0)->isApprox(two(2.0, 1.0)));
  EXPECT_FALSE(history.at(50.0, 0.5));
}

TEST(JointHistory, WhatCannotBeIsRefused) {
  EXPECT_THROW(JointHistory({"a"}, two(0, 0), 1.0), std::invalid_argument);
  EXPECT_THROW(JointHistory({"a", "b"}, two(0, 0), 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace extperfc::arm
