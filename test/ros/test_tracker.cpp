// The tracker as a nodelet: ids, filtered positions, frames, and what it says when a transform is missing.
#include <extperfc/TrackArray.h>
#include <geometry_msgs/TransformStamped.h>
#include <gtest/gtest.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <vision_msgs/Detection3DArray.h>

#include "test/ros/support/inbox.hpp"
#include "test/ros/support/manager.hpp"
#include "test/ros/support/watch.hpp"

namespace extperfc::ros_test {
namespace {

constexpr const char* kCamera = "camera_color_optical_frame";

struct Object {
  std::int64_t class_id;
  double x, y, z;
};

class TrackerTest : public testing::Test {
 protected:
  void load(const Params& params = {}) {
    ASSERT_TRUE(manager_.load("/tracker", "tracker", params)) << log_.text();
    ASSERT_TRUE(wait_for([this] { return detections_.getNumSubscribers() > 0 && tracks_.connected(); }));
  }

  void publish(const ros::Time& stamp, const std::vector<Object>& objects) const {
    auto message = boost::make_shared<vision_msgs::Detection3DArray>();
    message->header.stamp = stamp;
    message->header.frame_id = kCamera;
    for (const auto& object : objects) {
      vision_msgs::Detection3D detection;
      detection.header = message->header;
      detection.results.resize(1);
      auto& result = detection.results.front();
      result.id = object.class_id;
      result.score = 0.8;
      result.pose.pose.position.x = object.x;
      result.pose.pose.position.y = object.y;
      result.pose.pose.position.z = object.z;
      result.pose.pose.orientation.w = 1.0;
      result.pose.covariance[0] = result.pose.covariance[7] = result.pose.covariance[14] = 1e-4;
      detection.bbox.center = result.pose.pose;
      detection.bbox.size.x = detection.bbox.size.y = detection.bbox.size.z = 0.1;
      message->detections.push_back(detection);
    }
    detections_.publish(message);
  }

  /// The tracks of an image; null when there is no answer.
  [[nodiscard]] TrackArrayConstPtr answer_to(double stamp_s, const std::vector<Object>& objects) const {
    publish(ros::Time(stamp_s), objects);
    return tracks_.wait_for_stamp(ros::Time(stamp_s));
  }

  ros::Publisher detections_{ros::NodeHandle().advertise<vision_msgs::Detection3DArray>("detections_3d", 10)};
  Inbox<TrackArray> tracks_{"objects/tracks"};
  DiagnosticsWatch diagnostics_{"tracker"};
  LogWatch log_;
  Manager manager_;
};

TEST_F(TrackerTest, ConfirmedObjectsHaveIdsPositionsAndVelocities) {
  load();
  TrackArrayConstPtr tracks;
  for (int i = 0; i < 12; ++i) {
    tracks = answer_to(10 + 0.1 * i, {{2, 0.02 * i, 0.0, 1.0}, {1, 0.5, 0.1, 1.2}});
    ASSERT_TRUE(tracks);
    EXPECT_EQ(tracks->tracks.size(), i < 2 ? 0U : 2U) << "confirmed after three images";
  }
  EXPECT_EQ(tracks->header.frame_id, kCamera);
  const auto& moving = tracks->tracks[0];
  EXPECT_EQ(moving.id, 1U);
  EXPECT_EQ(moving.class_id, 2);
  EXPECT_EQ(moving.detection, 0);
  EXPECT_TRUE(moving.confirmed);
  EXPECT_EQ(moving.hits, 12U);
  EXPECT_NEAR(moving.pose.pose.position.x, 0.22, 0.02);
  EXPECT_NEAR(moving.velocity.x, 0.2, 0.1);
  EXPECT_NEAR(moving.size.z, 0.1, 1e-9);
  EXPECT_EQ(moving.first_seen, ros::Time(10.0));
  const auto& still = tracks->tracks[1];
  EXPECT_EQ(still.id, 2U);
  EXPECT_NEAR(still.velocity.x, 0.0, 0.05);
  EXPECT_LT(still.pose.covariance[0], 1e-4) << "the filter knows more than one measurement";

  const auto missed = answer_to(11.2, {});
  ASSERT_TRUE(missed);
  ASSERT_EQ(missed->tracks.size(), 2U);
  EXPECT_EQ(missed->tracks[0].detection, -1);
  EXPECT_EQ(missed->tracks[0].last_seen, ros::Time(11.1));
  EXPECT_NEAR(missed->tracks[0].size.z, 0.1, 1e-9);
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.number("objects") == 2; }));
}

TEST_F(TrackerTest, TentativeObjectsOnRequest) {
  load({{"publish_tentative", true}});
  const auto tracks = answer_to(10, {{2, 0, 0, 1}});
  ASSERT_TRUE(tracks);
  ASSERT_EQ(tracks->tracks.size(), 1U);
  EXPECT_FALSE(tracks->tracks[0].confirmed);
}

TEST_F(TrackerTest, TracksStandStillInTheFixedFrameWhileTheCameraMoves) {
  load({{"fixed_frame", "odom"}, {"transform_timeout_s", 5.0}, {"confirm_hits", 1}});
  tf2_ros::StaticTransformBroadcaster broadcaster;
  geometry_msgs::TransformStamped mount;
  mount.header.frame_id = "odom";
  mount.child_frame_id = kCamera;
  mount.transform.translation.x = 2.0;
  mount.transform.rotation.z = 1.0;  // half a revolution about z
  broadcaster.sendTransform(mount);
  const auto tracks = answer_to(10, {{0, 0.3, 0.1, 1.0}});
  ASSERT_TRUE(tracks) << log_.text();
  EXPECT_EQ(tracks->header.frame_id, "odom");
  ASSERT_EQ(tracks->tracks.size(), 1U);
  EXPECT_NEAR(tracks->tracks[0].pose.pose.position.x, 1.7, 1e-6);
  EXPECT_NEAR(tracks->tracks[0].pose.pose.position.y, -0.1, 1e-6);
  EXPECT_NEAR(std::abs(tracks->tracks[0].pose.pose.orientation.z), 1.0, 1e-6);
}

TEST_F(TrackerTest, AMissingTransformIsAnError) {
  load({{"fixed_frame", "nowhere"}, {"transform_timeout_s", 0.0}});
  publish(ros::Time(10), {{0, 0, 0, 1}});
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) {
    return r.is_error_about("no transform from camera_color_optical_frame to nowhere");
  }));
}

TEST_F(TrackerTest, ABagThatBeginsAgainRestartsTheTracks) {
  load({{"confirm_hits", 1}});
  ASSERT_TRUE(answer_to(100, {{0, 0, 0, 1}}));
  const auto again = answer_to(10, {{0, 0, 0, 1}});
  ASSERT_TRUE(again);
  ASSERT_EQ(again->tracks.size(), 1U);
  EXPECT_EQ(again->tracks[0].id, 2U);
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.number("restarts") == 1; }));
}

TEST_F(TrackerTest, WrongParametersAreRefused) {
  EXPECT_FALSE(manager_.load("/tracker", "tracker", {{"gate", -1.0}, {"gates", 1}}));
  EXPECT_TRUE(log_.wait("/tracker/gates is not a parameter")) << log_.text();
}

}  // namespace
}  // namespace extperfc::ros_test
