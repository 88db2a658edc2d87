// What is refused, and what the message names.
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/localize/localizer.hpp"

#include "test/unit/localize/plan.hpp"

namespace extperfc::localize {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

TEST(LocalizerParams, DefaultsAreValid) {
  EXPECT_TRUE(validate(LocalizerParams{}));
}

TEST(LocalizerParams, WhatCannotWorkIsNamed) {
  const std::vector<std::pair<const char*, std::function<void(LocalizerParams&)>>> wrong{
      {"min_particles", [](auto& p) { p.min_particles = 0; }},
      {"min_particles", [](auto& p) { p.min_particles = 501, p.max_particles = 500; }},
      {"max_particles", [](auto& p) { p.max_particles = 1'000'001; }},
      {"kld_err", [](auto& p) { p.kld_err = 0; }},
      {"kld_err", [](auto& p) { p.kld_err = 1; }},
      {"kld_z", [](auto& p) { p.kld_z = 0.5; }},
      {"kld_z", [](auto& p) { p.kld_z = kNan; }},
      {"update_min_d", [](auto& p) { p.update_min_d = -0.1; }},
      {"update_min_a", [](auto& p) { p.update_min_a = kNan; }},
      {"resample_interval", [](auto& p) { p.resample_interval = 0; }},
      {"recovery_alpha_slow", [](auto& p) { p.recovery_alpha_slow = 1; }},
      {"recovery_alpha_fast", [](auto& p) { p.recovery_alpha_fast = -0.1; }},
      {"laser_max_beams", [](auto& p) { p.laser_max_beams = 1; }},
      {"laser_min_range", [](auto& p) { p.laser_min_range = -2; }},
      {"laser_max_range", [](auto& p) { p.laser_min_range = 3, p.laser_max_range = 2; }},
      {"laser_z_hit", [](auto& p) { p.laser_z_hit = 0; }},
      {"laser_z_short", [](auto& p) { p.laser_z_short = -1; }},
      {"laser_z_max", [](auto& p) { p.laser_z_max = kInf; }},
      {"laser_z_rand", [](auto& p) { p.laser_z_rand = 0; }},
      {"laser_sigma_hit", [](auto& p) { p.laser_sigma_hit = 0; }},
      {"laser_lambda_short", [](auto& p) { p.laser_lambda_short = 0; }},
      {"laser_likelihood_max_dist", [](auto& p) { p.laser_likelihood_max_dist = 0; }},
      {"odom_alpha1", [](auto& p) { p.odom_alpha1 = -1; }},
      {"odom_alpha5", [](auto& p) { p.odom_alpha5 = kInf; }}};
  for (const auto& [name, spoil] : wrong) {
    LocalizerParams params;
    spoil(params);
    const auto refused = Localizer::make(params, room().map());
    ASSERT_FALSE(refused) << name;
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
    EXPECT_NE(refused.error().message.find(name), std::string::npos) << refused.error().message;
    EXPECT_EQ(refused.error().message.find('\n'), std::string::npos);
  }
}

TEST(LocalizerMap, DamagedMapsAreRefused) {
  const std::vector<std::pair<const char*, std::function<void(OccupancyGrid&)>>> wrong{
      {"empty", [](auto& m) { m.cells.clear(); }},
      {"width * height", [](auto& m) { m.width += 1; }},
      {"resolution", [](auto& m) { m.resolution_m = 0; }},
      {"resolution", [](auto& m) { m.resolution_m = kNan; }},
      {"origin", [](auto& m) { m.origin.yaw = kInf; }},
      {"no free cell", [](auto& m) { m.cells.assign(m.cells.size(), OccupancyGrid::kUnknown); }}};
  auto good = Localizer::make({}, room().map());
  ASSERT_TRUE(good);
  for (const auto& [name, spoil] : wrong) {
    const auto map = room().map();
    spoil(*map);
    for (const auto& refused : {Localizer::make({}, map).map([](auto&&) {}), good->set_map(map)}) {
      ASSERT_FALSE(refused) << name;
      EXPECT_NE(refused.error().message.find(name), std::string::npos) << refused.error().message;
    }
  }
  EXPECT_FALSE(Localizer::make({}, nullptr));
}

TEST(LocalizerPose, WhatIsNoDistributionIsRefused) {
  auto localizer = Localizer::make({}, room().map());
  ASSERT_TRUE(localizer);
  const Eigen::Matrix3d fine = Eigen::Matrix3d::Identity();
  EXPECT_FALSE(localizer->set_pose({kNan, 0, 0}, fine));
  EXPECT_FALSE(localizer->set_pose({0, 0, kInf}, fine));
  Eigen::Matrix3d covariance = fine;
  covariance(1, 1) = -1;
  EXPECT_FALSE(localizer->set_pose({}, covariance)) << "negative";
  covariance = fine;
  covariance(0, 1) = 0.5;
  EXPECT_FALSE(localizer->set_pose({}, covariance)) << "not symmetric";
  covariance = fine;
  covariance(0, 1) = covariance(1, 0) = 2;
  EXPECT_FALSE(localizer->set_pose({}, covariance)) << "correlated by more than one";
  covariance(2, 2) = kNan;
  EXPECT_FALSE(localizer->set_pose({}, covariance));
  EXPECT_TRUE(localizer->set_pose({}, Eigen::Matrix3d::Zero())) << "certainty is a distribution";
}

TEST(LocalizerScan, DamagedInputLeavesEverythingAsItWas) {
  auto localizer = Localizer::make({}, room().map());
  ASSERT_TRUE(localizer);
  ASSERT_TRUE(localizer->set_pose({5, 4, 0}, 0.01 * Eigen::Matrix3d::Identity()));
  Rng rng(1);
  auto scan = room().scan({5, 4, 0}, rng);
  EXPECT_FALSE(localizer->update(scan, {kNan, 0, 0}));
  scan.angle_increment = 0;
  const auto refused = localizer->update(scan, {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("angle_increment"), std::string::npos);
  EXPECT_EQ(localizer->estimate().pose.x, 5);
  EXPECT_EQ(localizer->particles().size(), static_cast<std::size_t>(LocalizerParams{}.max_particles));
}

}  // namespace
}  // namespace extperfc::localize
