// The state machine: every transition of a goal, with a robot that does what it is commanded.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "test/unit/navigate/core/fake_robot.hpp"

namespace extperfc::navigate::test {
namespace {

TEST(Navigator, ReachesAGoal) {
  FakeRobot robot;
  robot.drive_to({2, 1, 0});
  ASSERT_TRUE(robot.run());
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kSuccess);
  EXPECT_EQ(robot.ends[0].task, 1U);
  EXPECT_NEAR(robot.pose.x, 2, 0.09);
  EXPECT_NEAR(robot.pose.y, 1, 0.09);
  EXPECT_FALSE(robot.navigator.active());
  EXPECT_FALSE(robot.cycle().active);
}

TEST(Navigator, StandsUntilThereIsAPlan) {
  FakeRobot robot;
  robot.answers = false;
  robot.drive_to({2, 0, 0});
  robot.run_for(1.0);
  ASSERT_EQ(robot.wishes.size(), 1U) << "asked once, while the plan is under way";
  EXPECT_EQ(robot.last.state, NavState::kPlanning);
  EXPECT_EQ(robot.pose.x, 0);
  robot.navigator.set_plan(robot.answer(robot.wishes[0]));
  robot.run_for(0.5);
  EXPECT_EQ(robot.last.state, NavState::kControlling);
  EXPECT_GT(robot.pose.x, 0.05);
}

TEST(Navigator, PlansAgainAtItsFrequencyAndKeepsAPathOfTheSameLength) {
  NavigatorParams params;
  params.planner_frequency_hz = 2;
  FakeRobot robot(params);
  robot.drive_to({3.5, 0, 0});
  robot.run_for(3.0);
  EXPECT_NEAR(static_cast<double>(robot.wishes.size()), 6, 2);
  EXPECT_LE(robot.control->paths, 2) << "the first path is kept";
  EXPECT_FALSE(robot.wishes.back().current.poses.empty());
}

TEST(Navigator, WithoutAFrequencyItPlansOnce) {
  NavigatorParams params;
  params.planner_frequency_hz = 0;
  FakeRobot robot(params);
  robot.drive_to({2, 0, 0});
  ASSERT_TRUE(robot.run());
  EXPECT_EQ(robot.wishes.size(), 1U);
}

TEST(Navigator, PlansAtOnceWhenThePathIsBlockedAheadOrTheMapChanged) {
  NavigatorParams params;
  params.planner_frequency_hz = 0;
  FakeRobot robot(params);
  robot.drive_to({3.5, 0, 0});
  robot.run_for(1.0);
  ASSERT_EQ(robot.wishes.size(), 1U);
  robot.block({2.0, 0}, 0.1);
  robot.run_for(0.2);
  EXPECT_EQ(robot.wishes.size(), 2U);
  robot.costs = make_cost_grid(160, 160, 0.05, {-4, -4}, kFreeCost);
  robot.run_for(1.0);
  const auto before = robot.wishes.size();
  robot.input.map_changed = true;
  robot.run_for(0.6);
  EXPECT_EQ(robot.wishes.size(), before + 1);
}

TEST(Navigator, ANewerGoalReplacesAndCancellingStops) {
  FakeRobot robot;
  robot.drive_to({3, 0, 0});
  robot.run_for(1.0);
  const auto replaced = robot.navigator.start({7, {{0, 3, 0}}, false});
  ASSERT_TRUE(replaced);
  EXPECT_EQ(replaced->task, 1U);
  EXPECT_EQ(replaced->error.code, NavCode::kReplaced);
  robot.run_for(1.0);
  EXPECT_GT(robot.pose.y, 0.1);
  const auto cancelled = robot.navigator.cancel();
  ASSERT_TRUE(cancelled);
  EXPECT_EQ(cancelled->error.code, NavCode::kCancelled);
  const auto output = robot.cycle();
  EXPECT_FALSE(output.active);
  EXPECT_EQ(output.command.vx, 0);
  EXPECT_FALSE(robot.navigator.cancel());
}

TEST(Navigator, APlanOfAnOlderGoalIsIgnored) {
  FakeRobot robot;
  robot.answers = false;
  robot.drive_to({3, 0, 0});
  (void)robot.cycle();
  const auto old = robot.answer(robot.wishes.at(0));
  robot.drive_to({0, 3, 0});
  (void)robot.cycle();
  robot.navigator.set_plan(old);
  robot.run_for(0.3);
  EXPECT_EQ(robot.last.state, NavState::kPlanning);
}

TEST(Navigator, InvalidGoalsEndAtOnce) {
  for (const auto& goals : {std::vector<Pose2>{}, std::vector<Pose2>{{std::nan(""), 0, 0}},
                            std::vector<Pose2>{{0, 0, 0}, {0, INFINITY, 0}}}) {
    FakeRobot robot;
    (void)robot.navigator.start({1, goals, false});
    (void)robot.cycle();
    ASSERT_EQ(robot.ends.size(), 1U);
    EXPECT_EQ(robot.ends[0].error.code, NavCode::kInvalidRequest);
  }
}

TEST(Navigator, WhatNoRecoveryMendsEndsAtOnce) {
  for (const auto code : {NavCode::kGoalOutside, NavCode::kGoalUnknown, NavCode::kInvalidRequest}) {
    FakeRobot robot;
    robot.plan_error = NavError{code, "no"};
    robot.drive_to({1, 0, 0});
    ASSERT_TRUE(robot.run(1.0));
    EXPECT_EQ(robot.ends[0].error.code, code);
  }
}

TEST(Navigator, YieldsToWhoCannotPassAndGoesOn) {
  FakeRobot robot;
  robot.aside = Pose2{-2, 1.5, 0};
  robot.plan_error = NavError{NavCode::kNoPath, "a person in the corridor"};
  robot.input.people = {{{1.2, 0}, {0, 0}, 0.25}};
  robot.drive_to({3, 0, 0});
  robot.run_for(NavigatorParams{}.planner_patience_s + 1);
  ASSERT_TRUE(robot.wishes.back().yield_to_m);
  EXPECT_EQ(*robot.wishes.back().yield_to_m, Eigen::Vector2d(1.2, 0));
  const auto wishes = robot.wishes.size();
  robot.run_for(8);
  EXPECT_LT(distance_m(robot.pose, *robot.aside), 0.1);
  EXPECT_TRUE(robot.ends.empty()) << "this is not the goal";
  robot.input.people = {{{-0.5, 0}, {-0.6, 0}, 0.25}};  // comes by
  robot.run_for(5);
  EXPECT_LT(distance_m(robot.pose, *robot.aside), 0.1);
  EXPECT_EQ(robot.wishes.size(), wishes) << "one plan to the place is enough";
  robot.input.people = {{{-3, 0}, {-0.6, 0}, 0.25}};  // has passed
  robot.plan_error.reset();
  ASSERT_TRUE(robot.run(20));
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kSuccess);
}

TEST(Navigator, YieldingEndsThoughThePersonStays) {
  FakeRobot robot;
  robot.aside = Pose2{-1, 1, 0};
  robot.plan_error = NavError{NavCode::kNoPath, "a person in the corridor"};
  robot.input.people = {{{0.5, 0}, {0, 0}, 0.25}};
  robot.drive_to({3, 0, 0});
  ASSERT_TRUE(robot.run(200));
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kNoPath);
  const auto asked = std::count_if(robot.wishes.begin(), robot.wishes.end(),
                                   [](const PlanWish& wish) { return wish.yield_to_m.has_value(); });
  EXPECT_GE(asked, 1);
  EXPECT_LE(asked, 3) << "once at a place";
}

TEST(Navigator, WithoutAPlaceToYieldTheOtherRecoveriesFollow) {
  FakeRobot robot;
  robot.plan_error = NavError{NavCode::kNoPath, "a person in the corridor"};
  robot.input.people = {{{1.2, 0}, {0, 0}, 0.25}};
  robot.drive_to({3, 0, 0});
  ASSERT_TRUE(robot.run(200));
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kNoPath);
  EXPECT_EQ(distance_m(robot.pose, Pose2{}), 0);
  EXPECT_GE(robot.events.size(), 3U);
}

TEST(Navigator, WithoutAPathItRecoversAndGivesUpWithTheCause) {
  FakeRobot robot;
  robot.plan_error = NavError{NavCode::kNoPath, "walls all around"};
  robot.drive_to({1, 0, 0});
  ASSERT_TRUE(robot.run(60));
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kNoPath);
  EXPECT_NE(robot.ends[0].error.message.find("walls all around"), std::string::npos);
  EXPECT_NE(robot.ends[0].error.message.find("gave up at (0.00, 0.00)"), std::string::npos)
      << robot.ends[0].error.message;
  EXPECT_GE(robot.events.size(), 2U) << "each recovery is reported";
}

TEST(Navigator, AGoalThatReplacesAnotherDoesNotStopTheBase) {
  FakeRobot robot;
  robot.drive_to({3, 0, 0});
  robot.run_for(2);
  ASSERT_NEAR(robot.velocity.vx, 0.5, 0.01);
  robot.answers = false;
  robot.drive_to({3, 1, 0});
  robot.run_for(0.4);
  EXPECT_NEAR(robot.velocity.vx, 0.5, 0.01) << "the planner thinks";
  robot.run_for(0.3);
  EXPECT_EQ(robot.velocity.vx, 0) << "but not for long";
  robot.answers = true;
  robot.navigator.set_plan(robot.answer(robot.wishes.back()));
  ASSERT_TRUE(robot.run());
  EXPECT_EQ(robot.ends.back().error.code, NavCode::kSuccess);
  EXPECT_NEAR(robot.pose.y, 1, 0.2);
}

TEST(Navigator, AGoalThatReplacesAnotherDoesNotStopTheBaseBehindWhoWalksAhead) {
  FakeRobot robot;
  robot.drive_to({5, 0, 0});
  robot.run_for(2);
  robot.block({robot.pose.x + 2, 0}, 0.1);
  robot.answers = false;
  robot.drive_to({5, 1, 0});
  robot.run_for(0.4);
  EXPECT_NEAR(robot.velocity.vx, 0.5, 0.01);
}

TEST(Navigator, WithoutAPlanToTheNewGoalItStops) {
  FakeRobot robot;
  robot.drive_to({3, 0, 0});
  robot.run_for(2);
  robot.plan_error = NavError{NavCode::kNoPath, "walls all around"};
  robot.drive_to({3, 1, 0});
  robot.run_for(0.15);
  EXPECT_EQ(robot.velocity.vx, 0);
}

TEST(Navigator, WhilePeopleAreInSightItWaitsLongerForAPath) {
  FakeRobot robot;
  robot.plan_error = NavError{NavCode::kGoalBlocked, "somebody stands at the goal"};
  robot.input.people.push_back({{1, 0}, {0, 0}, 0.3});
  robot.drive_to({1, 0, 0});
  robot.run_for(robot.params_.people_patience_s - 1);
  EXPECT_TRUE(robot.events.empty()) << robot.events.front();
  robot.plan_error.reset();
  ASSERT_TRUE(robot.run(10));
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kSuccess);
  robot.plan_error = NavError{NavCode::kGoalBlocked, "somebody stands at the goal"};
  robot.drive_to({2, 0, 0});
  ASSERT_TRUE(robot.run(120)) << "not for ever";
  EXPECT_EQ(robot.ends[1].error.code, NavCode::kGoalBlocked);
}

/// Has a path of 3.5 m and stands, so that lengths stay.
void stand_on_a_path(FakeRobot& robot) {
  robot.drive_to({3.5, 0, 0});
  robot.run_for(0.5);
  robot.control->velocity = Twist2{};
}

TEST(Navigator, APlaceThatMadeItTakeADetourIsAvoidedForAWhile) {
  NavigatorParams params;
  params.planner_frequency_hz = 5;
  params.detour_memory_s = 4;
  params.oscillation_timeout_s = 0;
  FakeRobot robot(params);
  stand_on_a_path(robot);
  robot.via = Pose2{1.75, 0.8, 0};
  robot.current_blocked = true;
  robot.run_for(0.5);
  EXPECT_TRUE(robot.wishes.back().avoid.empty()) << "a path of about the same length is no detour";
  robot.via = Pose2{1.75, 2.8, 0};
  robot.run_for(0.5);
  robot.current_blocked = false;
  robot.run_for(1.0);
  ASSERT_EQ(robot.wishes.back().avoid.size(), 1U);
  EXPECT_EQ(robot.wishes.back().avoid[0].middle_m, Eigen::Vector2d(3.5, 0));
  EXPECT_EQ(robot.wishes.back().avoid[0].radius_m, params.recovery.avoid_person_m);
  robot.run_for(params.detour_memory_s);
  EXPECT_TRUE(robot.wishes.back().avoid.empty());
}

TEST(Navigator, WhatBlocksThePathNearTheRobotIsWhereTheDetourLeadsAround) {
  NavigatorParams params;
  params.oscillation_timeout_s = 0;
  FakeRobot robot(params);
  stand_on_a_path(robot);
  robot.via = Pose2{1.75, 2.8, 0};
  robot.block({2.0, 0}, 0.1);
  robot.run_for(2.5);
  ASSERT_FALSE(robot.wishes.back().avoid.empty());
  EXPECT_NEAR(robot.wishes.back().avoid[0].middle_m.x(), 2.0 - 0.1 - 0.4, 0.15)
      << "where the base would touch";
}

TEST(Navigator, AFailedPlanKeepsAnOldPathThatIsFree) {
  FakeRobot robot;
  robot.drive_to({2, 0, 0});
  robot.run_for(0.5);
  robot.plan_error = NavError{NavCode::kPlanTimeout, "slow"};
  ASSERT_TRUE(robot.run());
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kSuccess);
}

TEST(Navigator, AFailedPlanAndABlockedPathStop) {
  FakeRobot robot;
  robot.drive_to({3, 0, 0});
  robot.run_for(0.5);
  robot.plan_error = NavError{NavCode::kNoPath, "the door is closed"};
  robot.current_blocked = true;
  ASSERT_TRUE(robot.run(60));
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kNoPath);
}

TEST(Navigator, WhoStandsAtAFarGoalMayBeGoneWhenTheRobotComes) {
  FakeRobot robot;
  robot.drive_to({6, 0, 0});
  robot.run_for(0.5);
  robot.plan_error = NavError{NavCode::kGoalBlocked, "somebody walks there"};
  robot.current_blocked = true;
  while (robot.pose.x < 6 - NavigatorParams{}.blocked_ahead_m - 0.1 && robot.now_s < 130) robot.cycle();
  EXPECT_TRUE(robot.events.empty()) << robot.events.front();
  robot.run_for(2.0);
  ASSERT_FALSE(robot.events.empty());
  EXPECT_NE(robot.events.front().find("the path is blocked, and there is no other"), std::string::npos);
  robot.plan_error.reset();
  robot.current_blocked = false;
  ASSERT_TRUE(robot.run());
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kSuccess);
}

TEST(Navigator, BlockedItTriesEveryStepOnceAtAPlace) {
  FakeRobot robot;
  robot.control->error = NavError{NavCode::kBlocked, "an obstacle in front"};
  robot.drive_to({3, 0, 0});
  ASSERT_TRUE(robot.run(200));
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kBlocked);
  std::vector<std::string> steps;
  for (const auto& event : robot.events)
    if (event.rfind("recovery: ", 0) == 0) steps.push_back(event.substr(10, event.find(", because") - 10));
  auto unique = steps;
  std::sort(unique.begin(), unique.end());
  EXPECT_EQ(std::unique(unique.begin(), unique.end()), unique.end()) << "no step twice at one place";
  EXPECT_GE(steps.size(), 3U);
}

TEST(Navigator, RecoveryThatHelpsIsFollowedByThePathToTheGoal) {
  FakeRobot robot;
  robot.control->error = NavError{NavCode::kBlocked, "a person in front"};
  robot.drive_to({2, 0, 0});
  robot.run_for(4.0);
  EXPECT_EQ(robot.last.state, NavState::kRecovering);
  robot.control->error.reset();
  ASSERT_TRUE(robot.run());
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kSuccess);
}

TEST(Navigator, WithoutProgressItCallsItOscillating) {
  FakeRobot robot;
  robot.control->velocity = Twist2{0, 0, 0.5};  // round and round
  robot.drive_to({3, 0, 0});
  ASSERT_TRUE(robot.run(300));
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kOscillating);
}

TEST(Navigator, WithoutRecoveryItEndsWithTheFirstCause) {
  NavigatorParams params;
  params.recovery_enabled = false;
  FakeRobot robot(params);
  robot.control->error = NavError{NavCode::kBlocked, "an obstacle in front"};
  robot.drive_to({3, 0, 0});
  ASSERT_TRUE(robot.run(10));
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kBlocked);
}

TEST(Navigator, TheGuardsStopIsACause) {
  FakeRobot robot;
  robot.input.guard_stopped = true;
  robot.control->velocity = Twist2{};
  robot.drive_to({3, 0, 0});
  ASSERT_TRUE(robot.run(200));
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kCollisionAhead);
}

TEST(Navigator, WaypointsAreDrivenToInTurn) {
  FakeRobot robot;
  (void)robot.navigator.start({3, {{1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, false});
  ASSERT_TRUE(robot.run());
  EXPECT_EQ(robot.ends[0].error.code, NavCode::kSuccess);
  EXPECT_TRUE(robot.ends[0].missed.empty());
  EXPECT_NEAR(robot.pose.x, 0, 0.1);
  EXPECT_NEAR(robot.pose.y, 1, 0.1);
  EXPECT_EQ(robot.wishes.front().request.goal.y, 0);
  EXPECT_EQ(robot.wishes.back().request.goal.x, 0);
}

TEST(Navigator, AWaypointThatFailsIsLeftOutOrEndsTheTask) {
  for (const bool stop : {false, true}) {
    FakeRobot robot;
    (void)robot.navigator.start({1, {{1, 0, 0}, {2, 0, 0}}, stop});
    robot.plan_error = NavError{NavCode::kGoalOutside, "outside"};
    (void)robot.cycle();
    robot.plan_error.reset();  // only the first plan fails
    (void)robot.cycle();
    if (robot.ends.empty()) {
      ASSERT_TRUE(robot.run());
    }
    EXPECT_EQ(robot.ends[0].error.code, NavCode::kGoalOutside);
    EXPECT_EQ(robot.ends[0].missed, std::vector<std::size_t>{0});
    EXPECT_NEAR(robot.pose.x, stop ? 0 : 2, 0.1);
  }
}

TEST(Navigator, ThePathIsGivenAnewWhenLocalizationMoves) {
  FakeRobot robot;
  robot.drive_to({3, 0, 0});
  robot.run_for(0.5);
  const int before = robot.control->paths;
  robot.run_for(0.5);
  EXPECT_EQ(robot.control->paths, before);
  robot.input.now_s = robot.now_s += 0.05;
  robot.input.odom_T_base = robot.pose;
  robot.input.map_T_base = compose({0.05, 0.02, 0.01}, robot.pose);
  (void)robot.navigator.update(robot.input);
  EXPECT_EQ(robot.control->paths, before + 1);
  EXPECT_NEAR(robot.control->path.poses.back().x, 3 - 0.05, 0.01) << "the same place of the map";
}

TEST(Navigator, BadParametersAreRefused) {
  NavigatorParams params;
  params.limits.max_vx_m_s = -1;
  EXPECT_FALSE(validate(params));
  EXPECT_THROW(FakeRobot{params}, std::invalid_argument);
  params = {};
  params.goal.xy_m = 0;
  EXPECT_NE(validate(params).error().message.find("xy_goal_tolerance"), std::string::npos);
}

}  // namespace
}  // namespace extperfc::navigate::test
