// Where box_depth puts boxes, on scenes whose geometry is known.
#include <array>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <geometry_msgs/TransformStamped.h>
#include <ros/param.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <vision_msgs/VisionInfo.h>

#include "test/ros/box_depth_test.hpp"

namespace extperfc::ros_test {
namespace {

// The middle of kSquare, (120, 90) in edges and (119.5, 89.5) in pixel centres, seen by the camera of
// camera_info().
constexpr double kRayX = (119.5 - 159.5) / kFocalPx;
constexpr double kRayY = (89.5 - 119.5) / kFocalPx;
constexpr double kBoxM = 1.5;
constexpr double kToleranceM = 0.005;

Eigen::Vector3d vector_of(const geometry_msgs::Pose& pose) {
  return {pose.position.x, pose.position.y, pose.position.z};
}

Eigen::Matrix3d covariance_of(const geometry_msgs::PoseWithCovariance& pose) {
  const Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> all(pose.covariance.data());
  return all.topLeftCorner<3, 3>();
}

class KnownGeometryTest : public BoxDepthTest, public testing::WithParamInterface<const char*> {};

TEST_P(KnownGeometryTest, PositionExtentAndCovariance) {
  load();
  send_info(camera_info(ros::Time(1, 0)));
  const auto message = locate(ros::Time(1, 0), kBoxM, GetParam());
  ASSERT_TRUE(message) << diagnostics_.latest().message();
  EXPECT_EQ(message->header.frame_id, kFrame);
  ASSERT_EQ(message->detections.size(), 1U);
  const auto& object = message->detections.front();
  ASSERT_EQ(object.results.size(), 1U);
  EXPECT_EQ(object.results.front().id, 1);
  EXPECT_FLOAT_EQ(static_cast<float>(object.results.front().score), 0.9F);

  const Eigen::Vector3d on_surface = kBoxM * Eigen::Vector3d(kRayX, kRayY, 1.0);
  const auto surface = surface_of(*message).front();
  EXPECT_LT((vector_of(surface.pose) - on_surface).cwiseAbs().maxCoeff(), kToleranceM) << surface;
  const double height_m = 60 * kBoxM / kFocalPx;
  EXPECT_NEAR(object.bbox.size.x, 80 * kBoxM / kFocalPx, 2 * kToleranceM);
  EXPECT_NEAR(object.bbox.size.y, height_m, 2 * kToleranceM);
  const Eigen::Vector3d center = on_surface + 0.5 * height_m * on_surface.normalized();
  const auto& estimate = object.results.front().pose;
  EXPECT_LT((vector_of(object.bbox.center) - center).cwiseAbs().maxCoeff(), 2 * kToleranceM) << object.bbox;
  EXPECT_EQ(estimate.pose, object.bbox.center) << "whoever reads one of both gets the object's centre";
  EXPECT_DOUBLE_EQ(object.bbox.center.orientation.w, 1.0);

  for (const auto& pose : {estimate, surface}) {
    const Eigen::Matrix3d covariance = covariance_of(pose);
    EXPECT_TRUE(covariance.isApprox(covariance.transpose()));
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues().minCoeff(), 0.0)
        << covariance;
  }
  // The centre may lie a quarter of the extent nearer or farther: 0.08 m. The surface is measured to some mm.
  EXPECT_NEAR(std::sqrt(estimate.covariance[14]), 0.05, 0.03);
  EXPECT_LT(std::sqrt(surface.covariance[14]), 0.01);
}

INSTANTIATE_TEST_SUITE_P(All, KnownGeometryTest, testing::Values("16UC1", "32FC1"),
                         [](const auto& test) { return std::string("encoding_") + test.param; });

TEST_F(BoxDepthTest, ASizeOfItsOwnComesFromTheCamera) {
  load();
  const cv::Size size(640, 480);
  send_info(camera_info(ros::Time(1, 0), size));
  const cv::Rect box(400, 300, 60, 60);
  depth_.publish(depth_image(3.0, 2.0, box, "16UC1", ros::Time(1, 0), size));
  detections_.publish(boxes_at(ros::Time(1, 0), {box}));
  const auto message = objects_.wait_for_stamp(ros::Time(1, 0));
  ASSERT_TRUE(message);
  ASSERT_EQ(message->detections.size(), 1U);
  const auto surface = surface_of(*message).front().pose.position;
  EXPECT_NEAR(surface.x, (429.5 - 319.5) / kFocalPx * 2.0, kToleranceM);
  EXPECT_NEAR(surface.y, (329.5 - 239.5) / kFocalPx * 2.0, kToleranceM);
}

TEST_F(BoxDepthTest, MarkersBearTheClassNames) {
  ros::param::set("/some_detector/classes", std::vector<std::string>{"cup", "teapot"});
  auto vision_info = handle_.advertise<vision_msgs::VisionInfo>("vision_info", 1, true);
  vision_msgs::VisionInfo where;
  where.database_location = "/some_detector/classes";
  vision_info.publish(where);
  load();
  const Inbox<visualization_msgs::MarkerArray> markers("objects/markers");
  ASSERT_TRUE(wait_for([&] { return markers.connected() && vision_info.getNumSubscribers() > 0; }));
  send_info(camera_info(ros::Time(1, 0)));

  std::string label;
  ros::Time stamp(1, 0);
  EXPECT_TRUE(wait_for([&] {  // the names are asked for in the background
    stamp += ros::Duration(1.0);
    (void)locate(stamp, kBoxM);
    for (const auto& array : markers.all())
      for (const auto& marker : array->markers)
        if (!marker.text.empty()) label = marker.text;
    return label.rfind("teapot", 0) == 0;
  })) << label;
  const auto array = markers.all().back();
  ASSERT_EQ(array->markers.size(), 3U);
  EXPECT_EQ(array->markers[0].action, visualization_msgs::Marker::DELETEALL);
  const auto& cuboid = array->markers[1];
  EXPECT_EQ(cuboid.type, visualization_msgs::Marker::CUBE);
  EXPECT_EQ(cuboid.header.frame_id, kFrame);
  EXPECT_NEAR(cuboid.pose.position.x / cuboid.pose.position.z, kRayX, 0.01);
}

/// base_link looks along x, as REP 103 wants; the camera's optical frame stands 1 m above it.
void publish_mount(tf2_ros::StaticTransformBroadcaster& broadcaster) {
  geometry_msgs::TransformStamped mount;
  mount.header.stamp = ros::Time(1, 0);
  mount.header.frame_id = "base_link";
  mount.child_frame_id = kFrame;
  mount.transform.translation.z = 1.0;
  mount.transform.rotation.x = -0.5;
  mount.transform.rotation.y = 0.5;
  mount.transform.rotation.z = -0.5;
  mount.transform.rotation.w = 0.5;
  broadcaster.sendTransform(mount);
}

TEST_F(BoxDepthTest, ResultsComeInTheTargetFrame) {
  tf2_ros::StaticTransformBroadcaster broadcaster;
  publish_mount(broadcaster);
  load({{"target_frame", "base_link"}, {"transform_timeout_s", 5.0}});
  send_info(camera_info(ros::Time(1, 0)));
  const auto message = locate(ros::Time(1, 0), kBoxM);
  ASSERT_TRUE(message) << diagnostics_.latest().message();
  EXPECT_EQ(message->header.frame_id, "base_link");
  ASSERT_EQ(message->detections.size(), 1U);
  const auto& object = message->detections.front();
  EXPECT_EQ(object.header.frame_id, "base_link");
  const auto surface = surface_of(*message).front().pose.position;
  EXPECT_NEAR(surface.x, kBoxM, kToleranceM);
  EXPECT_NEAR(surface.y, -kRayX * kBoxM, kToleranceM);
  EXPECT_NEAR(surface.z, 1.0 - kRayY * kBoxM, kToleranceM);
  EXPECT_EQ(object.results.front().pose.pose, object.bbox.center);
  EXPECT_GT(object.bbox.center.position.x, kBoxM + 0.1) << "the centre lies behind the surface";
  // Half of the extent is a guess, and it lies along x now.
  const auto& covariance = object.results.front().pose.covariance;
  EXPECT_GT(covariance[7], 0.0);
  EXPECT_GT(covariance[14], 0.0);
  EXPECT_GT(covariance[0], covariance[7]);
  EXPECT_GT(covariance[0], covariance[14]);
}

/// A cube on a table under a camera that looks straight down from 1 m above the table.
TEST_F(BoxDepthTest, AFittedCubesCentreIsInBothPlacesAndItsTopOnTheOtherTopic) {
  constexpr double kEdgeM = 0.16;
  constexpr double kTopM = 1.0 - kEdgeM;
  constexpr int kEdgePx = 57;  // kEdgeM at kTopM
  const cv::Rect top(kSize.width / 2 - kEdgePx / 2, kSize.height / 2 - kEdgePx / 2, kEdgePx, kEdgePx);
  tf2_ros::StaticTransformBroadcaster broadcaster;
  geometry_msgs::TransformStamped above;
  above.header.stamp = ros::Time(1, 0);
  above.header.frame_id = "table";
  above.child_frame_id = kFrame;
  above.transform.translation.z = 1.0;
  above.transform.rotation.x = 1.0;
  broadcaster.sendTransform(above);
  ros::param::set("/some_detector/classes", std::vector<std::string>{"cone", "dice"});
  auto vision_info = handle_.advertise<vision_msgs::VisionInfo>("vision_info", 1, true);
  vision_msgs::VisionInfo where;
  where.database_location = "/some_detector/classes";
  vision_info.publish(where);
  XmlRpc::XmlRpcValue shapes;
  shapes["dice"] = std::string("cube");
  load({{"target_frame", "table"}, {"transform_timeout_s", 5.0}, {"fit_objects", true}, {"shapes", shapes}});
  send_info(camera_info(ros::Time(1, 0)));

  ros::Time stamp(1, 0);
  vision_msgs::Detection3DArrayConstPtr message;
  EXPECT_TRUE(wait_for([&] {  // the names are asked for in the background
    stamp += ros::Duration(1.0);
    depth_.publish(depth_image(1.0, kTopM, top, "16UC1", stamp));
    detections_.publish(boxes_at(stamp, {top}));
    message = objects_.wait_for_stamp(stamp);
    return message && message->detections.size() == 1U &&
           std::abs(message->detections.front().bbox.size.z - kEdgeM) < kToleranceM;
  })) << diagnostics_.latest().message()
      << (message ? message->detections.front().bbox.size.z : 0.0);
  const auto& cube = message->detections.front();
  EXPECT_NEAR(cube.bbox.center.position.z, 0.5 * kEdgeM, kToleranceM);
  EXPECT_EQ(cube.results.front().pose.pose, cube.bbox.center);
  const double sigma_m = std::sqrt(cube.results.front().pose.covariance[14]);
  EXPECT_GT(sigma_m, 0.0);
  EXPECT_LT(sigma_m, 0.01) << "the shape knows its extent: the box's guess of it no longer counts";
  EXPECT_NEAR(surface_of(*message).front().pose.position.z, kEdgeM, kToleranceM);
}

TEST_F(BoxDepthTest, TheSurfaceAloneIsComputedToo) {
  const Inbox<vision_msgs::Detection3DArray> surface("/alone/detections_3d/surface");
  const auto detections = handle_.advertise<vision_msgs::Detection2DArray>("/alone/detections", 10);
  ASSERT_TRUE(manager_.load("/alone/box_depth", "box_depth", {})) << log_.text();
  EXPECT_TRUE(wait_for([&] { return detections.getNumSubscribers() > 0; }));
}

TEST_F(BoxDepthTest, BoxesWithoutDepthAreLeftOutAndCounted) {
  load();
  send_info(camera_info(ros::Time(1, 0)));
  const cv::Rect hole(200, 150, 60, 60);
  auto depth = depth_image(3.0, kBoxM, kSquare, "32FC1", ros::Time(1, 0));
  cv::Mat1f pixels(kSize.height, kSize.width, reinterpret_cast<float*>(depth->data.data()));
  pixels(hole).setTo(std::numeric_limits<float>::quiet_NaN());
  depth_.publish(depth);
  const cv::Rect outside(1000, 1000, 20, 20);
  detections_.publish(boxes_at(ros::Time(1, 0), {hole, kSquare, outside}));
  const auto message = objects_.wait_for_stamp(ros::Time(1, 0));
  ASSERT_TRUE(message);
  ASSERT_EQ(message->detections.size(), 1U);
  EXPECT_NEAR(surface_of(*message).front().pose.position.z, kBoxM, kToleranceM);
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.number("boxes without depth") == 2; }));
  EXPECT_EQ(diagnostics_.latest().level(), 0) << "a box without depth is no fault";
}

TEST_F(BoxDepthTest, NoBoxesGiveAnEmptyResult) {
  load();
  send_info(camera_info(ros::Time(1, 0)));
  depth_.publish(depth_image(3.0, kBoxM, kSquare, "16UC1", ros::Time(1, 0)));
  detections_.publish(boxes_at(ros::Time(1, 0), {}));
  const auto message = objects_.wait_for_stamp(ros::Time(1, 0));
  ASSERT_TRUE(message);
  EXPECT_TRUE(message->detections.empty());
}

TEST_F(BoxDepthTest, SlowDetectionsFindTheirOwnImage) {
  load();
  send_info(camera_info(ros::Time(1, 0)));
  constexpr int kImages = 10;
  for (int i = 1; i <= kImages; ++i) {  // image i sees its box i * 0.2 m away
    depth_.publish(depth_image(3.0, 0.2 * i, kSquare, "16UC1", ros::Time(i, 0)));
    ASSERT_TRUE(diagnostics_.wait([i](const Report& r) { return r.number("depth received") == i; }));
  }
  detections_.publish(boxes_at(ros::Time(4, 0), {kSquare}));
  const auto message = objects_.wait_for_stamp(ros::Time(4, 0));
  ASSERT_TRUE(message);
  ASSERT_EQ(message->detections.size(), 1U);
  EXPECT_NEAR(surface_of(*message).front().pose.position.z, 0.8, kToleranceM);
}

}  // namespace
}  // namespace extperfc::ros_test
