// Parameters of the nodelets: defaults, types, ranges, unknown keys, and that every shipped configuration
// loads.
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <ros/package.h>
#include <ros/param.h>
#include <yaml-cpp/yaml.h>

#include "ros/params/box_depth_params.hpp"
#include "ros/params/detector_params.hpp"
#include "ros/params/param_reader.hpp"
#include "ros/params/source_params.hpp"
#include "ros/params/tracker_params.hpp"
#include "test/ros/support/recording.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::ros_test {
namespace {

using namespace ros_params;  // NOLINT: under test

class ParamsTest : public testing::Test {
 protected:
  ParamsTest() { (void)ros::param::del(kNs); }

  template <typename T>
  static void set(const std::string& key, const T& value) {
    ros::param::set(std::string(kNs) + "/" + key, value);
  }

  [[nodiscard]] static ros::NodeHandle handle() { return ros::NodeHandle(kNs); }

  static constexpr const char* kNs = "/nodelet_under_test";
};

TEST_F(ParamsTest, UnsetKeysLeaveTheDefaults) {
  int whole = 3;
  double number = 0.5;
  bool flag = true;
  std::string text = "as it was";
  ParamReader reader(handle());
  reader.read("whole", whole, {0, 10});
  reader.read("number", number, {0.0, 1.0});
  reader.read("flag", flag);
  reader.read("text", text);
  EXPECT_TRUE(reader.finish());
  EXPECT_EQ(whole, 3);
  EXPECT_EQ(number, 0.5);
  EXPECT_TRUE(flag);
  EXPECT_EQ(text, "as it was");
}

TEST_F(ParamsTest, SetKeysAreRead) {
  set("whole", 7);
  set("number", 0.25);
  set("number_as_whole", 1);
  set("flag", false);
  set("text", std::string("new"));
  int whole = 0;
  double number = 0.0;
  double from_whole = 0.0;
  bool flag = true;
  std::string text;
  ParamReader reader(handle());
  reader.read("whole", whole, {0, 10});
  reader.read("number", number, {0.0, 1.0});
  reader.read("number_as_whole", from_whole, {0.0, 1.0});
  reader.read("flag", flag);
  reader.read("text", text);
  EXPECT_TRUE(reader.finish());
  EXPECT_EQ(whole, 7);
  EXPECT_EQ(number, 0.25);
  EXPECT_EQ(from_whole, 1.0) << "1 is a number too";
  EXPECT_FALSE(flag);
  EXPECT_EQ(text, "new");
}

TEST_F(ParamsTest, BoundsBelongToTheRange) {
  for (const int value : {0, 10, -1, 11}) {
    set("whole", value);
    int whole = 5;
    ParamReader reader(handle());
    reader.read("whole", whole, {0, 10});
    const bool inside = value >= 0 && value <= 10;
    EXPECT_EQ(reader.finish().has_value(), inside) << value;
    EXPECT_EQ(whole, inside ? value : 5) << "a value that is refused is not taken";
  }
}

TEST_F(ParamsTest, EveryProblemHasItsLine) {
  set("whole", 1.5);
  set("number", std::string("much"));
  set("flag", 1);
  set("text", true);
  set("typo", 1);
  int whole = 0;
  double number = 0.0;
  bool flag = false;
  std::string text;
  std::string path;
  ParamReader reader(handle());
  reader.read("whole", whole, {0, 10});
  reader.read("number", number, {0.0, 1.0});
  reader.read("flag", flag);
  reader.read("text", text);
  reader.require("path", path, "name a folder");
  reader.complain("these do not fit together");
  const auto finished = reader.finish();
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().code, ErrorCode::kInvalidArgument);
  const auto& message = finished.error().message;
  for (const char* expected :
       {"/nodelet_under_test/whole must be a whole number, but is '1.5'",
        "/nodelet_under_test/number must be a number, but is 'much'",
        "/nodelet_under_test/flag must be true or false, but is '1'",
        "/nodelet_under_test/text must be a text, but is '1'",
        "/nodelet_under_test/path is not set: name a folder", "these do not fit together",
        "/nodelet_under_test/typo is not a parameter of this nodelet; it knows:"})
    EXPECT_NE(message.find(expected), std::string::npos) << expected << "\nis not in\n" << message;
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 6) << message;
}

TEST_F(ParamsTest, ClassNamesComeBackFromWhereTheyWereStored) {
  const std::vector<std::string> names{"cup", "", "traffic light"};
  store_class_names(handle(), names);
  EXPECT_EQ(load_class_names(std::string(kNs) + "/classes"), names);
  EXPECT_TRUE(load_detector_params(handle())) << "what the detector wrote must not stop it the next time";
}

TEST_F(ParamsTest, ClassNamesThatAreNotThereAreNone) {
  set("number", 1);
  for (const char* location : {"", "/no/such/parameter", "/nodelet_under_test/number",
                               "https://example.org/a b.json", "C:\\names", "~", "/", "5"})
    EXPECT_TRUE(load_class_names(location).empty()) << location;
}

TEST_F(ParamsTest, CameraIsAllOrNothing) {
  set("path", std::string("/somewhere"));
  EXPECT_FALSE(load_source_params(handle())->camera) << "no camera is given";
  set("fx", 500.0);
  const auto incomplete = load_source_params(handle());
  ASSERT_FALSE(incomplete);
  EXPECT_NE(incomplete.error().message.find("belong together"), std::string::npos)
      << incomplete.error().message;
  set("fy", 501.0);
  set("cx", 320.0);
  set("cy", 240.0);
  set("width", 640);
  set("height", 480);
  const auto complete = load_source_params(handle());
  ASSERT_TRUE(complete) << complete.error().message;
  ASSERT_TRUE(complete->camera);
  EXPECT_EQ(complete->camera->fy, 501.0);
}

TEST_F(ParamsTest, PartOfACameraIsRefused) {
  set("path", std::string("/somewhere"));
  set("cx", 320.0);
  set("cy", 240.0);
  EXPECT_FALSE(load_source_params(handle())) << "cx without fx would be ignored silently";
}

/// Sets what a file of config/ says, as roslaunch does.
void set_from_file(const std::string& name) {
  const auto file = YAML::LoadFile(ros::package::getPath("extperfc") + "/config/" + name);
  for (const auto& entry : file) {
    const auto key = "/nodelet_under_test/" + entry.first.as<std::string>();
    const auto& value = entry.second;
    int whole = 0;
    double number = 0.0;
    bool flag = false;
    if (value.IsMap()) {
      ros::param::set(key, value.as<std::map<std::string, std::string>>());
    } else if (YAML::convert<int>::decode(value, whole)) {
      ros::param::set(key, whole);
    } else if (YAML::convert<double>::decode(value, number)) {
      ros::param::set(key, number);
    } else if (YAML::convert<bool>::decode(value, flag)) {
      ros::param::set(key, flag);
    } else {
      ros::param::set(key, value.as<std::string>());
    }
  }
}

TEST_F(ParamsTest, ShippedDetectorConfigurationHasTheDefaults) {
  const auto defaults = load_detector_params(handle());
  set_from_file("detector.yaml");
  const auto shipped = load_detector_params(handle());
  ASSERT_TRUE(defaults && shipped) << shipped.error().message;
  EXPECT_EQ(shipped->inference.backend, defaults->inference.backend);
  EXPECT_EQ(shipped->inference.device, defaults->inference.device);
  EXPECT_EQ(shipped->inference.threads, defaults->inference.threads);
  EXPECT_EQ(shipped->inference.precision, defaults->inference.precision);
  EXPECT_EQ(shipped->inference.mode, defaults->inference.mode);
  EXPECT_EQ(shipped->enabled, defaults->enabled);
  EXPECT_EQ(shipped->score_threshold, defaults->score_threshold);
  EXPECT_EQ(shipped->nms_iou, defaults->nms_iou);
  EXPECT_EQ(shipped->max_detections, defaults->max_detections);
  EXPECT_EQ(shipped->class_filter, defaults->class_filter);
  EXPECT_EQ(shipped->timeout_s, defaults->timeout_s);
}

TEST_F(ParamsTest, ShippedBoxDepthConfigurationHasTheDefaults) {
  const auto defaults = load_box_depth_params(handle());
  set_from_file("box_depth.yaml");
  const auto shipped = load_box_depth_params(handle());
  ASSERT_TRUE(defaults && shipped) << shipped.error().message;
  EXPECT_EQ(shipped->estimate.estimator, defaults->estimate.estimator);
  EXPECT_EQ(shipped->estimate.window_px, defaults->estimate.window_px);
  EXPECT_EQ(shipped->estimate.central_fraction, defaults->estimate.central_fraction);
  EXPECT_EQ(shipped->estimate.min_depth_m, defaults->estimate.min_depth_m);
  EXPECT_EQ(shipped->estimate.max_depth_m, defaults->estimate.max_depth_m);
  EXPECT_EQ(shipped->estimate.min_valid_px, defaults->estimate.min_valid_px);
  EXPECT_EQ(shipped->enabled, defaults->enabled);
  EXPECT_EQ(shipped->min_score, defaults->min_score);
  EXPECT_EQ(shipped->class_filter, defaults->class_filter);
  EXPECT_EQ(shipped->cloud_history, defaults->cloud_history);
  EXPECT_EQ(shipped->stamp_tolerance_s, defaults->stamp_tolerance_s);
  EXPECT_EQ(shipped->transform_timeout_s, defaults->transform_timeout_s);
  EXPECT_EQ(shipped->depth_queue, defaults->depth_queue);
  EXPECT_EQ(shipped->marker_lifetime_s, defaults->marker_lifetime_s);
  EXPECT_EQ(shipped->timeout_s, defaults->timeout_s);
  EXPECT_EQ(shipped->fit_objects, defaults->fit_objects);
  EXPECT_TRUE(defaults->shapes.empty()) << "classes are a matter of the detector, so the code knows none";
  EXPECT_EQ(shipped->shapes.size(), 3U);
}

TEST_F(ParamsTest, ShapesBelongToClasses) {
  set("shapes/dice", std::string("cube"));
  set("shapes/ball", std::string("sphere"));
  const auto params = load_box_depth_params(handle());
  ASSERT_TRUE(params) << params.error().message;
  EXPECT_EQ(params->shapes, (std::map<std::string, depth::FitShape>{{"ball", depth::FitShape::kSphere},
                                                                    {"dice", depth::FitShape::kCube}}));
}

TEST_F(ParamsTest, ShapesThatCannotBeAreReported) {
  const auto expect = [](const char* problem) {
    const auto params = load_box_depth_params(handle());
    ASSERT_FALSE(params);
    EXPECT_NE(params.error().message.find(problem), std::string::npos) << params.error().message;
  };
  set("target_frame", std::string("table"));
  set("fit_objects", true);
  expect("fit_objects needs shapes");
  set("shapes/dice", std::string("dodecahedron"));
  expect("/nodelet_under_test/shapes/dice: 'dodecahedron' is unknown: use one of cone, cube, sphere");
  set("shapes/dice", 3);
  expect("/nodelet_under_test/shapes/dice: ");
  set("shapes", std::string("cube"));
  expect("/nodelet_under_test/shapes must be a group of labels and names, e.g. {label: cone}");
}

TEST_F(ParamsTest, ShippedTrackerConfigurationHasTheDefaults) {
  const auto defaults = load_tracker_params(handle());
  set_from_file("tracker.yaml");
  const auto shipped = load_tracker_params(handle());
  ASSERT_TRUE(defaults && shipped) << shipped.error().message;
  const auto numbers = [](const TrackerNodeletParams& p) {
    const auto& t = p.tracker;
    return std::vector<double>{t.acceleration_m_s2,   t.speed_m_s,
                               t.min_sigma_m,         t.gate,
                               t.class_cost,          static_cast<double>(t.confirm_hits),
                               t.max_missed_s,        t.max_missed_new_s,
                               p.transform_timeout_s, static_cast<double>(t.max_tracks),
                               t.manoeuvre_m_s,       p.timeout_s};
  };
  EXPECT_EQ(numbers(*shipped), numbers(*defaults));
  EXPECT_EQ(shipped->publish_tentative, defaults->publish_tentative);
}

TEST_F(ParamsTest, WhatIsReadIsDescribed) {
  set("score_threshold", 0.25);
  const auto params = load_detector_params(handle());
  ASSERT_TRUE(params);
  const auto found = std::find_if(params->read.begin(), params->read.end(),
                                  [](const ReadParam& p) { return p.name == "score_threshold"; });
  ASSERT_NE(found, params->read.end());
  auto copy = *found;
  EXPECT_EQ(static_cast<double>(copy.value), 0.25);
  EXPECT_EQ(static_cast<double>(copy.low), -1.0);
  EXPECT_EQ(static_cast<double>(copy.high), 1.0);
}

TEST_F(ParamsTest, ShippedSourceConfigurationHasTheDefaults) {
  set("path", std::string("/somewhere"));
  const auto defaults = load_source_params(handle());
  set_from_file("source.yaml");
  const auto shipped = load_source_params(handle());
  ASSERT_TRUE(defaults && shipped) << shipped.error().message;
  EXPECT_EQ(shipped->wait_for_subscriber, defaults->wait_for_subscriber);
  EXPECT_EQ(shipped->recorded_stamps, defaults->recorded_stamps);
  EXPECT_EQ(shipped->frame_id, defaults->frame_id);
}

}  // namespace
}  // namespace extperfc::ros_test
