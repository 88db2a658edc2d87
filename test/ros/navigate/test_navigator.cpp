// The nodelet as clients of move_base see it.
#include <cmath>
#include <cstdlib>

#include <geometry_msgs/PolygonStamped.h>
#include <map_msgs/OccupancyGridUpdate.h>
#include <nav_msgs/Path.h>
#include <ros/service.h>
#include <std_srvs/Empty.h>

#include "test/ros/navigate/navigator_test.hpp"
#include "test/ros/support/reconfigure_client.hpp"

namespace extperfc::ros_test {
namespace {

using State = actionlib::SimpleClientGoalState;

TEST_F(NavigatorTest, ReachesAGoalThroughTheOpening) {
  load();
  client_.sendGoal(goal(3, 1, 1.0));
  ASSERT_TRUE(wait_for_end()) << log_.text();
  EXPECT_EQ(client_.getState(), State::SUCCEEDED) << text();
  EXPECT_EQ(text(), "success: goal reached");
  EXPECT_NEAR(robot_.pose().x, 3, 0.1);
  EXPECT_NEAR(robot_.pose().y, 1, 0.1);
  EXPECT_NEAR(robot_.pose().yaw, 1.0, 0.1);
  EXPECT_GE(robot_.seconds_until_it_stands(), 0);
  EXPECT_TRUE(wait_for([&] {  // the last zero may be on its path
    commands_.clear();
    return never([&] { return commands_.count() > 0; });
  })) << "commands only while a goal is active";
}

TEST_F(NavigatorTest, GoalsInOtherFramesAndFromRviz) {
  load();
  client_.sendGoal(goal(1.0, 0.0, 0.0, "base_link"));
  ASSERT_TRUE(wait_for_end());
  EXPECT_EQ(client_.getState(), State::SUCCEEDED) << text();
  EXPECT_NEAR(robot_.pose().x, -1, 0.15);
  client_.sendGoal(goal(0, 0, 0, "nowhere"));
  ASSERT_TRUE(wait_for_end());
  EXPECT_EQ(client_.getState(), State::REJECTED);
  EXPECT_NE(text().find("invalid_request"), std::string::npos) << text();
  auto simple = handle_.advertise<geometry_msgs::PoseStamped>("move_base_simple/goal", 1);
  ASSERT_TRUE(wait_for([&] { return simple.getNumSubscribers() > 0; }));
  simple.publish(goal(-2, 1).target_pose);
  EXPECT_TRUE(wait_for([&] { return std::hypot(robot_.pose().x + 2, robot_.pose().y - 1) < 0.1; }));
}

TEST_F(NavigatorTest, CancelStops) {
  load();
  client_.sendGoal(goal(3, 0));
  ASSERT_TRUE(wait_until_it_drives()) << log_.text();
  client_.cancelGoal();
  ASSERT_TRUE(wait_for_end());
  EXPECT_EQ(client_.getState(), State::PREEMPTED);
  EXPECT_EQ(text(), "cancelled: cancelled");
  EXPECT_GE(robot_.seconds_until_it_stands(), 0);
  EXPECT_LT(robot_.pose().x, 2.5);
}

TEST_F(NavigatorTest, ANewerGoalReplaces) {
  load();
  client_.sendGoal(goal(3, 0));
  ASSERT_TRUE(wait_until_it_drives());
  MoveBaseClient other("move_base", false);
  ASSERT_TRUE(wait_for([&] { return other.isServerConnected(); }));
  other.sendGoal(goal(-3, 1));
  ASSERT_TRUE(wait_for_end());
  EXPECT_EQ(client_.getState(), State::PREEMPTED);
  EXPECT_NE(text().find("replaced"), std::string::npos) << text();
  ASSERT_TRUE(wait_for([&] { return other.getState().isDone(); }, 40));
  EXPECT_EQ(other.getState(), State::SUCCEEDED) << other.getState().getText();
  EXPECT_NEAR(robot_.pose().x, -3, 0.1);
}

TEST_F(NavigatorTest, AGoalInAWallOrOutsideFailsAndSaysSo) {
  load();
  client_.sendGoal(goal(1.0, 2.0));
  ASSERT_TRUE(wait_for_end());
  EXPECT_EQ(client_.getState(), State::ABORTED);
  EXPECT_EQ(text().rfind("goal_blocked: ", 0), 0U) << text();
  client_.sendGoal(goal(50, 0));
  ASSERT_TRUE(wait_for_end());
  EXPECT_EQ(text().rfind("goal_outside: ", 0), 0U) << text();
  EXPECT_NEAR(robot_.pose().x, -2, 0.1);
  EXPECT_TRUE(wait_for([&] { return status_.all().back()->code == 201; })) << "goal_outside";
  EXPECT_EQ(last_state(), "idle");
}

TEST_F(NavigatorTest, MakesPlansWhileItDrives) {
  load();
  client_.sendGoal(goal(3, 0));
  ASSERT_TRUE(wait_until_it_drives());
  nav_msgs::GetPlan call;
  call.request.start = goal(-4, -2).target_pose;
  call.request.goal = goal(4, 2).target_pose;
  ASSERT_TRUE(ros::service::call("move_base/make_plan", call));
  ASSERT_GT(call.response.plan.poses.size(), 50U);
  EXPECT_EQ(call.response.plan.header.frame_id, "map");
  EXPECT_NEAR(call.response.plan.poses.front().pose.position.x, -4, 0.06);
  EXPECT_NEAR(call.response.plan.poses.back().pose.position.y, 2, 0.06);
  call.request.goal = goal(1.0, 3.0).target_pose;  // in the wall
  ASSERT_TRUE(ros::service::call("move_base/make_plan", call)) << "it always answers";
  EXPECT_TRUE(call.response.plan.poses.empty());
  ASSERT_TRUE(wait_for_end());
  EXPECT_EQ(client_.getState(), State::SUCCEEDED);
}

// The cells of a passage's walls may leave less than the footprint: a robot that stands in it goes on.
TEST_F(NavigatorTest, PlansFromAPassageThatItsCellsMakeTooNarrow) {
  fill(map_, {0.4, -4, 0}, {1.6, -0.25, 0});
  fill(map_, {0.4, 0.2, 0}, {1.6, 4, 0});
  load();
  nav_msgs::GetPlan call;
  call.request.start = goal(1.0, -0.025).target_pose;
  for (const double x : {4.0, -4.0}) {
    call.request.goal = goal(x, 2).target_pose;
    ASSERT_TRUE(wait_for([&] {
      return ros::service::call("move_base/make_plan", call) && !call.response.plan.poses.empty();
    })) << x;
    EXPECT_NEAR(call.response.plan.poses.back().pose.position.x, x, 0.06);
  }
}

TEST_F(NavigatorTest, FollowsWaypoints) {
  load();
  actionlib::SimpleActionClient<FollowWaypointsAction> follower("follow_waypoints", false);
  ASSERT_TRUE(wait_for([&] { return follower.isServerConnected(); }));
  FollowWaypointsGoal goals;
  goals.poses = {goal(-1, 1).target_pose, goal(1.0, 2.0).target_pose, goal(-3, 0).target_pose};
  follower.sendGoal(goals);
  ASSERT_TRUE(wait_for([&] { return follower.getState().isDone(); }, 60)) << log_.text();
  const auto result = follower.getResult();
  EXPECT_EQ(result->code, 203) << result->message;
  EXPECT_EQ(result->missed, std::vector<std::uint32_t>{1}) << "the one in the wall";
  EXPECT_NEAR(robot_.pose().x, -3, 0.1);
}

TEST_F(NavigatorTest, PublishesWhatRvizShows) {
  Inbox<nav_msgs::OccupancyGrid> global("move_base/global_costmap/costmap");
  Inbox<nav_msgs::OccupancyGrid> local("move_base/local_costmap/costmap");
  Inbox<map_msgs::OccupancyGridUpdate> updates("move_base/global_costmap/costmap_updates");
  Inbox<geometry_msgs::PolygonStamped> footprint("move_base/local_costmap/footprint");
  Inbox<nav_msgs::Path> path("move_base/global_plan");
  load();
  client_.sendGoal(goal(0, 1));
  EXPECT_TRUE(global.wait_for_count(1));
  EXPECT_TRUE(local.wait_for_count(2));
  EXPECT_TRUE(footprint.wait_for_count(1));
  EXPECT_TRUE(path.wait_for_count(1));
  ASSERT_GT(global.count(), 0U);
  const auto map = global.all().back();
  EXPECT_EQ(map->info.width, map_.width);
  EXPECT_EQ(map->data[0], 100) << "a wall";
  EXPECT_EQ(map->header.frame_id, "map");
  EXPECT_EQ(local.all().back()->header.frame_id, "odom");
  ASSERT_TRUE(wait_for_end());
}

TEST_F(NavigatorTest, ParametersChangeWhileItRuns) {
  load();
  const ReconfigureClient client("/navigator");
  const auto answer = client.set("max_vel_x", 0.3);
  EXPECT_EQ(value_of(answer.doubles, "max_vel_x"), 0.3);
  client_.sendGoal(goal(0, 0));
  ASSERT_TRUE(wait_for_end());
  EXPECT_EQ(client_.getState(), State::SUCCEEDED);
  for (const auto& command : commands_.all()) EXPECT_LE(command->linear.x, 0.3 + 1e-6);
  EXPECT_EQ(value_of(client.set("max_vel_x", -1.0).doubles, "max_vel_x"), 0.3) << "refused";
}

TEST_F(NavigatorTest, EveryBadParameterIsNamedAtOnce) {
  EXPECT_FALSE(manager_.load("/navigator", "navigator",
                             {{"max_vel_x", -1.0},
                              {"controller_frequency", 0.0},
                              {"footprint", std::string("[[1, 1]]")},
                              {"no_such_parameter", 1},
                              {"odom_frame", std::string("map")}}));
  for (const char* text :
       {"max_vel_x = -1 is out of its range", "controller_frequency = 0 is out of its range",
        "footprint: ", "no_such_parameter is not a parameter", "must be three different frames"})
    EXPECT_TRUE(log_.wait(text)) << text;
}

TEST_F(NavigatorTest, AnUnknownPlannerIsRefused) {
  EXPECT_FALSE(
      manager_.load("/navigator", "navigator", {{"base_global_planner", std::string("navfn/NavfnROS")}}));
  EXPECT_TRUE(log_.wait("base_global_planner navfn/NavfnROS"));
}

TEST_F(NavigatorTest, AUsersOwnPlannerIsLoaded) {
  const std::string packages = std::getenv("ROS_PACKAGE_PATH");
  ASSERT_EQ(setenv("ROS_PACKAGE_PATH", (packages + ":" EXTPERFC_OWN_PLANNER).c_str(), 1), 0);
  load({{"base_global_planner", std::string("own_planner/StraightPlanner")}});
  setenv("ROS_PACKAGE_PATH", packages.c_str(), 1);
  nav_msgs::GetPlan call;
  call.request.start = goal(-4, -2).target_pose;
  call.request.goal = goal(3, 3).target_pose;
  ASSERT_TRUE(ros::service::call("move_base/make_plan", call));
  EXPECT_EQ(call.response.plan.poses.size(), 101U) << "straight, through a wall";
  client_.sendGoal(goal(0, 0));
  ASSERT_TRUE(wait_for_end()) << log_.text();
  EXPECT_EQ(client_.getState(), State::SUCCEEDED) << text();
}

TEST_F(NavigatorTest, FilesForMoveBaseLoadWithANote) {
  load({{"max_planning_retries", 3}, {"clearing_rotation_allowed", true}});
  EXPECT_TRUE(log_.wait(
      "parameters of move_base without effect here: clearing_rotation_allowed, max_planning_retries"));
}

}  // namespace
}  // namespace extperfc::ros_test
