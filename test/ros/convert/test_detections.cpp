#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "ros/convert/detections.hpp"
#include "ros/convert/geometry.hpp"

namespace extperfc::ros_convert {
namespace {

std_msgs::Header some_header() {
  std_msgs::Header header;
  header.frame_id = "optical";
  header.stamp = ros::Time(7, 8);
  return header;
}

TEST(Detections2D, ThereAndBackAgain) {
  constexpr std::uint64_t kSeed = 11;
  Rng rng(kSeed);
  Detections detections;
  for (int i = 0; i < 100; ++i) {
    const auto x = static_cast<float>(rng.uniform(0, 600));
    const auto y = static_cast<float>(rng.uniform(0, 400));
    const auto w = static_cast<float>(rng.uniform(1, 100));
    const auto h = static_cast<float>(rng.uniform(1, 100));
    detections.push_back({rng.integer(0, 79), static_cast<float>(rng.uniform(0, 1)), {x, y, x + w, y + h}});
  }
  const auto back = from_message(to_message(detections, some_header()));
  ASSERT_EQ(back.size(), detections.size());
  constexpr float kRoundingPx = 1e-3F;
  for (std::size_t i = 0; i < back.size(); ++i) {
    EXPECT_EQ(back[i].class_index, detections[i].class_index);
    EXPECT_EQ(back[i].score, detections[i].score);
    EXPECT_NEAR(back[i].box.x_min, detections[i].box.x_min, kRoundingPx) << "seed " << kSeed;
    EXPECT_NEAR(back[i].box.y_min, detections[i].box.y_min, kRoundingPx) << "seed " << kSeed;
    EXPECT_NEAR(back[i].box.x_max, detections[i].box.x_max, kRoundingPx) << "seed " << kSeed;
    EXPECT_NEAR(back[i].box.y_max, detections[i].box.y_max, kRoundingPx) << "seed " << kSeed;
  }
}

TEST(Detections2D, HeaderIsEverywhere) {
  const auto message = to_message({{0, 0.5F, {0, 0, 10, 20}}}, some_header());
  EXPECT_EQ(message.header.stamp, ros::Time(7, 8));
  ASSERT_EQ(message.detections.size(), 1U);
  EXPECT_EQ(message.detections[0].header.frame_id, "optical");
  EXPECT_EQ(message.detections[0].bbox.center.x, 5.0);
  EXPECT_EQ(message.detections[0].bbox.center.theta, 0.0);
  EXPECT_EQ(message.detections[0].bbox.size_y, 20.0);
  EXPECT_EQ(message.detections[0].results[0].pose.pose.orientation.w, 1.0);
}

TEST(Detections2D, BestHypothesisCounts) {
  auto message = to_message({{4, 0.3F, {0, 0, 10, 10}}}, some_header());
  message.detections[0].results.resize(3);
  message.detections[0].results[1].id = 9;
  message.detections[0].results[1].score = 0.8;
  EXPECT_EQ(from_message(message)[0].class_index, 9);
  message.detections[0].results.clear();
  EXPECT_EQ(from_message(message)[0].class_index, -1);
  EXPECT_EQ(from_message(message)[0].score, 0.0F);
}

depth::Object3 some_object() {
  depth::Object3 object;
  object.surface = {0.1, -0.2, 1.5};
  object.center = {0.11, -0.21, 1.6};
  object.size = {0.2, 0.3, 0.2};
  object.surface_covariance = Eigen::Vector3d(1e-5, 2e-5, 9e-5).asDiagonal();
  object.center_covariance = Eigen::Vector3d(1e-4, 2e-4, 9e-4).asDiagonal();
  return object;
}

/// A camera that looks along its parent's x axis, as REP 103 has it.
Eigen::Isometry3d base_T_optical() {
  Eigen::Matrix3d rotation;
  rotation << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation;
  pose.translation() = Eigen::Vector3d(0.5, 0.0, 1.0);
  return pose;
}

TEST(Detections3D, InTheOpticalFrame) {
  const auto message = to_message({3, 0.7F, {}}, some_object(), Eigen::Isometry3d::Identity(), some_header());
  EXPECT_EQ(message.results[0].id, 3);
  EXPECT_EQ(message.bbox.center.position.z, 1.6);
  EXPECT_EQ(message.results[0].pose.pose, message.bbox.center);
  EXPECT_EQ(message.bbox.size.y, 0.3);
  EXPECT_EQ(message.bbox.center.orientation.w, 1.0);
  EXPECT_EQ(message.results[0].pose.covariance[14], 9e-4);
  EXPECT_EQ(message.results[0].pose.covariance[21], 0.0) << "nothing is said about the orientation";
}

TEST(Detections3D, InAnotherFrame) {
  const auto message = to_message({3, 0.7F, {}}, some_object(), base_T_optical(), some_header());
  const auto& center = message.results[0].pose.pose.position;
  EXPECT_NEAR(center.x, 0.5 + 1.6, 1e-12);
  EXPECT_NEAR(center.y, -0.11, 1e-12);
  EXPECT_NEAR(center.z, 1.0 + 0.21, 1e-12);
  EXPECT_EQ(message.results[0].pose.pose, message.bbox.center);
  const auto& covariance = message.results[0].pose.covariance;
  EXPECT_NEAR(covariance[0], 9e-4, 1e-12) << "the uncertain depth lies along x now";
  EXPECT_NEAR(covariance[7], 1e-4, 1e-12);
  EXPECT_NEAR(covariance[14], 2e-4, 1e-12);
}

TEST(Detections3D, AFittedShapeBringsItsOwnPoseSizeAndCovariance) {
  depth::ObjectFit fit;
  fit.camera_T_object.linear() = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()).toRotationMatrix();
  fit.camera_T_object.translation() = Eigen::Vector3d(0.11, -0.21, 1.6);
  fit.size_m = {0.2, 0.2, 0.3};
  fit.covariance = Eigen::Vector3d(1e-6, 2e-6, 9e-6).asDiagonal();
  const auto message = to_message({3, 0.7F, {}}, fit, base_T_optical(), some_header());
  EXPECT_EQ(message.results[0].id, 3);
  EXPECT_NEAR(message.bbox.center.position.x, 0.5 + 1.6, 1e-12);
  const auto expected = to_message(Eigen::Isometry3d(base_T_optical() * fit.camera_T_object));
  EXPECT_EQ(message.bbox.center, expected);
  EXPECT_EQ(message.results[0].pose.pose, expected);
  EXPECT_EQ(message.bbox.size.z, 0.3);
  EXPECT_NEAR(message.results[0].pose.covariance[0], 9e-6, 1e-15);
}

TEST(Detections3D, TheSurfaceIsAPointWithItsOwnCovariance) {
  const auto message = to_surface_message({3, 0.7F, {}}, some_object(), base_T_optical(), some_header());
  EXPECT_EQ(message.results[0].id, 3);
  EXPECT_FLOAT_EQ(static_cast<float>(message.results[0].score), 0.7F);
  EXPECT_EQ(message.header.frame_id, "optical");
  const auto& surface = message.results[0].pose.pose.position;
  EXPECT_NEAR(surface.x, 0.5 + 1.5, 1e-12);
  EXPECT_NEAR(surface.y, -0.1, 1e-12);
  EXPECT_NEAR(surface.z, 1.0 + 0.2, 1e-12);
  EXPECT_EQ(message.bbox.center, message.results[0].pose.pose);
  EXPECT_EQ(message.bbox.size, geometry_msgs::Vector3());
  EXPECT_NEAR(message.results[0].pose.covariance[0], 9e-5, 1e-15) << "depth lies along x now";
}

TEST(Markers, OneClearThenTwoForEachObject) {
  vision_msgs::Detection3DArray objects;
  objects.header = some_header();
  for (int id : {0, 5})
    objects.detections.push_back(
        to_message({id, 0.7F, {}}, some_object(), Eigen::Isometry3d::Identity(), some_header()));
  const auto markers = to_markers(objects, {"cup"}, 2.0).markers;
  ASSERT_EQ(markers.size(), 5U);
  EXPECT_EQ(markers[0].action, visualization_msgs::Marker::DELETEALL);
  EXPECT_EQ(markers[1].type, visualization_msgs::Marker::CUBE);
  EXPECT_EQ(markers[1].lifetime, ros::Duration(2.0));
  EXPECT_EQ(markers[1].scale.y, 0.3);
  EXPECT_LT(markers[1].color.a, 1.0F);
  EXPECT_EQ(markers[2].text, "cup 70 %\n0.11  -0.21  1.60 m") << "the centre's position";
  EXPECT_EQ(markers[4].text.rfind("class 5 70 %", 0), 0U) << markers[4].text;
  EXPECT_NE(markers[1].id, markers[3].id);
  EXPECT_TRUE(markers[1].color.r != markers[3].color.r || markers[1].color.g != markers[3].color.g ||
              markers[1].color.b != markers[3].color.b)
      << "classes differ in colour";
}

TEST(Markers, NothingClearsWhatWasThere) {
  vision_msgs::Detection3DArray objects;
  EXPECT_EQ(to_markers(objects, {}, 1.0).markers.size(), 1U);
}

TEST(ClassName, FallsBackToTheNumber) {
  EXPECT_EQ(class_name({"a", "b"}, 1), "b");
  EXPECT_EQ(class_name({"a", "b"}, 2), "class 2");
  EXPECT_EQ(class_name({"a", "b"}, -1), "class -1");
  EXPECT_EQ(class_name({}, 0), "class 0");
}

}  // namespace
}  // namespace extperfc::ros_convert
