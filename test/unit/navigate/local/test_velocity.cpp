#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/velocity.hpp"

namespace extperfc::navigate {
namespace {

constexpr double kTiny = 1e-9;

VelocityLimits random_limits(Rng& rng) {
  return {rng.uniform(0.1, 2), -rng.uniform(0, 1),  rng.chance(0.3) ? 0 : rng.uniform(0.1, 1),
          rng.uniform(0.2, 3), rng.uniform(0.2, 3), rng.uniform(0.2, 3),
          rng.uniform(0.5, 5)};
}

Twist2 random_twist(Rng& rng) {
  return {rng.uniform(-3, 3), rng.uniform(-3, 3), rng.uniform(-5, 5)};
}

/// Part of the ellipse that a translation uses; infinite along a half axis of 0.
double used(const Twist2& twist, const VelocityLimits& limits) {
  const auto part = [](double speed, double axis) {
    return axis > 0 ? speed / axis : (speed == 0 ? 0 : INFINITY);
  };
  return std::hypot(part(twist.vx, twist.vx >= 0 ? limits.max_vx_m_s : -limits.min_vx_m_s),
                    part(twist.vy, limits.max_vy_m_s));
}

TEST(VelocityLimits, NamesTheLimitOutOfItsRange) {
  EXPECT_TRUE(validate(VelocityLimits{}));
  VelocityLimits limits;
  limits.max_vx_m_s = 0;
  ASSERT_FALSE(validate(limits));
  EXPECT_NE(validate(limits).error().message.find("max_vx_m_s"), std::string::npos);
  limits = {};
  limits.min_vx_m_s = 0.1;
  EXPECT_FALSE(validate(limits));
  limits = {};
  limits.acc_wz_rad_s2 = NAN;
  EXPECT_FALSE(validate(limits));
  limits = {};
  limits.max_vy_m_s = 0;
  limits.min_vx_m_s = 0;
  EXPECT_TRUE(validate(limits));
}

TEST(VelocityLimits, KeepsTheDirectionInsideTheEllipse) {
  Rng rng(1);
  for (int i = 0; i < 2000; ++i) {
    const VelocityLimits limits = random_limits(rng);
    const Twist2 wanted = random_twist(rng);
    const double factor = rng.uniform(0, 1);
    const Twist2 result = limited(wanted, limits, factor);
    EXPECT_LE(used(result, limits), factor + kTiny) << i;
    EXPECT_LE(std::abs(result.wz), factor * limits.max_wz_rad_s + kTiny) << i;
    const bool direction_exists = limits.max_vy_m_s > 0 && (wanted.vx >= 0 || limits.min_vx_m_s < 0);
    if (direction_exists) {
      EXPECT_NEAR(wanted.vx * result.vy - wanted.vy * result.vx, 0, 1e-9) << i;
      EXPECT_GE(wanted.vx * result.vx + wanted.vy * result.vy, 0) << i;
    }
    const Twist2 again = limited(result, limits, factor);
    EXPECT_NEAR(again.vx, result.vx, kTiny) << i;
    EXPECT_NEAR(again.vy, result.vy, kTiny) << i;
    EXPECT_NEAR(again.wz, result.wz, kTiny) << i;
  }
}

TEST(VelocityLimits, LeavesAdmissibleOnesAlone) {
  const VelocityLimits limits;
  const Twist2 result = limited({0.3, -0.2, 0.5}, limits);
  EXPECT_EQ(result.vx, 0.3);
  EXPECT_EQ(result.vy, -0.2);
  EXPECT_EQ(result.wz, 0.5);
}

TEST(VelocityLimits, ChangesNoFasterThanTheAccelerationsAndArrives) {
  Rng rng(2);
  for (int i = 0; i < 500; ++i) {
    const VelocityLimits limits = random_limits(rng);
    const Twist2 wanted = random_twist(rng);
    const Twist2 target = limited(wanted, limits);
    Twist2 now = limited(random_twist(rng), limits);
    constexpr double kStep_s = 0.05;
    for (int step = 0; step < 600; ++step) {
      const Twist2 next = limited_change(wanted, now, limits, kStep_s);
      const double change =
          std::hypot((next.vx - now.vx) / limits.acc_x_m_s2, (next.vy - now.vy) / limits.acc_y_m_s2);
      ASSERT_LE(change, kStep_s + kTiny) << i;
      ASSERT_LE(std::abs(next.wz - now.wz), limits.acc_wz_rad_s2 * kStep_s + kTiny) << i;
      ASSERT_LE(used(next, limits), 1 + 1e-6) << i;  // the admissible set is convex
      now = next;
    }
    EXPECT_NEAR(now.vx, target.vx, kTiny) << i;
    EXPECT_NEAR(now.vy, target.vy, kTiny) << i;
    EXPECT_NEAR(now.wz, target.wz, kTiny) << i;
  }
}

TEST(VelocityLimits, BrakesAlongTheSameArc) {
  const VelocityLimits limits;
  Twist2 now{0.8, 0, 0.6};
  const double ratio = now.wz / now.vx;
  for (int step = 0; step < 10; ++step) {
    now = limited_change({}, now, limits, 0.05);
    if (now.vx > 0) {
      EXPECT_NEAR(now.wz / now.vx, ratio, 1e-9);
    }
  }
}

}  // namespace
}  // namespace extperfc::navigate
