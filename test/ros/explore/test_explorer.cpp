// The explorer as a nodelet, with a navigator that jumps to its goals and a map that grows by what is seen
// there.
#include <atomic>
#include <cmath>
#include <functional>
#include <mutex>

#include <actionlib/client/simple_action_client.h>
#include <actionlib/server/simple_action_server.h>
#include <extperfc/ExploreAction.h>
#include <gtest/gtest.h>
#include <move_base_msgs/MoveBaseAction.h>
#include <nav_msgs/GetPlan.h>
#include <nav_msgs/OccupancyGrid.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include "extperfc/base/math.hpp"

#include "ros/convert/occupancy_grid.hpp"
#include "ros/convert/planar_pose.hpp"
#include "test/ros/support/manager.hpp"
#include "test/ros/support/wait.hpp"
#include "test/ros/support/watch.hpp"

namespace extperfc::ros_test {
namespace {

using Client = actionlib::SimpleActionClient<ExploreAction>;
using Navigator = actionlib::SimpleActionServer<move_base_msgs::MoveBaseAction>;

constexpr double kResolution = 0.1;

/// Two rooms of 4 m by 4 m with a door of 1.4 m.
OccupancyGrid two_rooms() {
  OccupancyGrid map;
  map.width = 84;
  map.height = 42;
  map.resolution_m = kResolution;
  map.cells.assign(map.width * map.height, OccupancyGrid::kFree);
  for (std::size_t row = 0; row < map.height; ++row)
    for (std::size_t column = 0; column < map.width; ++column) {
      const bool outer = row == 0 || row + 1 == map.height || column == 0 || column + 1 == map.width;
      const bool inner = (column == 41 || column == 42) && (row < 14 || row > 27);
      if (outer || inner) map.cells[row * map.width + column] = OccupancyGrid::kOccupied;
    }
  return map;
}

class ExplorerTest : public testing::Test {
 protected:
  ExplorerTest() {
    map_ = truth_;
    std::fill(map_.cells.begin(), map_.cells.end(), OccupancyGrid::kUnknown);
    navigator_.start();
    stand_at({1, 2, 0});
    publish_map();
  }

  void load(const Params& params = {}) {
    Params all{{"footprint", ""}, {"map_patience_s", 1.0}};
    all.insert(params.begin(), params.end());
    ASSERT_TRUE(manager_.load("/explorer", "explorer", all)) << log_.text();
    ASSERT_TRUE(client_.waitForServer(ros::Duration(kPatienceS)));
  }

  /// Moves the robot, and maps what a lidar with 2.5 m sees there.
  void stand_at(const Pose2& pose) {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "map";
    transform.header.stamp = ros::Time::now();
    transform.child_frame_id = "base_link";
    transform.transform = ros_convert::to_transform_message(pose);
    broadcaster_.sendTransform(transform);
    see_from(pose);
  }

  void see_from(const Pose2& pose) {
    for (int i = 0; i < 720; ++i)
      for (double r = 0; r < 2.5; r += 0.03) {
        const double angle = kTwoPi * i / 720;
        const auto cell = truth_.cell_of(pose.x + r * std::cos(angle), pose.y + r * std::sin(angle));
        if (!cell) break;
        auto& seen = map_.cells[cell->row * map_.width + cell->column];
        seen = truth_.at(cell->column, cell->row);
        if (seen == OccupancyGrid::kOccupied) break;
      }
  }

  void publish_map() {
    std_msgs::Header header;
    header.frame_id = "map";
    header.stamp = ros::Time::now();
    maps_.publish(ros_convert::to_message(map_, header));
  }

  void navigate(const move_base_msgs::MoveBaseGoalConstPtr& goal) {
    ++goals_;
    while (waits_ && !navigator_.isPreemptRequested() && ros::ok()) ros::WallDuration(0.01).sleep();
    if (navigator_.isPreemptRequested()) {
      ++preempted_;
      return navigator_.setPreempted();
    }
    const Pose2 pose = *ros_convert::to_pose2(goal->target_pose.pose);
    if (fails_) return navigator_.setAborted();
    stand_at(pose);
    navigator_.setSucceeded();
    publish_map();
  }

  [[nodiscard]] ExploreResult explore(const ExploreGoal& goal = {}) {
    EXPECT_EQ(client_.sendGoalAndWait(goal, ros::Duration(2 * kPatienceS)).isDone(), true) << log_.text();
    return client_.getResult() ? *client_.getResult() : ExploreResult();
  }

  /// Answers the explorer's questions for plans.
  [[nodiscard]] static ros::ServiceServer serve_plans(const std::function<bool()>& has_plan) {
    const boost::function<bool(nav_msgs::GetPlan::Request&, nav_msgs::GetPlan::Response&)> answer =
        [has_plan](nav_msgs::GetPlan::Request& request, nav_msgs::GetPlan::Response& response) {
          if (has_plan()) response.plan.poses = {request.start, request.goal};
          return true;
        };
    return ros::NodeHandle().advertiseService("move_base/make_plan", answer);
  }

  [[nodiscard]] std::size_t unknown_cells() const {
    return static_cast<std::size_t>(
        std::count(map_.cells.begin(), map_.cells.end(), OccupancyGrid::kUnknown));
  }

  OccupancyGrid truth_ = two_rooms();
  OccupancyGrid map_;
  std::atomic<int> goals_{0};
  std::atomic<int> preempted_{0};
  std::atomic<bool> fails_{false};
  std::atomic<bool> waits_{false};
  ros::Publisher maps_{ros::NodeHandle().advertise<nav_msgs::OccupancyGrid>("map", 1, true)};
  tf2_ros::StaticTransformBroadcaster broadcaster_;
  Navigator navigator_{ros::NodeHandle(), "move_base",
                       [this](const move_base_msgs::MoveBaseGoalConstPtr& goal) { navigate(goal); }, false};
  Client client_{"explore", false};
  DiagnosticsWatch diagnostics_{"explorer"};
  LogWatch log_;
  Manager manager_;
};

TEST_F(ExplorerTest, MapsBothRoomsAndEnds) {
  load();
  const auto result = explore();
  EXPECT_EQ(result.code, ExploreResult::FINISHED) << result.message;
  EXPECT_EQ(client_.getState(), actionlib::SimpleClientGoalState::SUCCEEDED);
  EXPECT_GT(result.goals_reached, 1U);
  EXPECT_LT(unknown_cells(), 40U);
  EXPECT_NEAR(result.known_area, 2 * 16 + 0.28, 0.4);
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.message() == "waiting for a goal"; }));
}

TEST_F(ExplorerTest, BoundsKeepTheRobotInOneRoom) {
  load();
  ExploreGoal goal;
  goal.bounds.header.frame_id = "map";
  for (const auto& [x, y] : {std::pair{0.0F, 0.0F}, {3.9F, 0.0F}, {3.9F, 4.2F}, {0.0F, 4.2F}}) {
    geometry_msgs::Point32 point;
    point.x = x;
    point.y = y;
    goal.bounds.polygon.points.push_back(point);
  }
  EXPECT_EQ(explore(goal).code, ExploreResult::FINISHED);
  EXPECT_GT(unknown_cells(), 1000U);
  goal.bounds.polygon.points.resize(2);
  EXPECT_EQ(explore(goal).code, ExploreResult::INVALID);
  goal.bounds.header.frame_id = "odom";
  EXPECT_EQ(explore(goal).code, ExploreResult::INVALID);
}

TEST_F(ExplorerTest, FailedGoalsAreLeftOut) {
  fails_ = true;
  load();
  const auto result = explore();
  EXPECT_EQ(result.code, ExploreResult::FINISHED);
  EXPECT_EQ(result.goals_reached, 0U);
  EXPECT_GT(result.goals_failed, 0U);
  EXPECT_EQ(result.goals_failed, static_cast<std::uint32_t>(goals_));
}

TEST_F(ExplorerTest, AsksTheNavigatorForPlans) {
  std::atomic<int> refusals{1};  // a person who stands in the door for one question
  std::atomic<int> questions{0};
  const auto server = serve_plans([&] {
    ++questions;
    return refusals-- <= 0;
  });
  load({{"map_patience_s", 0.2}});
  EXPECT_EQ(explore().code, ExploreResult::FINISHED);
  EXPECT_LT(unknown_cells(), 40U);
  EXPECT_GE(questions, goals_);
}

TEST_F(ExplorerTest, EndsWhenTheRobotDoesNotGetAway) {
  const auto server = serve_plans([] { return true; });
  fails_ = true;
  load({{"max_frontier_m", 0.8}});
  const auto result = explore();
  EXPECT_EQ(result.code, ExploreResult::STUCK) << result.message;
  EXPECT_EQ(result.goals_failed, 3U);
  EXPECT_NE(result.message.find("(1.00, 2.00)"), std::string::npos) << result.message;
}

TEST_F(ExplorerTest, SaysThatTheNavigatorHasNoPlan) {
  const auto server = serve_plans([] { return false; });
  load({{"map_patience_s", 0.2}});
  const auto result = explore();
  EXPECT_EQ(result.code, ExploreResult::FINISHED);
  EXPECT_NE(result.message.find("no plan to 1"), std::string::npos) << result.message;
  EXPECT_EQ(goals_, 0);
}

TEST_F(ExplorerTest, CancellingStopsTheRobot) {
  waits_ = true;
  load();
  client_.sendGoal(ExploreGoal());
  ASSERT_TRUE(wait_for([this] { return goals_ == 1; })) << log_.text();
  client_.cancelGoal();
  EXPECT_TRUE(wait_for([this] { return preempted_ == 1; }));
  EXPECT_TRUE(wait_for([this] { return client_.getState() == actionlib::SimpleClientGoalState::PREEMPTED; }));
  EXPECT_EQ(client_.getResult()->code, ExploreResult::CANCELLED);
  ExploreGoal short_goal;
  short_goal.time_limit = 0.3F;
  EXPECT_EQ(explore(short_goal).code, ExploreResult::TIME_LIMIT);
  EXPECT_TRUE(wait_for([this] { return preempted_ == 2; }));
}

TEST_F(ExplorerTest, GoalWhoseFrontierIsKnownIsReplaced) {
  waits_ = true;
  load();
  client_.sendGoal(ExploreGoal());
  ASSERT_TRUE(wait_for([this] { return goals_ == 1; })) << log_.text();
  map_ = truth_;
  publish_map();
  EXPECT_TRUE(wait_for([this] { return client_.getState() == actionlib::SimpleClientGoalState::SUCCEEDED; }));
  EXPECT_TRUE(wait_for([this] { return preempted_ == 1; }));
}

TEST_F(ExplorerTest, UnloadingWhileExploringStopsTheRobot) {
  waits_ = true;
  load();
  client_.sendGoal(ExploreGoal());
  ASSERT_TRUE(wait_for([this] { return goals_ == 1; })) << log_.text();
  manager_.unload("/explorer");
  EXPECT_TRUE(wait_for([this] { return preempted_ == 1; }));
}

TEST_F(ExplorerTest, SaysWhatIsMissing) {
  load({{"robot_base_frame", "no_such_frame"}, {"transform_timeout_s", 0.1}});
  const auto result = explore();
  EXPECT_EQ(result.code, ExploreResult::NO_POSE);
  EXPECT_NE(result.message.find("no_such_frame"), std::string::npos) << result.message;
  manager_.unload("/explorer");
  maps_.shutdown();
  load();
  EXPECT_EQ(explore().code, ExploreResult::NO_MAP);
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.is_warning_about("no map yet"); }));
}

TEST_F(ExplorerTest, BadParametersAreRefused) {
  EXPECT_FALSE(
      manager_.load("/explorer", "explorer", {{"footprint", "[[0, 0], [1, 1]]"}, {"min_frontier", 1.0}}));
  EXPECT_TRUE(log_.wait("3 to 100 different corners"));
  EXPECT_TRUE(log_.wait("min_frontier"));
}

}  // namespace
}  // namespace extperfc::ros_test
