// The parameters: amcl's files load, ours too, and what is wrong is said at once.
#include <cmath>

#include <ros/package.h>
#include <ros/param.h>
#include <yaml-cpp/yaml.h>

#include "ros/params/localizer_params.hpp"
#include "test/ros/localize/localizer_test.hpp"

namespace extperfc::ros_test {
namespace {

const std::string kNamespace = "/localizer_under_test";

XmlRpc::XmlRpcValue value_of(const YAML::Node& node) {
  const auto text = node.as<std::string>();
  double number = 0;
  bool flag = false;
  if (node.Tag() != "!" && YAML::convert<double>::decode(node, number))
    return text.find_first_of(".e") == std::string::npos ? XmlRpc::XmlRpcValue(static_cast<int>(number))
                                                         : XmlRpc::XmlRpcValue(number);
  if (node.Tag() != "!" && YAML::convert<bool>::decode(node, flag)) return {flag};
  return {text};
}

/// As rosparam loads a file.
Result<ros_params::LocalizerNodeParams> load_yaml(const YAML::Node& file) {
  (void)ros::param::del(kNamespace);
  for (const auto& entry : file)
    ros::param::set(kNamespace + "/" + entry.first.as<std::string>(), value_of(entry.second));
  auto params = ros_params::load_localizer_params(ros::NodeHandle(kNamespace));
  (void)ros::param::del(kNamespace);
  return params;
}

// What launch files for amcl hold: every parameter of its documentation.
constexpr const char* kForAmcl = R"(
use_map_topic: true
first_map_only: false
odom_model_type: diff
odom_alpha1: 0.2
odom_alpha2: 0.3
odom_alpha3: 0.8
odom_alpha4: 0.2
odom_alpha5: 0.1
gui_publish_rate: 10.0
save_pose_rate: 0.25
laser_min_range: 0.1
laser_max_range: 12
laser_max_beams: 30
min_particles: 500
max_particles: 5000
kld_err: 0.05
kld_z: 0.99
laser_z_hit: 0.5
laser_z_short: 0.05
laser_z_max: 0.05
laser_z_rand: 0.5
laser_sigma_hit: 0.2
laser_lambda_short: 0.1
laser_model_type: likelihood_field_prob
laser_likelihood_max_dist: 2.0
update_min_d: 0.2
update_min_a: 0.5
odom_frame_id: /odom
base_frame_id: base_footprint
global_frame_id: map
resample_interval: 1
selective_resampling: true
transform_tolerance: 0.1
recovery_alpha_slow: 0.0
recovery_alpha_fast: 0.0
tf_broadcast: true
do_beamskip: false
beam_skip_distance: 0.5
beam_skip_threshold: 0.3
beam_skip_error_threshold: 0.9
bag_scan_period: -1.0
std_warn_level_x: 0.2
std_warn_level_y: 0.2
std_warn_level_yaw: 0.1
force_update_after_initialpose: true
force_update_after_set_map: true
restore_defaults: false
initial_pose_x: 1.5
initial_pose_y: -2
initial_pose_a: 0.75
initial_cov_xx: 0.25
initial_cov_yy: 0.25
initial_cov_aa: 0.07
)";

TEST(LocalizerParams, AFileForAmclLoads) {
  const auto params = load_yaml(YAML::Load(kForAmcl));
  ASSERT_TRUE(params) << params.error().message;
  EXPECT_EQ(params->filter.min_particles, 500);
  EXPECT_EQ(params->filter.laser_max_beams, 30);
  EXPECT_EQ(params->filter.laser_max_range, 12);
  EXPECT_EQ(params->filter.resample_interval, 1);
  EXPECT_EQ(params->filter.recovery_alpha_fast, 0);
  EXPECT_EQ(params->filter.odometry_model, localize::OdometryModel::kDifferential);
  EXPECT_NEAR(params->filter.odom_alpha2, 0.09, 1e-12) << "of the faulty model: squared";
  EXPECT_EQ(params->filter.sensor_model, localize::SensorModel::kLikelihoodField);
  EXPECT_EQ(params->odom_frame, "odom");
  EXPECT_EQ(params->base_frame, "base_footprint");
  EXPECT_EQ(params->initial_pose.x, 1.5);
  EXPECT_EQ(params->initial_pose.y, -2);
  EXPECT_EQ(params->initial_pose.yaw, 0.75);
  EXPECT_EQ(params->initial_variance.z(), 0.07);
  EXPECT_EQ(params->gui_publish_rate, 10);
  EXPECT_EQ(params->save_pose_rate, 0.25);
  EXPECT_TRUE(params->use_map_topic);
  ASSERT_EQ(params->notes.size(), 3U);
  EXPECT_NE(params->notes[0].find("likelihood_field_prob"), std::string::npos);
  EXPECT_NE(params->notes[1].find("odom_model_type diff is faulty in amcl"), std::string::npos);
  EXPECT_NE(params->notes[2].find("do_beamskip, beam_skip_distance"), std::string::npos);
}

TEST(LocalizerParams, EveryOdometryModelOfAmcl) {
  using localize::OdometryModel;
  const std::vector<std::tuple<std::string, OdometryModel, bool>> known{
      {"diff", OdometryModel::kDifferential, true},
      {"omni", OdometryModel::kOmni, true},
      {"diff-corrected", OdometryModel::kDifferential, false},
      {"omni-corrected", OdometryModel::kOmni, false}};
  for (const auto& [name, model, faulty] : known) {
    const auto params = load_yaml(YAML::Load("{odom_model_type: " + name + ", odom_alpha5: 0.3}"));
    ASSERT_TRUE(params) << name;
    EXPECT_EQ(params->filter.odometry_model, model) << name;
    EXPECT_EQ(params->notes.size(), faulty ? 1U : 0U) << name;
    EXPECT_NEAR(params->filter.odom_alpha5, faulty ? 0.09 : 0.3, 1e-12) << name;
  }
  EXPECT_EQ(load_yaml(YAML::Load("{laser_model_type: beam}"))->filter.sensor_model,
            localize::SensorModel::kBeam);
}

TEST(LocalizerParams, OursLoadsWithoutANote) {
  const auto params = load_yaml(YAML::LoadFile(ros::package::getPath("extperfc") + "/config/localizer.yaml"));
  ASSERT_TRUE(params) << params.error().message;
  EXPECT_TRUE(params->notes.empty()) << params->notes.front();
  EXPECT_EQ(params->filter.odometry_model, localize::OdometryModel::kOmni);
  EXPECT_GT(params->filter.recovery_alpha_fast, 0) << "kidnapping is recovered from";
}

// What is loaded at every start replaces the pose that was stored.
TEST(LocalizerParams, APoseThatIsGivenIsInAFileOfItsOwn) {
  const std::string folder = ros::package::getPath("extperfc") + "/config/";
  for (const auto& entry : YAML::LoadFile(folder + "localizer.yaml"))
    EXPECT_NE(entry.first.as<std::string>().rfind("initial_", 0), 0U) << entry.first;
  const auto given = load_yaml(YAML::LoadFile(folder + "initial_pose.yaml"));
  const auto without = load_yaml({});
  ASSERT_TRUE(given) << given.error().message;
  ASSERT_TRUE(without);
  EXPECT_EQ(given->initial_pose.x, without->initial_pose.x);
  EXPECT_EQ(given->initial_pose.y, without->initial_pose.y);
  EXPECT_EQ(given->initial_pose.yaw, without->initial_pose.yaw);
  EXPECT_EQ(given->initial_variance, without->initial_variance);
}

TEST(LocalizerParams, WithoutAnyItHasAmclsFramesAndAStartAtTheOrigin) {
  const auto params = load_yaml({});
  ASSERT_TRUE(params) << params.error().message;
  EXPECT_EQ(params->odom_frame, "odom");
  EXPECT_EQ(params->base_frame, "base_link");
  EXPECT_EQ(params->global_frame, "map");
  EXPECT_FALSE(params->use_map_topic);
  EXPECT_EQ(params->transform_tolerance, 0.1);
  EXPECT_EQ(params->initial_pose.x, 0);
  EXPECT_NEAR(params->initial_variance.z(), std::pow(M_PI / 12, 2), 1e-6);
}

TEST(LocalizerParams, EverythingThatIsWrongIsSaidAtOnce) {
  const auto params =
      load_yaml(YAML::Load("{min_particles: 0, kld_err: many, odom_model_type: steered, laser_model_type: "
                           "sonar, base_frame_id: odom, "
                           "laser_sigma_hit: -1.0, initial_pose_z: 1.0, use_map_topic: 1}"));
  ASSERT_FALSE(params);
  for (const char* text : {"min_particles = 0 is out of its range", "kld_err must be a number",
                           "unknown odom_model_type 'steered'", "unknown laser_model_type 'sonar'",
                           "must be three different frames", "laser_sigma_hit = -1 is out of its range",
                           "initial_pose_z is not a parameter", "use_map_topic must be true or false"})
    EXPECT_NE(params.error().message.find(text), std::string::npos) << text << "\n" << params.error().message;
}

TEST(LocalizerParams, WhatTheCoreRefusesIsRefused) {
  const auto params = load_yaml(YAML::Load("{min_particles: 200, max_particles: 100}"));
  ASSERT_FALSE(params);
  EXPECT_NE(params.error().message.find("min_particles"), std::string::npos);
}

TEST_F(LocalizerTest, BadParametersAreRefused) {
  EXPECT_FALSE(manager_.load("/localizer", "localizer", {{"update_min_d", -1.0}, {"odom_alpha6", 0.1}}));
  ASSERT_TRUE(log_.wait("update_min_d = -1 is out of its range"));
  EXPECT_TRUE(log_.wait("odom_alpha6 is not a parameter"));
}

}  // namespace
}  // namespace extperfc::ros_test
