// Obstacles that only a cloud shows, and arms that stick out.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <extperfc/TrackArray.h>
#include <geometry_msgs/PolygonStamped.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <visualization_msgs/MarkerArray.h>

#include "test/ros/navigate/navigator_test.hpp"

namespace extperfc::ros_test {
namespace {

using State = actionlib::SimpleClientGoalState;

/// Publishes again and again while something else is waited for.
template <typename Publish>
bool wait_while(const Publish& publish, const std::function<bool()>& condition, double patience_s) {
  return wait_for(
      [&] {
        publish();
        return condition();
      },
      patience_s);
}

/// A box of 0.3 x 0.6 m at (-0.45, 0) in the map, from `low_m` to `high_m`, too low or too high for the
/// scanner.
sensor_msgs::PointCloud2 box_cloud(float low_m, float high_m, const ros::Time& stamp) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header.frame_id = "map";
  cloud.header.stamp = stamp;
  sensor_msgs::PointCloud2Modifier modifier(cloud);
  modifier.setPointCloud2FieldsByString(1, "xyz");
  constexpr int kAcross = 31;
  constexpr int kLevels = 4;
  modifier.resize(kAcross * kLevels + 1);
  sensor_msgs::PointCloud2Iterator<float> x(cloud, "x");
  sensor_msgs::PointCloud2Iterator<float> y(cloud, "y");
  sensor_msgs::PointCloud2Iterator<float> z(cloud, "z");
  for (int i = 0; i < kAcross * kLevels; ++i, ++x, ++y, ++z) {
    *x = -0.6F;
    *y = -0.3F + 0.02F * static_cast<float>(i % kAcross);
    *z = low_m + (high_m - low_m) * static_cast<float>(i / kAcross) / (kLevels - 1);
  }
  *x = *y = *z = std::numeric_limits<float>::quiet_NaN();  // as depth cameras give them
  return cloud;
}

class NavigatorClouds : public NavigatorTest {
 protected:
  /// Drives across the box; the greatest distance from the straight line on the way.
  double detour_m(float low_m, float high_m) {
    load();
    client_.sendGoal(goal(0.4, 0));
    double greatest_m = 0;
    const bool ended = wait_while(
        [&] {
          publisher_.publish(box_cloud(low_m, high_m, robot_.now()));
          if (robot_.pose().x < -0.2) greatest_m = std::max(greatest_m, std::abs(robot_.pose().y));
        },
        [&] { return client_.getState().isDone(); }, 40);
    EXPECT_TRUE(ended) << log_.text();
    EXPECT_EQ(client_.getState(), State::SUCCEEDED) << text();
    return greatest_m;
  }

  ros::Publisher publisher_{handle_.advertise<sensor_msgs::PointCloud2>("obstacle_points", 1)};
};

TEST_F(NavigatorClouds, AnObstacleThatTheScannerDoesNotSeeIsDrivenAround) {
  EXPECT_GT(detour_m(0.2F, 0.5F), 0.5) << "half of the box and half of the base are 0.55 m";
}

TEST_F(NavigatorClouds, FloorAndCeilingAreNoObstacles) {
  EXPECT_LT(detour_m(0.0F, 0.05F), 0.2);
}

TEST_F(NavigatorClouds, ACloudWithoutPointsIsReportedAndHarmsNothing) {
  load();
  sensor_msgs::PointCloud2 cloud;
  cloud.header.frame_id = "map";
  cloud.header.stamp = robot_.now();
  cloud.width = cloud.height = 1;
  publisher_.publish(cloud);
  EXPECT_TRUE(log_.wait("/obstacle_points: the cloud has no field 'x'"));
  client_.sendGoal(goal(0.4, 0));
  ASSERT_TRUE(wait_for_end()) << log_.text();
  EXPECT_EQ(client_.getState(), State::SUCCEEDED) << text();
}

class NavigatorTable : public NavigatorTest {
 protected:
  static constexpr double kLowX = -0.5, kHighX = -0.4, kHalfY = 0.35;

  NavigatorTable() {
    OccupancyGrid table = hall();
    std::fill(table.cells.begin(), table.cells.end(), OccupancyGrid::kFree);
    fill(table, {kLowX, -kHalfY, 0}, {kHighX, kHalfY, 0});
    robot_.set_table(table);
    fill(map_, {kLowX, -kHalfY + 0.1, 0}, {kHighX, kHalfY - 0.1, 0});  // smaller than it is
  }

  /// Drives across the table; how near its middle came to the table's edges, 0 under it [m].
  double nearest_m(const Params& more) {
    load(more);
    client_.sendGoal(goal(0.5, 0));
    double nearest_m = 10;
    const bool ended = wait_for(
        [&] {
          const Pose2 here = robot_.pose();
          nearest_m = std::min(nearest_m, std::hypot(std::max({kLowX - here.x, 0.0, here.x - kHighX}),
                                                     std::max(std::abs(here.y) - kHalfY, 0.0)));
          return client_.getState().isDone();
        },
        40);
    EXPECT_TRUE(ended) << log_.text();
    return nearest_m;
  }
};

TEST_F(NavigatorTable, ATableThatTheLidarSeesFromAfarOnlyIsDrivenAround) {
  EXPECT_GT(
      nearest_m(
          {{"lidar_frame", std::string("base_link")}, {"lidar_half_fov", 0.53}, {"inflation_radius", 0.26}}),
      0.24)
      << "half of the base is 0.25 m";
  EXPECT_EQ(client_.getState(), State::SUCCEEDED) << text();
}

TEST_F(NavigatorTable, IntensitiesThatAreNoHeightsAreSaidToBeNone) {
  load({{"lidar_frame", std::string("no_such_frame")}});
  EXPECT_TRUE(log_.wait("no transform from lidar_frame no_such_frame to base_link"));
}

/// A base with one arm of 0.9 m to its left, which a joint folds backwards along the base.
constexpr const char* kRobot = R"(<robot name="one_arm">
  <link name="base_link"/>
  <link name="arm"><collision><origin xyz="0.45 0 0"/><geometry><box size="0.9 0.06 0.06"/></geometry></collision></link>
  <joint name="shoulder" type="revolute"><parent link="base_link"/><child link="arm"/><origin xyz="0 0 0.6"/>
    <axis xyz="0 0 1"/><limit lower="-3.2" upper="3.2" effort="1" velocity="1"/></joint>
</robot>)";

class NavigatorArm : public NavigatorTest {
 protected:
  NavigatorArm() { ros::param::set("/robot_description", kRobot); }
  ~NavigatorArm() override { ros::param::del("/robot_description"); }

  /// Greatest distance between corners of the published footprint [m].
  double length_with(double shoulder_rad) {
    sensor_msgs::JointState joints;
    joints.name = {"shoulder"};
    joints.position = {shoulder_rad};
    footprints_.clear();
    double length_m = 0;
    (void)wait_while([&] { publisher_.publish(joints); },
                     [&] {
                       if (footprints_.count() < 15) return false;
                       length_m = 0;
                       const auto pose = footprints_.all().back();
                       for (const auto& a : pose->polygon.points)
                         for (const auto& b : pose->polygon.points)
                           length_m = std::max(length_m, std::hypot<double>(a.x - b.x, a.y - b.y));
                       return true;
                     },
                     10);
    return length_m;
  }

  ros::Publisher publisher_{handle_.advertise<sensor_msgs::JointState>("joint_states", 5)};
  Inbox<geometry_msgs::PolygonStamped> footprints_{"move_base/local_costmap/footprint"};
};

TEST_F(NavigatorArm, AnArmThatSticksOutBelongsToTheFootprint) {
  load({{"arm_outline", true}});
  EXPECT_GT(length_with(M_PI), 1.15) << "0.3 m before the middle, 0.9 m behind it: " << log_.text();
  EXPECT_GT(length_with(M_PI / 2), 1.1) << "0.25 m to the right, 0.9 m to the left";
  EXPECT_LT(length_with(M_PI / 2), 1.35);
  // A place beside the wall that suits the base, but not the arm.
  client_.sendGoal(goal(0.5, -3.4, 3 * M_PI / 2));
  ASSERT_TRUE(wait_for_end()) << log_.text();
  EXPECT_EQ(client_.getState(), State::ABORTED) << "the arm would be in the wall";
  (void)length_with(M_PI);
  client_.sendGoal(goal(0.5, -3.4, 3 * M_PI / 2));
  ASSERT_TRUE(wait_for_end()) << log_.text();
  EXPECT_EQ(client_.getState(), State::SUCCEEDED) << text();
}

/// A person walks through the hall along x at 0.6 m/s from (-3.5, 2), and stands at (-1.5, 2).
class WalkingPerson {
 public:
  explicit WalkingPerson(FakeRobot& robot) : robot_(robot), begin_(robot.now()) {}

  [[nodiscard]] Eigen::Vector2d place() const {
    return {std::min(-1.5, -3.5 + kSpeedMS * (robot_.now() - begin_).toSec()), 2.0};
  }
  void walk() {
    auto world = hall();
    const auto at = place();
    fill(world, {at.x() - kRadiusM, at.y() - kRadiusM, 0}, {at.x() + kRadiusM, at.y() + kRadiusM, 0});
    robot_.set_world(world);
  }

  static constexpr double kSpeedMS = 0.6;

 private:
  static constexpr double kRadiusM = 0.2;
  FakeRobot& robot_;
  ros::Time begin_;
};

TEST_F(NavigatorTest, FollowsPeopleFromScanToScan) {
  load();
  Inbox<TrackArray> tracks("move_base/people_tracks");
  ASSERT_TRUE(wait_for([&] { return tracks.connected(); }));
  WalkingPerson person(robot_);
  const auto walked = [&] { return person.place().x() > -1.6; };
  ASSERT_TRUE(wait_while([&] { person.walk(); }, walked, 20));
  const auto all = tracks.all();
  ASSERT_FALSE(all.empty());
  const auto& last = *all.back();
  EXPECT_EQ(last.header.frame_id, "odom");
  ASSERT_EQ(last.tracks.size(), 1U) << "walls and furniture are no people";
  const auto place = compose(robot_.odom_T_map(), {person.place().x(), person.place().y(), 0});
  EXPECT_NEAR(last.tracks[0].pose.pose.position.x, place.x, 0.35);
  EXPECT_NEAR(last.tracks[0].pose.pose.position.y, place.y, 0.25);
  EXPECT_NEAR(std::hypot(last.tracks[0].velocity.x, last.tracks[0].velocity.y), WalkingPerson::kSpeedMS, 0.2);
  EXPECT_EQ(all.front()->tracks.empty() ? 0 : all.front()->tracks[0].score, 0)
      << "has not walked a metre yet";
  EXPECT_EQ(last.tracks[0].score, 1) << "walks";
  for (const auto& message : all)
    for (const auto& track : message->tracks) EXPECT_EQ(track.id, last.tracks[0].id) << "one person, one id";

  Inbox<visualization_msgs::MarkerArray> shown("move_base/people");
  const auto end = robot_.now() + ros::Duration(4.0);
  ASSERT_TRUE(wait_while([&] { person.walk(); }, [&] { return robot_.now() > end; }, 20));
  ASSERT_GT(shown.count(), 0U);
  EXPECT_GT(shown.all().back()->markers.size(), 1U) << "who has walked and stands is a person still";
}

TEST_F(NavigatorTest, ThePlanLeadsAroundWhoStandsNotAroundWhoWalks) {
  robot_.put({-2, -2.5, 0});
  load({{"people_stand_s", 2.0}});
  Inbox<TrackArray> tracks("move_base/people_tracks");
  ASSERT_TRUE(wait_for([&] { return tracks.connected(); }));
  WalkingPerson person(robot_);
  const auto is_free = [&] {
    nav_msgs::GetPlan call;
    call.request.start = goal(-4, -2).target_pose;
    call.request.goal = goal(person.place().x(), person.place().y()).target_pose;
    EXPECT_TRUE(ros::service::call("move_base/make_plan", call));
    return !call.response.plan.poses.empty();
  };
  const auto begun = [&] { return person.place().x() > -3.1; };
  ASSERT_TRUE(wait_while([&] { person.walk(); }, begun, 20));
  EXPECT_TRUE(is_free()) << "who has just come into sight may walk: " << log_.text();
  const auto walked = [&] { return person.place().x() > -1.7; };
  ASSERT_TRUE(wait_while([&] { person.walk(); }, walked, 20));
  EXPECT_TRUE(is_free()) << "the person is elsewhere when the robot comes: " << log_.text();
  const auto stood = robot_.now() + ros::Duration(5.0);
  ASSERT_TRUE(wait_while([&] { person.walk(); }, [&] { return robot_.now() > stood; }, 20));
  EXPECT_FALSE(is_free()) << "the person has stood for 2 s and more";
}

}  // namespace
}  // namespace extperfc::ros_test
