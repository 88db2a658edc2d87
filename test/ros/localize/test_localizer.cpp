// Does it find the robot, and say so as amcl does?
#include <cmath>

#include <std_srvs/Empty.h>

#include "ros/convert/planar_pose.hpp"
#include "test/ros/localize/localizer_test.hpp"

namespace extperfc::ros_test {
namespace {

bool call(const std::string& service) {
  std_srvs::Empty empty;
  return ros::service::waitForService(service, 20000) && ros::service::call(service, empty);
}

double spread_m(const geometry_msgs::PoseArray& cloud) {
  double min_x = 1e9;
  double max_x = -1e9;
  for (const auto& pose : cloud.poses) {
    min_x = std::min(min_x, pose.position.x);
    max_x = std::max(max_x, pose.position.x);
  }
  return max_x - min_x;
}

TEST_F(LocalizerTest, CorrectsAnInitialPoseThatIsALittleOff) {
  load({{"initial_pose_x", -0.3}, {"initial_pose_y", 0.2}, {"initial_pose_a", 0.1}});
  const auto pose = drive_around();
  ASSERT_TRUE(pose) << diagnostics_.latest().message();
  expect_near(*pose);
}

TEST_F(LocalizerTest, ThePoseOfAmclPoseIsThatOfTheTransform) {
  load();
  ASSERT_TRUE(drive(0.8, 0, 4));
  const auto pose = drive(0, 0.9, 3);
  ASSERT_TRUE(pose);
  ASSERT_TRUE(wait_for([&] { return poses_.count() > 0 && poses_.all().back()->header.stamp == now_; }));
  const auto& message = *poses_.all().back();
  EXPECT_EQ(message.header.frame_id, "map");
  const auto said = ros_convert::to_pose2(message.pose.pose);
  EXPECT_LT(distance_m(*said, *pose), 1e-6);
  EXPECT_LT(yaw_difference_rad(*said, *pose), 1e-6);
  const auto covariance = ros_convert::to_covariance(message.pose.covariance);
  EXPECT_GT(covariance.diagonal().minCoeff(), 0);
  EXPECT_LT(std::sqrt(covariance.diagonal().maxCoeff()), 0.3);
  EXPECT_EQ(message.pose.covariance[14], 0) << "z has no variance";
}

TEST_F(LocalizerTest, TheTransformIsDatedAheadOfTheScan) {
  load();
  ASSERT_TRUE(locate());
  const auto transform = transforms().back();
  EXPECT_NEAR((transform.header.stamp - now_).toSec(), 0.25, 1e-6);
}

TEST_F(LocalizerTest, StandingItGoesOnPublishingTheTransformOnly) {
  load();
  ASSERT_TRUE(drive(0.8, 0, 4));
  ASSERT_TRUE(locate());
  const auto poses = poses_.count();
  const auto before = transforms();
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(locate());
  const auto after = transforms();
  EXPECT_EQ(after.size(), before.size() + 10);
  EXPECT_EQ(poses_.count(), poses) << "no update without motion";
  EXPECT_EQ(after.back().transform.translation.x, before.back().transform.translation.x);
  EXPECT_NEAR((after.back().header.stamp - before.back().header.stamp).toSec(), 1.0, 1e-6);
}

TEST_F(LocalizerTest, StandingItUpdatesNowAndThenIfWanted) {
  load({{"idle_update_period_s", 0.5}});
  ASSERT_TRUE(locate());
  ASSERT_TRUE(poses_.wait_for_count(1));
  const auto poses = poses_.count();
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(locate());
  EXPECT_TRUE(wait_for([&] { return poses_.count() == poses + 4; })) << poses_.count() - poses;
}

TEST_F(LocalizerTest, ARequestUpdatesWithoutMotion) {
  load();
  ASSERT_TRUE(locate());
  ASSERT_TRUE(poses_.wait_for_count(1));
  const auto poses = poses_.count();
  ASSERT_TRUE(call("request_nomotion_update"));
  ASSERT_TRUE(locate());
  EXPECT_TRUE(poses_.wait_for_count(poses + 1));
  ASSERT_TRUE(locate());
  EXPECT_EQ(poses_.count(), poses + 1) << "one request, one update";
}

TEST_F(LocalizerTest, InitialposeMovesIt) {
  map_T_base_ = {-2.5, -1, 1.2};
  load();
  ASSERT_TRUE(locate());
  give_pose({-2.4, -1.1, 1.1});
  ASSERT_TRUE(tick_until([&] {
    return poses_.count() > 1 &&
           distance_m(*ros_convert::to_pose2(poses_.all().back()->pose.pose), map_T_base_) < 0.5;
  }));
  const auto pose = drive_around();
  ASSERT_TRUE(pose);
  expect_near(*pose);
}

TEST_F(LocalizerTest, InitialposeOfAWhileAgoIsCarriedOn) {
  load({{"update_min_d", 100.0}, {"update_min_a", 100.0}});
  ASSERT_TRUE(locate());
  const auto then = now_;
  const auto pose_then = map_T_base_;
  ASSERT_TRUE(drive(1.0, 0.5, 5));
  const auto poses = poses_.count();
  give_pose(pose_then, 1e-3, 1e-3, "map", then);
  ASSERT_TRUE(tick_until([&] { return poses_.count() > poses; }));
  expect_near(*ros_convert::to_pose2(poses_.all().back()->pose.pose), 0.05, 0.05);
}

TEST_F(LocalizerTest, InitialposeInAnotherFrameIsIgnored) {
  load();
  ASSERT_TRUE(locate());
  ASSERT_TRUE(poses_.wait_for_count(1));
  const auto poses = poses_.count();
  give_pose({2, 2, 0}, 0.1, 0.1, "odom");
  ASSERT_TRUE(log_.wait("ignoring initial pose: its frame is odom, must be map"));
  give_pose({std::nan(""), 2, 0});
  ASSERT_TRUE(log_.wait("ignoring initial pose: the pose has values that are not finite"));
  ASSERT_TRUE(locate());
  EXPECT_EQ(poses_.count(), poses);
}

TEST_F(LocalizerTest, GlobalLocalizationFindsItAnywhere) {
  map_T_base_ = {-2.6, -0.2, -0.6};
  load(
      {{"initial_pose_x", 2.0}, {"initial_pose_y", -1.0}, {"max_particles", 3000}, {"laser_sigma_hit", 0.2}});
  Inbox<geometry_msgs::PoseArray> clouds("particlecloud");
  ASSERT_TRUE(wait_for([&] { return clouds.connected(); }));
  ASSERT_TRUE(tick_until([&] { return clouds.count() > 0; }));
  EXPECT_LT(spread_m(*clouds.all().back()), 2.5);
  ASSERT_TRUE(call("global_localization"));
  ASSERT_TRUE(tick_until([&] { return spread_m(*clouds.all().back()) > 5.0; })) << "all over the room";
  std::optional<Pose2> pose;
  for (int round = 0; round < 3; ++round) pose = drive_around();
  ASSERT_TRUE(pose);
  expect_near(*pose, 0.15, 0.1);
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.value("lost") == "no"; }));
}

TEST_F(LocalizerTest, TheCloudIsMadeForListenersOnly) {
  load();
  ASSERT_TRUE(drive(0.8, 0, 4));
  Inbox<geometry_msgs::PoseArray> clouds("particlecloud");
  ASSERT_TRUE(wait_for([&] { return clouds.connected(); }));
  EXPECT_EQ(clouds.count(), 0U) << "no cloud without subscribers";
  ASSERT_TRUE(tick_until([&] { return clouds.count() == 1; })) << "a new listener needs not wait for motion";
  const auto cloud = clouds.all().front();
  EXPECT_EQ(cloud->header.frame_id, "map");
  EXPECT_GE(cloud->poses.size(), 100U);
  for (const auto& pose : cloud->poses) {
    const auto planar = ros_convert::to_pose2(pose);
    ASSERT_TRUE(planar);
    EXPECT_LT(distance_m(*planar, map_T_base_), 2.0);
  }
}

TEST_F(LocalizerTest, CloudsComeNoMoreOftenThanWanted) {
  load({{"gui_publish_rate", 1.0}, {"update_min_d", 0.05}});
  Inbox<geometry_msgs::PoseArray> clouds("particlecloud");
  ASSERT_TRUE(wait_for([&] { return clouds.connected(); }));
  ASSERT_TRUE(tick_until([&] { return clouds.count() > 0; }));
  const auto clouds_before = clouds.count();
  const auto poses_before = poses_.count();
  ASSERT_TRUE(drive(1.0, 0, 10));
  ASSERT_TRUE(drive(0, 6.0, 20));
  ASSERT_TRUE(wait_for([&] { return clouds.count() >= clouds_before + 2; }));
  EXPECT_GT(poses_.count() - poses_before, 15U);
  EXPECT_LE(clouds.count() - clouds_before, 4U) << "3 s of simulated time";
}

TEST_F(LocalizerTest, TheLastPoseWaitsForANewListener) {
  load();
  ASSERT_TRUE(locate());
  ASSERT_TRUE(poses_.wait_for_count(1));
  const Inbox<geometry_msgs::PoseWithCovarianceStamped> late("amcl_pose");
  EXPECT_TRUE(late.wait_for_count(1));
}

TEST_F(LocalizerTest, NoTransformIfNotWanted) {
  load({{"tf_broadcast", false}});
  ASSERT_TRUE(tick_until([&] { return poses_.count() > 0; }));
  EXPECT_TRUE(transforms().empty());
}

TEST_F(LocalizerTest, TwoScannersOnOneTopicOneOfThemUpsideDown) {
  load();
  publish_mount("rear", {-0.3, 0.1, 2.0}, true);
  const auto drive_and_look = [&](const Pose2& step) {
    map_T_base_ = compose(map_T_base_, step);
    if (!locate()) return std::optional<Pose2>();
    const auto before = transforms().size();
    // Mirrored rays: what stands left of an upright scanner stands right of this one.
    auto scan = cast(seen_, compose(map_T_base_, {-0.3, 0.1, 2.0}), "rear", now_ + ros::Duration(0.02));
    std::reverse(scan.ranges.begin() + 1, scan.ranges.end());
    now_ += ros::Duration(0.02);
    broadcast_odometry();
    scan_.publish(scan);
    if (!wait_for([&] { return transforms().size() > before; })) return std::optional<Pose2>();
    return std::optional<Pose2>(compose(ros_convert::to_pose2(transforms().back().transform).value(),
                                        compose(inverse(map_T_odom_), map_T_base_)));
  };
  std::optional<Pose2> pose;
  for (int i = 0; i < 24; ++i) {
    pose = drive_and_look({0.1, 0, 0.25});
    ASSERT_TRUE(pose) << diagnostics_.latest().message();
  }
  expect_near(*pose);
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.value("lost") == "no"; }));
}

}  // namespace
}  // namespace extperfc::ros_test
