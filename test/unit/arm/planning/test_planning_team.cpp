// Only our own planner here: this test runs under the thread sanitizer too.
#include <atomic>
#include <limits>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

#include "extperfc/arm/planning_team.hpp"
#include "extperfc/base/stopwatch.hpp"

#include "test/unit/arm/planning/planar_arm.hpp"

namespace extperfc::arm {
namespace {

CollisionWorld world_of(const std::vector<WorldObject>& objects) {
  CollisionWorld world;
  for (const auto& object : objects) EXPECT_TRUE(world.add(object).has_value());
  return world;
}

/// Posts between "arm to the left" and "arm to the right": the straight path is blocked, folding helps.
CollisionChecker among_posts() {
  return CollisionChecker::make(planar_arm(), world_of({post("near", 0.75, 0.0), post("far", 1.3, 0.15),
                                                        post("left", -0.2, 0.9), post("behind", -0.9, -0.3)}))
      .value();
}

/// From kUp to (0, 0, 0) the first link would have to sweep through post c, or d the other way round.
CollisionChecker walled_in() {
  auto checker =
      CollisionChecker::make(planar_arm(), world_of({post("a", 0.8, 0.28, 0.3), post("b", 0.8, -0.28, 0.3),
                                                     post("c", 0.25, 0.35, 0.3), post("d", 0.25, -0.35, 0.3),
                                                     post("e", -0.35, 0.0, 0.3)}))
          .value();
  EXPECT_TRUE(checker.is_free(joints(0, 0, 0)));
  EXPECT_TRUE(checker.is_free(joints(1.57, 0, 0)));
  return checker;
}

const JointVector kUp = joints(1.57, 0, 0);
const JointVector kLeft = joints(1.2, 0.2, 0.1);
const JointVector kRight = joints(-1.2, -0.2, -0.1);

PlanningTeamParams team_of(int members, int threads) {
  PlanningTeamParams params;
  params.members.clear();
  for (int m = 0; m < members; ++m)
    params.members.push_back({"rrt_connect", static_cast<std::uint64_t>(m + 1)});
  params.threads = threads;
  return params;
}

TEST(PlanningTeam, FindsAFreePath) {
  auto checker = among_posts();
  const auto result = PlanningTeam(checker, team_of(3, 2)).plan({kLeft, {kRight}, {}});
  ASSERT_EQ(result.plan.code, PlanCode::kSuccess) << result.plan.message;
  EXPECT_EQ(result.plan.waypoints.front(), kLeft);
  EXPECT_EQ(result.plan.waypoints.back(), kRight);
  EXPECT_TRUE(free_all_along(checker, result.plan.waypoints));
  EXPECT_GE(result.member, 0);
  EXPECT_NEAR(result.cost, path_length(result.plan.waypoints), 1e-12);
}

TEST(PlanningTeam, ThePathDoesNotDependOnTheNumberOfThreads) {
  auto checker = among_posts();
  const auto alone = PlanningTeam(checker, team_of(4, 1)).plan({kLeft, {kRight}, {}});
  ASSERT_EQ(alone.plan.code, PlanCode::kSuccess);
  for (const int threads : {1, 2, 4})
    for (int again = 0; again < 5; ++again) {
      const auto result = PlanningTeam(checker, team_of(4, threads)).plan({kLeft, {kRight}, {}});
      ASSERT_EQ(result.plan.waypoints, alone.plan.waypoints) << threads << " threads, run " << again;
      ASSERT_EQ(result.member, alone.member);
    }
}

TEST(PlanningTeam, ImprovementKeepsTheBestOfItsAttempts) {
  auto checker = among_posts();
  TeamEffort effort;
  effort.timeout_s = 60;
  effort.improve = true;
  double last = std::numeric_limits<double>::infinity();
  std::vector<JointVector> path;
  for (const int attempts : {1, 4, 16}) {
    effort.max_attempts = attempts;
    const auto alone = PlanningTeam(checker, team_of(2, 1)).plan({kLeft, {kRight}, {}}, effort);
    const auto result = PlanningTeam(checker, team_of(2, 3)).plan({kLeft, {kRight}, {}}, effort);
    ASSERT_EQ(result.plan.code, PlanCode::kSuccess) << result.plan.message;
    EXPECT_EQ(result.attempts, attempts);
    EXPECT_EQ(result.found, attempts);
    EXPECT_LE(result.cost, last);
    EXPECT_EQ(result.plan.waypoints, alone.plan.waypoints);
    EXPECT_TRUE(free_all_along(checker, result.plan.waypoints));
    last = result.cost;
  }
}

TEST(PlanningTeam, ImprovementUsesTheTimeAndTheCostAsked) {
  auto checker = among_posts();
  auto params = team_of(2, 2);
  std::atomic<int> asked{0};
  params.cost = [&](const std::vector<JointVector>& path) {
    ++asked;
    return static_cast<double>(path.size());
  };
  TeamEffort effort;
  effort.timeout_s = 0.2;
  effort.improve = true;
  const Stopwatch watch;
  const auto result = PlanningTeam(checker, params).plan({kLeft, {kRight}, {}}, effort);
  EXPECT_GE(watch.seconds(), 0.2);
  ASSERT_EQ(result.plan.code, PlanCode::kSuccess);
  EXPECT_EQ(result.cost, static_cast<double>(result.plan.waypoints.size()));
  EXPECT_EQ(asked, result.found);
  EXPECT_GT(result.attempts, 1);
}

TEST(PlanningTeam, EndsInTimeWhereThereIsNoPath) {
  auto checker = walled_in();
  for (const bool improve : {false, true}) {
    const Stopwatch watch;
    const auto result =
        PlanningTeam(checker, team_of(3, 2)).plan({kUp, {joints(0, 0, 0)}, {}}, {0.3, improve});
    const double took = watch.seconds();
    EXPECT_EQ(result.plan.code, PlanCode::kTimeout);
    EXPECT_TRUE(result.plan.waypoints.empty());
    EXPECT_GE(took, 0.3);
    EXPECT_LT(took, 3.0);  // no measure of the 50 ms: the sanitizer and a busy machine take their time
    RecordProperty(improve ? "overrun_improve_ms" : "overrun_ms", static_cast<int>(1e3 * (took - 0.3)));
  }
}

TEST(PlanningTeam, EndsWhenCancelledAndAsksInTheCallingThread) {
  auto checker = walled_in();
  const auto self = std::this_thread::get_id();
  for (const bool improve : {false, true}) {
    int asked = 0;
    const auto cancelled = [&] {
      EXPECT_EQ(std::this_thread::get_id(), self);
      return ++asked > 5;
    };
    const auto result =
        PlanningTeam(checker, team_of(2, 2)).plan({kUp, {joints(0, 0, 0)}, cancelled}, {60, improve});
    EXPECT_EQ(result.plan.code, PlanCode::kCancelled);
    EXPECT_TRUE(result.plan.waypoints.empty());
  }
}

TEST(PlanningTeam, EndsWhenEveryMemberIsFull) {
  auto checker = walled_in();
  auto params = team_of(3, 2);
  params.planner.max_states = 50;
  const Stopwatch watch;
  const auto result = PlanningTeam(checker, params).plan({kUp, {joints(0, 0, 0)}, {}}, {60});
  EXPECT_EQ(result.plan.code, PlanCode::kTimeout);
  EXPECT_LT(watch.seconds(), 30.0);
}

TEST(PlanningTeam, TakesAnyOfManyGoals) {
  auto checker = among_posts();
  std::vector<JointVector> goals(50, joints(9, 0, 0));
  goals[37] = kRight;
  const auto result = PlanningTeam(checker, team_of(2, 2)).plan({kLeft, goals, {}});
  ASSERT_EQ(result.plan.code, PlanCode::kSuccess) << result.plan.message;
  EXPECT_EQ(result.plan.goal, 37);
}

TEST(PlanningTeam, GoesStraightAndSaysWhatIsWrong) {
  auto checker = among_posts();
  PlanningTeam team(checker, team_of(2, 2));
  const auto straight = team.plan({kLeft, {joints(1.3, 0.2, 0.1)}, {}});
  EXPECT_EQ(straight.plan.waypoints.size(), 2U);
  EXPECT_EQ(straight.member, -1);
  EXPECT_EQ(team.plan({kLeft, {}, {}}).plan.code, PlanCode::kInvalidRequest);
  EXPECT_EQ(team.plan({joints(0, 0, 0), {kRight}, {}}).plan.code, PlanCode::kStartInCollision);
  EXPECT_EQ(team.plan({kLeft, {joints(9, 0, 0)}, {}}).plan.code, PlanCode::kGoalOutsideLimits);
}

TEST(PlanningTeam, AnErrorOfTheCostReachesTheCaller) {
  auto checker = among_posts();
  auto params = team_of(2, 2);
  params.cost = [](const auto&) -> double { throw std::runtime_error("no cost"); };
  PlanningTeam team(checker, params);
  EXPECT_THROW((void)team.plan({kLeft, {kRight}, {}}, {5, true}), std::runtime_error);
}

TEST(PlanningTeam, RefusesBadParameters) {
  auto checker = among_posts();
  EXPECT_THROW(PlanningTeam(checker, team_of(0, 1)), std::invalid_argument);
  EXPECT_THROW(PlanningTeam(checker, team_of(1, 0)), std::invalid_argument);
  EXPECT_THROW(PlanningTeam(checker, team_of(1, 9)), std::invalid_argument);
  auto params = team_of(2, 1);
  params.members[1].planner = "rrt";
  EXPECT_THROW(PlanningTeam(checker, params), std::invalid_argument);
  params.members[1].planner = "lbkpiece";
  EXPECT_THROW(PlanningTeam(checker, params), std::invalid_argument) << "it needs a thread of its own";
  params.threads = 2;
  EXPECT_NO_THROW(PlanningTeam(checker, params));
  PlanningTeam team(checker, team_of(1, 1));
  EXPECT_THROW((void)team.plan({kLeft, {kRight}, {}}, {0}), std::invalid_argument);
}

}  // namespace
}  // namespace extperfc::arm
