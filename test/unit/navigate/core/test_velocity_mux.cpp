// Whose velocity the base gets.
#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/velocity_mux.hpp"

namespace extperfc::navigate {
namespace {

constexpr std::size_t kJoystick = 0;
constexpr std::size_t kOperator = 1;
constexpr std::size_t kNavigator = 2;

VelocityMux make_mux() {
  return *VelocityMux::make({{"joystick", 30, 0.5}, {"operator", 20, 1.0}, {"navigator", 10, 0.3}}, {});
}

TEST(VelocityMux, TheLargestPriorityThatIsNotSilentHasTheBase) {
  auto mux = make_mux();
  mux.command(kNavigator, {0.3, 0, 0}, 10.0);
  EXPECT_EQ(mux.output(10.0)->source, kNavigator);
  mux.command(kJoystick, {-0.1, 0, 0}, 10.1);
  mux.command(kNavigator, {0.3, 0, 0}, 10.2);
  const auto output = mux.output(10.2);
  EXPECT_EQ(output->source, kJoystick);
  EXPECT_DOUBLE_EQ(output->velocity.vx, -0.1);
  mux.command(kNavigator, {0.3, 0, 0}, 10.65);
  EXPECT_EQ(mux.output(10.65)->source, kNavigator) << "the joystick is silent for 0.55 s";
}

TEST(VelocityMux, ZeroIsSentOnceWhenTheLastSourceFallsSilent) {
  auto mux = make_mux();
  EXPECT_FALSE(mux.output(1.0)) << "nothing was ever sent";
  mux.command(kNavigator, {0.3, 0, 0}, 1.0);
  EXPECT_TRUE(mux.output(1.1)->source);
  const auto last = mux.output(1.4);
  ASSERT_TRUE(last);
  EXPECT_FALSE(last->source);
  EXPECT_EQ(last->velocity.vx, 0);
  EXPECT_FALSE(mux.output(1.5));
}

TEST(VelocityMux, TheEmergencyStopSendsZeroAllTheTime) {
  auto mux = make_mux();
  mux.command(kJoystick, {0.5, 0, 0}, 1.0);
  mux.set_stop(true);
  for (double now_s = 1.0; now_s < 1.4; now_s += 0.1) {
    const auto output = mux.output(now_s);
    ASSERT_TRUE(output);
    EXPECT_FALSE(output->source);
    EXPECT_EQ(output->velocity.vx, 0);
  }
  mux.set_stop(false);
  EXPECT_EQ(mux.output(1.45)->source, kJoystick);
}

TEST(VelocityMux, ALockLeavesOutSmallerPriorities) {
  auto mux = make_mux();
  mux.set_lock(20);
  mux.command(kNavigator, {0.3, 0, 0}, 1.0);
  EXPECT_FALSE(mux.output(1.0));
  mux.command(kOperator, {0.2, 0, 0}, 1.0);
  EXPECT_EQ(mux.output(1.0)->source, kOperator);
  mux.set_lock(std::nullopt);
  mux.command(kNavigator, {0.3, 0, 0}, 2.5);
  EXPECT_EQ(mux.output(2.5)->source, kNavigator);
}

TEST(VelocityMux, WhatIsNotFiniteIsIgnored) {
  auto mux = make_mux();
  EXPECT_FALSE(mux.command(kJoystick, {std::nan(""), 0, 0}, 1.0));
  EXPECT_FALSE(mux.command(kJoystick, {0, 0, INFINITY}, 1.0));
  EXPECT_FALSE(mux.output(1.0));
}

TEST(VelocityMux, TimeThatRunsBackMakesEverySourceSilent) {
  auto mux = make_mux();
  mux.command(kNavigator, {0.3, 0, 0}, 100.0);
  ASSERT_TRUE(mux.output(100.0));
  EXPECT_EQ(mux.output(50.0)->velocity.vx, 0);
  EXPECT_FALSE(mux.output(50.1));
}

TEST(VelocityMux, EveryOutputObeysTheLimits) {
  const VelocityLimits limits;
  auto mux = make_mux();
  Rng rng(1);
  for (int i = 0; i < 1000; ++i) {
    mux.command(static_cast<std::size_t>(rng.integer(0, 2)),
                {rng.uniform(-9, 9), rng.uniform(-9, 9), rng.uniform(-9, 9)}, 0.1 * i);
    const auto output = mux.output(0.1 * i);
    ASSERT_TRUE(output);
    EXPECT_LE(std::hypot(output->velocity.vx / limits.max_vx_m_s, output->velocity.vy / limits.max_vy_m_s),
              1 + 1e-9);
    EXPECT_LE(std::abs(output->velocity.wz), limits.max_wz_rad_s + 1e-9);
  }
}

TEST(VelocityMux, BadSourcesAreRefused) {
  EXPECT_FALSE(VelocityMux::make({}, {}));
  EXPECT_NE(VelocityMux::make({{"a", 1, 1}, {"a", 2, 1}}, {}).error().message.find("name"),
            std::string::npos);
  EXPECT_NE(VelocityMux::make({{"a", 1, 1}, {"b", 1, 1}}, {}).error().message.find("priority 1"),
            std::string::npos);
  EXPECT_FALSE(VelocityMux::make({{"a", 1, 0}}, {}));
  EXPECT_FALSE(VelocityMux::make({{"a", 1, std::nan("")}}, {}));
  VelocityLimits limits;
  limits.max_wz_rad_s = 0;
  EXPECT_FALSE(VelocityMux::make({{"a", 1, 1}}, limits));
}

}  // namespace
}  // namespace extperfc::navigate
