#include <cmath>

#include <gtest/gtest.h>

#include "simulate/control/mobile_base.hpp"

namespace extperfc::simulate {
namespace {

constexpr double kStep = 1.0 / 240;

BaseParams exact() {
  BaseParams params;
  params.wheel_noise = params.wheel_slip = params.lateral_slip = 0;
  params.gyro_noise_rad_s = params.gyro_bias_rad_s = params.accel_noise_m_s2 = 0;
  return params;
}

bool never_collides(const Pose2&) {
  return false;
}

/// Drives with one command, repeated as a controller repeats it.
void drive(MobileBase& base, const Twist2& velocity, double seconds, double& now_s) {
  for (int i = 0; i < std::lround(seconds / kStep); ++i) {
    now_s += kStep;
    base.command(velocity, now_s);
    base.step(now_s, kStep, never_collides);
  }
}

TEST(Mecanum, WheelsAndTwistAreInverse) {
  Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    const Twist2 twist{rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-2, 2)};
    const Twist2 back = twist_of(wheel_speeds(twist));
    EXPECT_NEAR(back.vx, twist.vx, 1e-12);
    EXPECT_NEAR(back.vy, twist.vy, 1e-12);
    EXPECT_NEAR(back.wz, twist.wz, 1e-12);
  }
}

TEST(Mecanum, SignsOfTheWheels) {
  const auto left = wheel_speeds({0, 1, 0});
  EXPECT_LT(left[0], 0);
  EXPECT_GT(left[1], 0);
  EXPECT_GT(left[2], 0);
  EXPECT_LT(left[3], 0);
}

TEST(MobileBase, DrivesAsCommandedWithinItsAcceleration) {
  MobileBase base(exact(), {}, 1);
  double now = 0;
  drive(base, {0.5, 0, 0}, 2.0, now);
  // A ramp of 0.5 s at 1 m/s^2, then 1.5 s at 0.5 m/s.
  EXPECT_NEAR(base.state().truth.x, 0.125 + 0.75, 0.01);
  EXPECT_NEAR(base.state().truth.y, 0, 1e-12);
  EXPECT_NEAR(base.state().odometry.x, base.state().truth.x, 1e-9);
}

TEST(MobileBase, SidewaysAndTurning) {
  MobileBase base(exact(), {1, 2, M_PI / 2}, 1);
  double now = 0;
  drive(base, {0, 0.4, 0}, 3.0, now);
  EXPECT_LT(base.state().truth.x, 0) << "left of a base that looks along y is -x";
  EXPECT_NEAR(base.state().truth.y, 2, 1e-9);
  drive(base, {0, 0, 0.5}, 2.0, now);
  EXPECT_NEAR(base.state().odometry.yaw + M_PI / 2, base.state().truth.yaw, 1e-9);
}

TEST(MobileBase, StopsWhenCommandsStop) {
  MobileBase base(exact(), {}, 1);
  double now = 0;
  drive(base, {0.5, 0, 0}, 2.0, now);
  for (int i = 0; i < 240; ++i) base.step(now += kStep, kStep, never_collides);
  EXPECT_EQ(base.state().velocity.vx, 0);
  EXPECT_EQ(base.imu().acceleration.x(), 0);
}

TEST(MobileBase, ShortensACommandThatIsTooFastAndIgnoresNaN) {
  MobileBase base(exact(), {}, 1);
  double now = 0;
  drive(base, {30, 40, 0}, 3.0, now);
  EXPECT_NEAR(base.state().velocity.vx, 0.6, 1e-9);
  EXPECT_NEAR(base.state().velocity.vy, 0.8, 1e-9);
  base.command({std::nan(""), 0, 0}, now);
  base.step(now += kStep, kStep, never_collides);
  EXPECT_TRUE(std::isfinite(base.state().truth.x));
}

TEST(MobileBase, AWallStopsItAndItsWheelsGoOn) {
  MobileBase base(exact(), {}, 1);
  double now = 0;
  for (int i = 0; i < 1200; ++i) {
    base.command({0.5, 0, 0}, now += kStep);
    base.step(now, kStep, [](const Pose2& pose) { return pose.x > 1.0; });
  }
  EXPECT_LE(base.state().truth.x, 1.0);
  EXPECT_GT(base.state().truth.x, 0.99);
  EXPECT_TRUE(base.state().blocked);
  EXPECT_GT(base.state().odometry.x, 1.5) << "odometry does not know";
}

TEST(MobileBase, DrivesOutOfWhatOverlapsIt) {
  MobileBase base(exact(), {}, 1);
  double now = 0;
  for (int i = 0; i < 480; ++i) {
    base.command({0.5, 0, 0}, now += kStep);
    base.step(now, kStep, [](const Pose2& pose) { return pose.x < 0.3; });
  }
  EXPECT_GT(base.state().truth.x, 0.3);
}

TEST(MobileBase, OdometryErrorGrowsAsItsNoiseSays) {
  BaseParams params = exact();
  params.wheel_noise = 0.02;
  // Along x the four wheels' errors average; an Ornstein-Uhlenbeck error of correlation time T gives, after t
  // >> T, sigma v sqrt(2 T t) / sqrt(4).
  const double expected = 0.02 * 0.5 * std::sqrt(2 * 0.5 * 20) / 2;
  double sum = 0;
  constexpr int kTrials = 60;
  for (int trial = 0; trial < kTrials; ++trial) {
    MobileBase base(params, {}, 100 + trial);
    double now = 0;
    drive(base, {0.5, 0, 0}, 20.0, now);
    const double along = base.state().odometry.x - base.state().truth.x;
    sum += along * along;
  }
  // The sample deviation of 60 draws lies within 40 % (more than four of its own deviations).
  EXPECT_NEAR(std::sqrt(sum / kTrials), expected, 0.4 * expected);
}

TEST(MobileBase, ASlippingWheelTurnsTheBase) {
  MobileBase base(exact(), {}, 1);
  base.set_slip(0, 0.5);
  double now = 0;
  drive(base, {0.5, 0, 0}, 2.0, now);
  EXPECT_GT(std::abs(base.state().truth.yaw), 0.05);
  EXPECT_NEAR(base.state().odometry.yaw, 0, 1e-9);
}

TEST(MobileBase, ImuFeelsAccelerationAndTurning) {
  MobileBase base(exact(), {}, 1);
  double now = 0;
  drive(base, {0.5, 0, 0}, 0.2, now);
  EXPECT_NEAR(base.imu().acceleration.x(), 1.0, 1e-6);
  EXPECT_NEAR(base.imu().acceleration.z(), 9.81, 1e-9);
  drive(base, {0.5, 0, 0.4}, 2.0, now);
  EXPECT_NEAR(base.imu().angular_velocity.z(), 0.4, 1e-9);
  EXPECT_NEAR(base.imu().acceleration.y(), 0.4 * 0.5, 1e-6) << "centripetal";
}

TEST(MobileBase, TheSameSeedGivesTheSameWay) {
  MobileBase a(BaseParams{}, {}, 9);
  MobileBase b(BaseParams{}, {}, 9);
  MobileBase c(BaseParams{}, {}, 10);
  double now = 0;
  for (auto* base : {&a, &b, &c}) {
    now = 0;
    drive(*base, {0.3, 0.2, 0.1}, 3.0, now);
  }
  EXPECT_EQ(a.state().truth.x, b.state().truth.x);
  EXPECT_EQ(a.state().odometry.yaw, b.state().odometry.yaw);
  EXPECT_NE(a.state().truth.x, c.state().truth.x);
}

}  // namespace
}  // namespace extperfc::simulate
