// The shipped configuration says what the code says.
#include <gtest/gtest.h>
#include <ros/package.h>
#include <ros/param.h>
#include <yaml-cpp/yaml.h>

#include "ros/params/faces_params.hpp"

namespace extperfc::ros_test {
namespace {

constexpr const char* kNs = "/faces_under_test";

/// Sets what config/faces.yaml says, as roslaunch does.
void set_from_file() {
  for (const auto& entry : YAML::LoadFile(ros::package::getPath("extperfc") + "/config/faces.yaml")) {
    const auto key = std::string(kNs) + "/" + entry.first.as<std::string>();
    int whole = 0;
    double number = 0.0;
    bool flag = false;
    if (YAML::convert<int>::decode(entry.second, whole)) {
      ros::param::set(key, whole);
    } else if (YAML::convert<double>::decode(entry.second, number)) {
      ros::param::set(key, number);
    } else if (YAML::convert<bool>::decode(entry.second, flag)) {
      ros::param::set(key, flag);
    } else {
      ros::param::set(key, entry.second.as<std::string>());
    }
  }
}

std::vector<double> numbers(const ros_params::FacesParams& p) {
  return {static_cast<double>(p.inference.threads),
          p.score_threshold,
          p.nms_iou,
          static_cast<double>(p.max_faces),
          p.max_rate_hz,
          p.min_face_px,
          p.threshold,
          p.margin,
          static_cast<double>(p.max_features),
          static_cast<double>(p.enroll_samples),
          p.enroll_interval_s,
          static_cast<double>(p.use_depth),
          p.estimate.min_depth_m,
          p.estimate.max_depth_m,
          p.stamp_tolerance_s,
          p.depth_wait_s,
          static_cast<double>(p.depth_queue),
          p.transform_timeout_s,
          p.marker_lifetime_s,
          p.timeout_s};
}

TEST(FacesParams, ShippedConfigurationHasTheDefaults) {
  (void)ros::param::del(kNs);
  ros::param::set(std::string(kNs) + "/model", "/somewhere");
  const auto defaults = ros_params::load_faces_params(ros::NodeHandle(kNs));
  set_from_file();
  const auto shipped = ros_params::load_faces_params(ros::NodeHandle(kNs));
  (void)ros::param::del(kNs);
  ASSERT_TRUE(defaults && shipped) << shipped.error().message;
  EXPECT_EQ(numbers(*shipped), numbers(*defaults));
  EXPECT_EQ(shipped->inference.backend, defaults->inference.backend);
  EXPECT_EQ(shipped->inference.device, defaults->inference.device);
  EXPECT_EQ(shipped->embedder, "lbp");
}

}  // namespace
}  // namespace extperfc::ros_test
