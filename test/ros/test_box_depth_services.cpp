// Detection with positions on request, clouds of single objects, and parameters that change at run time.
#include <atomic>
#include <thread>

#include <extperfc/DetectOnce.h>
#include <extperfc/ObjectCloud.h>
#include <ros/service.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include "test/ros/box_depth_test.hpp"
#include "test/ros/support/reconfigure_client.hpp"

namespace extperfc::ros_test {
namespace {

constexpr double kBoxM = 1.5;
constexpr double kWallM = 3.0;
const ReconfigureClient kBoxDepth("/box_depth");

/// A detector and box_depth that are both disabled; the test plays the camera.
class DetectOnceTest : public testing::Test {
 protected:
  void load(bool with_detector = true) {
    Params detector = detector_params();
    detector["enabled"] = false;
    if (with_detector) {
      ASSERT_TRUE(manager_.load("/detector", "detector", detector)) << log_.text();
    }
    ASSERT_TRUE(manager_.load("/box_depth", "box_depth", {{"enabled", false}})) << log_.text();
  }

  [[nodiscard]] DetectOnce::Response call(const DetectOnce::Request& request) const {
    DetectOnce call;
    call.request = request;
    EXPECT_TRUE(ros::service::call("/detect_once", call));
    return call.response;
  }

  /// The answer to a request for the camera's next image, while the camera runs.
  [[nodiscard]] DetectOnce::Response call_with_camera(const DetectOnce::Request& request, bool with_depth) {
    DetectOnce::Response response;
    std::atomic<bool> done{false};
    std::thread caller([&] {
      response = call(request);
      done = true;
    });
    std::uint32_t second = 0;
    EXPECT_TRUE(wait_for([&] {
      const ros::Time stamp(++second, 0);
      if (with_depth) depth_.publish(depth_image(kWallM, kBoxM, kSquare, "16UC1", stamp));
      if (with_depth) info_.publish(camera_info(stamp));
      images_.publish(to_image(draw_square(kGreen), "rgb8", stamp));
      return done.load();
    }));
    caller.join();
    return response;
  }

  ros::NodeHandle handle_;
  ros::Publisher images_{handle_.advertise<sensor_msgs::Image>("camera/color/image_raw", 10)};
  ros::Publisher depth_{handle_.advertise<sensor_msgs::Image>(kDepthTopic, 10)};
  ros::Publisher info_{handle_.advertise<sensor_msgs::CameraInfo>(kInfoTopic, 10)};
  LogWatch log_;
  Manager manager_;
};

TEST_F(DetectOnceTest, TheNextImageOfTheCameraWithItsDepth) {
  load();
  const auto response = call_with_camera({}, true);
  ASSERT_TRUE(response.success) << response.message;
  ASSERT_TRUE(response.has_3d) << response.message;
  EXPECT_EQ(response.message, "");
  ASSERT_EQ(response.detections.detections.size(), 1U);
  ASSERT_EQ(response.detections_3d.detections.size(), 1U);
  EXPECT_EQ(response.detections_3d.header.stamp, response.detections.header.stamp);
  const auto& object = response.detections_3d.detections.front();
  EXPECT_EQ(object.results.front().id, kClassGreen);
  EXPECT_NEAR(object.bbox.center.position.z, kBoxM + 0.15, 0.02);
  EXPECT_TRUE(wait_for([this] {
    return depth_.getNumSubscribers() == 0 && info_.getNumSubscribers() == 0 &&
           images_.getNumSubscribers() == 0;
  })) << "nothing is subscribed to afterwards";

  ObjectCloud cloud;
  ASSERT_TRUE(ros::service::call("/object_cloud", cloud));
  EXPECT_TRUE(cloud.response.success) << "objects of a request are known, too: " << cloud.response.message;
}

TEST_F(DetectOnceTest, ACameraWithoutDepthGivesBoxesAlone) {
  load();
  DetectOnce::Request request;
  request.timeout = ros::Duration(1.0);
  const auto response = call_with_camera(request, false);
  ASSERT_TRUE(response.success) << response.message;
  EXPECT_EQ(response.detections.detections.size(), 1U);
  EXPECT_FALSE(response.has_3d);
  EXPECT_EQ(response.message, "no 3D result: no depth image, or no camera info, came in time");
}

TEST_F(DetectOnceTest, EverythingFromTheRequest) {
  load();
  DetectOnce::Request request;
  request.image = *to_image(draw_square(kBlue), "rgb8", ros::Time(5, 0));
  const auto flat = call(request);
  EXPECT_TRUE(flat.success) << flat.message;
  EXPECT_FALSE(flat.has_3d);
  EXPECT_EQ(flat.message, "no 3D result: the request has an image, but no depth");
  request.depth = *depth_image(kWallM, kBoxM, kSquare, "32FC1", ros::Time(5, 0));
  const auto no_info = call(request);
  EXPECT_TRUE(no_info.success);
  EXPECT_FALSE(no_info.has_3d);
  EXPECT_NE(no_info.message.find("no camera info"), std::string::npos) << no_info.message;
  request.camera_info = *camera_info(ros::Time(5, 0));
  const auto full = call(request);
  ASSERT_TRUE(full.has_3d) << full.message;
  EXPECT_EQ(full.detections_3d.detections.size(), 1U);
  EXPECT_EQ(full.detections_3d.header.stamp, ros::Time(5, 0));
}

TEST_F(DetectOnceTest, WithoutADetectorTheAnswerSaysSo) {
  load(false);
  DetectOnce::Request request;
  request.image = *to_image(draw_square(kBlue), "rgb8", ros::Time(5, 0));
  const auto response = call(request);
  EXPECT_FALSE(response.success);
  EXPECT_NE(response.message.find("is the detector running?"), std::string::npos) << response.message;
}

ObjectCloud::Response cloud_of(const ros::Time& stamp, std::uint32_t index) {
  ObjectCloud call;
  call.request.stamp = stamp;
  call.request.index = index;
  EXPECT_TRUE(ros::service::call("/object_cloud", call));
  return call.response;
}

TEST_F(BoxDepthTest, ACloudHoldsOneObjectWithoutTheWall) {
  load();
  EXPECT_NE(cloud_of({}, 0).message.find("no objects were located yet"), std::string::npos);
  send_info(camera_info(ros::Time(1, 0)));
  const cv::Rect wide(kSquare.x - 10, kSquare.y - 10, kSquare.width + 20, kSquare.height + 20);
  depth_.publish(depth_image(kWallM, kBoxM, kSquare, "16UC1", ros::Time(1, 0)));
  detections_.publish(boxes_at(ros::Time(1, 0), {wide}));
  ASSERT_TRUE(objects_.wait_for_stamp(ros::Time(1, 0)));

  for (const auto& stamp : {ros::Time(1, 0), ros::Time()}) {
    const auto response = cloud_of(stamp, 0);
    ASSERT_TRUE(response.success) << response.message;
    EXPECT_EQ(response.cloud.header.stamp, ros::Time(1, 0));
    EXPECT_EQ(response.cloud.header.frame_id, kFrame);
    ASSERT_EQ(response.cloud.width, static_cast<std::uint32_t>(kSquare.area()));
    for (sensor_msgs::PointCloud2ConstIterator<float> z(response.cloud, "z"); z != z.end(); ++z)
      ASSERT_NEAR(*z, kBoxM, 1e-3);
  }
  const auto no_object = cloud_of({}, 1);
  EXPECT_FALSE(no_object.success);
  EXPECT_EQ(no_object.message, "no object 1 in detections_3d: it has 1");
  EXPECT_NE(cloud_of(ros::Time(9, 0), 0).message.find("raise cloud_history"), std::string::npos);
}

TEST_F(BoxDepthTest, ADisabledBoxDepthTakesNoInputs) {
  load();
  kBoxDepth.set("enabled", false);
  EXPECT_TRUE(wait_for([this] {
    return detections_.getNumSubscribers() == 0 && depth_.getNumSubscribers() == 0 &&
           info_.getNumSubscribers() == 0;
  }));
  EXPECT_TRUE(diagnostics_.wait_latest(
      [](const Report& r) { return r.message() == "disabled: parameter enabled is false"; }));
  kBoxDepth.set("enabled", true);
  ASSERT_TRUE(wait_for([this] {
    return detections_.getNumSubscribers() > 0 && depth_.getNumSubscribers() > 0 &&
           info_.getNumSubscribers() > 0;
  }));
  send_info(camera_info(ros::Time(1, 0)));
  EXPECT_TRUE(locate(ros::Time(1, 0), kBoxM));
}

TEST_F(BoxDepthTest, ScoresClassesAndEstimatorsChangeAtRunTime) {
  load();
  send_info(camera_info(ros::Time(1, 0)));
  const auto located = [this](std::uint32_t second) {
    const auto message = locate(ros::Time(second, 0), kBoxM);
    return message ? message->detections.size() : 99U;
  };
  EXPECT_EQ(located(2), 1U);
  kBoxDepth.set("min_score", 0.95);
  EXPECT_EQ(located(3), 0U);
  kBoxDepth.set("min_score", 0.5);
  kBoxDepth.set("class_filter", "0, 2");
  EXPECT_EQ(located(4), 0U) << "the test's boxes are of class 1";
  kBoxDepth.set("class_filter", "");
  EXPECT_EQ(value_of(kBoxDepth.set("estimator", "median").strs, "estimator"), "median");
  EXPECT_EQ(located(5), 1U);
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.value("estimator") == "median"; }));

  EXPECT_EQ(value_of(kBoxDepth.set("estimator", "best").strs, "estimator"), "median");
  EXPECT_TRUE(log_.wait("unknown depth estimator 'best'")) << log_.text();
  EXPECT_EQ(value_of(kBoxDepth.set("max_depth_m", 0.01).doubles, "max_depth_m"), 10.0);
  EXPECT_TRUE(diagnostics_.wait_latest(
      [](const Report& r) { return r.is_warning_about("max_depth_m must be finite and above"); }));
}

}  // namespace
}  // namespace extperfc::ros_test
