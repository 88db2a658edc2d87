// Parameters: what is refused, what GMapping's users bring along, and that the shipped configuration has the
// defaults.
#include <cmath>

#include <ros/package.h>
#include <ros/param.h>
#include <yaml-cpp/yaml.h>

#include "extperfc/mapping/param_names.hpp"

#include "ros/params/mapper_params.hpp"
#include "test/ros/mapping/mapper_test.hpp"

namespace extperfc::ros_test {
namespace {

constexpr const char* kNs = "/mapper_under_test";

class MapperParamsTest : public testing::Test {
 protected:
  MapperParamsTest() { (void)ros::param::del(kNs); }
  ~MapperParamsTest() override { (void)ros::param::del(kNs); }

  static void set(const std::string& key, const XmlRpc::XmlRpcValue& value) {
    ros::param::set(std::string(kNs) + "/" + key, value);
  }
  static Result<ros_params::MapperNodeletParams> read() {
    return ros_params::load_mapper_params(ros::NodeHandle(kNs));
  }
};

XmlRpc::XmlRpcValue value_of(const YAML::Node& node) {
  const auto text = node.as<std::string>();
  double number = 0;
  bool flag = false;
  if (node.Tag() == "!") return text;
  if (YAML::convert<double>::decode(node, number))
    return text.find('.') == std::string::npos ? XmlRpc::XmlRpcValue(static_cast<int>(number))
                                               : XmlRpc::XmlRpcValue(number);
  if (YAML::convert<bool>::decode(node, flag)) return flag;
  return text;
}

TEST_F(MapperParamsTest, TheShippedConfigurationHasTheDefaults) {
  const auto defaults = read();
  const auto file = YAML::LoadFile(ros::package::getPath("extperfc") + "/config/mapper.yaml");
  for (const auto& entry : file) set(entry.first.as<std::string>(), value_of(entry.second));
  const auto shipped = read();
  ASSERT_TRUE(defaults && shipped) << shipped.error().message;
  for (const auto& name : mapping::param_names()) {
    EXPECT_EQ(mapping::param_text(defaults->mapper, name), mapping::param_text(shipped->mapper, name))
        << name.name;
    EXPECT_TRUE(file[std::string(name.name)]) << name.name << " is not in the file";
  }
  EXPECT_EQ(defaults->odometry, shipped->odometry);
  EXPECT_EQ(defaults->use_imu, shipped->use_imu);
  EXPECT_EQ(defaults->multi_echo, shipped->multi_echo);
  EXPECT_EQ(defaults->throttle_scans, shipped->throttle_scans);
  EXPECT_EQ(defaults->queue_size, shipped->queue_size);
  EXPECT_EQ(defaults->map_update_interval, shipped->map_update_interval);
  EXPECT_EQ(defaults->trajectory_interval_s, shipped->trajectory_interval_s);
  EXPECT_EQ(defaults->transform_publish_period, shipped->transform_publish_period);
  EXPECT_EQ(defaults->tf_delay, shipped->tf_delay);
  EXPECT_EQ(defaults->transform_timeout_s, shipped->transform_timeout_s);
  EXPECT_EQ(defaults->max_tilt_rad, shipped->max_tilt_rad);
  EXPECT_EQ(defaults->odometry_max_speed_m_s, shipped->odometry_max_speed_m_s);
  EXPECT_EQ(defaults->odometry_max_yaw_rate_rad_s, shipped->odometry_max_yaw_rate_rad_s);
  EXPECT_EQ(defaults->timeout_s, shipped->timeout_s);
  EXPECT_EQ(defaults->diagnostic_period, shipped->diagnostic_period);
  EXPECT_EQ(shipped->notice, "");
}

/// What a launch file for slam_gmapping sets.
TEST_F(MapperParamsTest, AConfigurationOfGmapping) {
  const std::map<std::string, XmlRpc::XmlRpcValue> gmapping{{"base_frame", "base_footprint"},
                                                            {"odom_frame", "/odom"},
                                                            {"map_frame", "map"},
                                                            {"map_update_interval", 2.0},
                                                            {"maxUrange", 6.0},
                                                            {"maxRange", 8.0},
                                                            {"sigma", 0.05},
                                                            {"kernelSize", 1},
                                                            {"lstep", 0.05},
                                                            {"astep", 0.05},
                                                            {"iterations", 5},
                                                            {"lsigma", 0.075},
                                                            {"ogain", 3.0},
                                                            {"lskip", 0},
                                                            {"srr", 0.01},
                                                            {"srt", 0.02},
                                                            {"str", 0.01},
                                                            {"stt", 0.02},
                                                            {"linearUpdate", 0.5},
                                                            {"angularUpdate", 0.436},
                                                            {"temporalUpdate", -1.0},
                                                            {"resampleThreshold", 0.5},
                                                            {"particles", 80},
                                                            {"xmin", -1.0},
                                                            {"ymin", -1.0},
                                                            {"xmax", 1.0},
                                                            {"ymax", 1.0},
                                                            {"delta", 0.05},
                                                            {"llsamplerange", 0.01},
                                                            {"llsamplestep", 0.01},
                                                            {"lasamplerange", 0.005},
                                                            {"lasamplestep", 0.005},
                                                            {"transform_publish_period", 0.1},
                                                            {"occ_thresh", 0.3},
                                                            {"throttle_scans", 2},
                                                            {"minimumScore", 0.3}};
  for (const auto& [key, value] : gmapping) set(key, value);
  const auto params = read();
  ASSERT_TRUE(params) << params.error().message;
  EXPECT_EQ(params->base_frame, "base_footprint");
  EXPECT_EQ(params->odom_frame, "odom");
  EXPECT_EQ(params->map_update_interval, 2.0);
  EXPECT_EQ(params->transform_publish_period, 0.1);
  EXPECT_EQ(params->tf_delay, 0.1) << "slam_gmapping's default: the period";
  EXPECT_EQ(params->throttle_scans, 2);
  const auto& mapper = params->mapper;
  EXPECT_EQ(mapper.max_usable_range_m, 6.0);
  EXPECT_EQ(mapper.max_range_m, 8.0);
  EXPECT_EQ(mapper.srt, 0.02);
  EXPECT_EQ(mapper.linear_update_m, 0.5);
  EXPECT_EQ(mapper.angular_update_rad, 0.436);
  EXPECT_EQ(mapper.particles, 80);
  EXPECT_EQ(mapper.occupied_threshold, 0.3);
  EXPECT_EQ(mapper.minimum_score, 0.3);
  for (const char* idle :
       {"sigma", "kernelSize", "lstep", "astep", "iterations", "lsigma", "ogain", "lskip", "xmin", "ymin",
        "xmax", "ymax", "llsamplerange", "llsamplestep", "lasamplerange", "lasamplestep"})
    EXPECT_NE(params->notice.find(idle), std::string::npos) << idle << " has no effect: " << params->notice;
  EXPECT_EQ(params->notice.find("particles"), std::string::npos) << params->notice;
}

TEST_F(MapperParamsTest, GmappingsMinimumScoreIsASumOverRays) {
  set("minimumScore", 50);
  const auto params = read();
  ASSERT_TRUE(params);
  EXPECT_EQ(params->mapper.minimum_score, mapping::MapperParams().minimum_score);
  EXPECT_NE(params->notice.find("minimumScore"), std::string::npos) << params->notice;
}

TEST_F(MapperParamsTest, EveryProblemIsNamedAtOnce) {
  set("particles", 0);
  set("delta", "fine");
  set("odometry", "wheels");
  set("map_frame", "odom");
  set("queue_size", 2.5);
  set("linear_update", 1.0);
  const auto params = read();
  ASSERT_FALSE(params);
  for (const char* text :
       {"/mapper_under_test/particles = 0 is out of its range [1, 1000]",
        "/mapper_under_test/delta must be a number, but is 'fine'", "'wheels' is unknown: use one of",
        "must be three different frames", "/mapper_under_test/queue_size must be a whole number",
        "/mapper_under_test/linear_update is not a parameter of this nodelet; it knows:"})
    EXPECT_NE(params.error().message.find(text), std::string::npos) << text << "\n" << params.error().message;
}

TEST_F(MapperParamsTest, EveryParameterOfTheMapperIsKnownAndItsRangeIsTheMappers) {
  for (const auto& name : mapping::param_names()) {
    if (name.name == "minimumScore" || name.name == "temporalUpdate" || name.name == "seed") continue;
    (void)ros::param::del(kNs);
    set(std::string(name.name), -5);
    const auto below = read();
    ASSERT_FALSE(below) << name.name;
    EXPECT_NE(below.error().message.find(std::string(name.name)), std::string::npos) << below.error().message;
    EXPECT_EQ(below.error().message.find("is not a parameter"), std::string::npos) << below.error().message;
  }
}

TEST_F(MapperTest, RefusesToStartWithAllReasonsInOneMessage) {
  EXPECT_FALSE(
      manager_.load("/mapper", "mapper", {{"particles", 5000}, {"sigmma", 0.05}, {"use_imu", "yes"}}));
  ASSERT_TRUE(log_.wait("/mapper/particles = 5000 is out of its range [1, 1000]"));
  EXPECT_EQ(log_.count("/mapper/particles"), 1U);
  for (const char* text : {"/mapper/sigmma is not a parameter", "/mapper/use_imu must be true or false"})
    EXPECT_NE(log_.text().find(text), std::string::npos) << text << "\n" << log_.text();
}

TEST_F(MapperTest, ParametersWithoutEffectAreNamedInOneLine) {
  mount_lidar();
  load({{"sigma", 0.05}, {"kernelSize", 1}, {"xmin", -100.0}});
  ASSERT_TRUE(log_.wait("have no meaning here and no effect: sigma, kernelSize, xmin"));
  EXPECT_EQ(log_.count("no effect"), 1U);
  ASSERT_TRUE(feed({0, 0, 0}));
}

}  // namespace
}  // namespace extperfc::ros_test
