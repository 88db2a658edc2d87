#include <limits>

#include <gtest/gtest.h>

#include "extperfc/arm/motion_planner.hpp"
#include "extperfc/arm/planning_team.hpp"
#include "extperfc/base/rng.hpp"
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
CollisionWorld posts() {
  return world_of(
      {post("near", 0.75, 0.0), post("far", 1.3, 0.15), post("left", -0.2, 0.9), post("behind", -0.9, -0.3)});
}

CollisionChecker checker_of(const CollisionWorld& world) {
  return CollisionChecker::make(planar_arm(), world).value();
}

const JointVector kLeft = joints(1.2, 0.2, 0.1);
const JointVector kRight = joints(-1.2, -0.2, -0.1);

PlanResult plan(CollisionChecker& checker, const JointVector& start, const std::vector<JointVector>& goals,
                const PlannerParams& params = {}) {
  return MotionPlanner(checker, params).plan({start, goals, {}});
}

TEST(MotionPlanner, GoesStraightWhereNothingStands) {
  auto checker = checker_of({});
  const auto result = plan(checker, kLeft, {kRight});
  ASSERT_EQ(result.code, PlanCode::kSuccess) << result.message;
  EXPECT_EQ(result.waypoints.size(), 2U);
  EXPECT_NEAR(result.length_rad, (kRight - kLeft).norm(), 1e-12);
}

TEST(MotionPlanner, EveryStateOfThePathAroundIsFree) {
  auto checker = checker_of(posts());
  ASSERT_FALSE(free_all_along(checker, {kLeft, kRight})) << "the straight path should be blocked";
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    PlannerParams params;
    params.seed = seed;
    const auto result = plan(checker, kLeft, {kRight}, params);
    ASSERT_EQ(result.code, PlanCode::kSuccess) << "seed " << seed << ": " << result.message;
    EXPECT_EQ(result.waypoints.front(), kLeft);
    EXPECT_EQ(result.waypoints.back(), kRight);
    EXPECT_TRUE(free_all_along(checker, result.waypoints)) << "seed " << seed;
    EXPECT_NEAR(result.length_rad, path_length(result.waypoints), 1e-12);
  }
}

TEST(MotionPlanner, RandomWorlds) {
  Rng rng(7);
  int solved = 0;
  for (int world = 0; world < 20; ++world) {
    std::vector<WorldObject> objects;
    for (int i = 0; i < 5; ++i)
      objects.push_back(post("post" + std::to_string(i), rng.uniform(-1.4, 1.4), rng.uniform(-1.4, 1.4)));
    auto checker = checker_of(world_of(objects));
    const auto random_state = [&] {
      return joints(rng.uniform(-2.8, 2.8), rng.uniform(-2, 2), rng.uniform(-2, 2));
    };
    PlannerParams params;
    params.timeout_s = 0.5;
    const auto result = plan(checker, random_state(), {random_state()}, params);
    if (result.code != PlanCode::kSuccess) {
      EXPECT_FALSE(result.message.empty());
      continue;
    }
    ++solved;
    EXPECT_TRUE(free_all_along(checker, result.waypoints)) << "world " << world;
  }
  EXPECT_GE(solved, 3);  // the others begin or end in a post
}

TEST(MotionPlanner, TheSameSeedGivesTheSamePath) {
  auto checker = checker_of(posts());
  auto other = checker.clone();
  PlannerParams params;
  params.seed = 5;
  EXPECT_EQ(plan(checker, kLeft, {kRight}, params).waypoints, plan(other, kLeft, {kRight}, params).waypoints);
  params.shortcut_rounds = 0;
  const auto first = plan(checker, kLeft, {kRight}, params);
  params.seed = 6;
  EXPECT_NE(first.waypoints, plan(checker, kLeft, {kRight}, params).waypoints);
}

TEST(MotionPlanner, ShortcutsNeverLengthen) {
  auto checker = checker_of(posts());
  double before = 0;
  double after = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    PlannerParams params;
    params.seed = seed;
    params.shortcut_rounds = 0;
    const double raw = plan(checker, kLeft, {kRight}, params).length_rad;
    params.shortcut_rounds = 40;
    const double cut = plan(checker, kLeft, {kRight}, params).length_rad;
    EXPECT_LE(cut, raw + 1e-9);
    before += raw;
    after += cut;
  }
  EXPECT_LT(after, before);
}

// Every planner by its name. PRM* and the informed trees ask for many states before the first edge.
TEST(MotionPlanner, EveryPlannerFindsAFreePath) {
  for (const auto& name : planner_names()) {
    auto checker = checker_of(posts());
    PlannerParams params;
    params.planner = name;
    params.timeout_s = 20;
    const auto result = plan(checker, kLeft, {joints(3, 0, 0), kRight}, params);
    ASSERT_EQ(result.code, PlanCode::kSuccess) << name << ": " << result.message;
    EXPECT_EQ(result.goal, 1) << name;
    EXPECT_LT((result.waypoints.front() - kLeft).norm(), 1e-12) << name;
    EXPECT_LT((result.waypoints.back() - kRight).norm(), 1e-12) << name;
    EXPECT_TRUE(free_all_along(checker, result.waypoints)) << name;
  }
}

// A planner of OMPL and our own in one team, for the first path and for the best of several.
TEST(MotionPlanner, PlannersOfOmplJoinATeam) {
  auto checker = checker_of(posts());
  PlanningTeamParams params;
  params.members = {{"lbkpiece", 1}, {"rrt_connect", 1}, {"ompl_rrt_connect", 1}};
  params.threads = 3;
  PlanningTeam team(checker, params);
  for (const TeamEffort& effort : {TeamEffort{20, false}, TeamEffort{20, true, 6}}) {
    const auto result = team.plan({kLeft, {kRight}, {}}, effort);
    ASSERT_EQ(result.plan.code, PlanCode::kSuccess) << result.plan.message;
    EXPECT_TRUE(free_all_along(checker, result.plan.waypoints));
    EXPECT_EQ(result.attempts, effort.improve ? 6 : 0);
  }
}

// Without shortcuts: what is gained is the planner's own doing.
TEST(MotionPlanner, PlannersThatImproveUseTheTime) {
  double first = 0;
  double best = 0;
  for (const char* name : {"abit_star", "ait_star", "bit_star", "prm_star"}) {
    auto checker = checker_of(posts());
    PlannerParams params;
    params.planner = name;
    params.timeout_s = 20;
    params.shortcut_rounds = 0;
    first += plan(checker, kLeft, {kRight}, params).length_rad;
    PlanningTeamParams team;
    team.members = {{name, 1}};
    team.threads = 1;
    team.planner = params;
    const Stopwatch watch;
    const auto result = PlanningTeam(checker, team).plan({kLeft, {kRight}, {}}, {0.5, true});
    EXPECT_GE(watch.seconds(), 0.5) << name;
    ASSERT_EQ(result.plan.code, PlanCode::kSuccess) << name << ": " << result.plan.message;
    EXPECT_TRUE(free_all_along(checker, result.plan.waypoints)) << name;
    EXPECT_EQ(result.attempts, 1) << name << ": it must not start over";
    best += result.cost;
  }
  EXPECT_LT(best, 0.9 * first);
}

TEST(MotionPlanner, OthersStartOverBesideAPlannerThatImproves) {
  auto checker = checker_of(posts());
  PlanningTeamParams params;
  params.members = {{"bit_star", 1}, {"rrt_connect", 1}};
  params.threads = 2;
  const auto result = PlanningTeam(checker, params).plan({kLeft, {kRight}, {}}, {0.3, true});
  ASSERT_EQ(result.plan.code, PlanCode::kSuccess) << result.plan.message;
  EXPECT_GT(result.attempts, 3);
  EXPECT_GT(result.found, 2);
}

TEST(MotionPlanner, EveryPlannerEndsInTime) {
  for (const auto& name : planner_names()) {
    auto checker = checker_of(posts());
    PlannerParams params;
    params.planner = name;
    int asked = 0;
    const auto result = MotionPlanner(checker, params).plan({kLeft, {kRight}, [&] { return ++asked >= 2; }});
    EXPECT_EQ(result.code, PlanCode::kCancelled) << name;
  }
}

TEST(MotionPlanner, TakesAnyGoalThatIsFree) {
  auto checker = checker_of(world_of({post("post", 0.75, 0.0)}));
  const auto result = plan(checker, kLeft, {joints(0, 0, 0), joints(9, 0, 0), joints(1.4, 0.2, 0.1)});
  ASSERT_EQ(result.code, PlanCode::kSuccess);
  EXPECT_EQ(result.goal, 2);
}

TEST(MotionPlanner, SaysWhatIsWrongWithTheStart) {
  auto checker = checker_of(world_of({post("crate", 0.75, 0.0)}));
  const auto touching = plan(checker, joints(0, 0, 0), {kLeft});
  EXPECT_EQ(touching.code, PlanCode::kStartInCollision);
  EXPECT_NE(touching.message.find("crate"), std::string::npos) << touching.message;
  const auto beyond = plan(checker, joints(0, 2.9, 0), {kLeft});
  EXPECT_EQ(beyond.code, PlanCode::kStartOutsideLimits);
  EXPECT_NE(beyond.message.find("j2"), std::string::npos) << beyond.message;
}

TEST(MotionPlanner, MovesAStartOntoItsLimits) {
  auto checker = checker_of({});
  const auto result = plan(checker, joints(2.82, 0, 0), {kLeft});
  ASSERT_EQ(result.code, PlanCode::kSuccess);
  EXPECT_DOUBLE_EQ(result.waypoints.front()[0], 2.8);
}

TEST(MotionPlanner, SaysWhatIsWrongWithTheGoals) {
  auto checker = checker_of(world_of({post("crate", 0.75, 0.0)}));
  const auto touching = plan(checker, kLeft, {joints(3, 0, 0), joints(0, 0, 0)});
  EXPECT_EQ(touching.code, PlanCode::kGoalInCollision);
  EXPECT_NE(touching.message.find("crate"), std::string::npos) << touching.message;
  const auto beyond = plan(checker, kLeft, {joints(0, 0, -2.9)});
  EXPECT_EQ(beyond.code, PlanCode::kGoalOutsideLimits);
  EXPECT_NE(beyond.message.find("j3"), std::string::npos) << beyond.message;
}

TEST(MotionPlanner, RefusesWhatIsNoRequest) {
  auto checker = checker_of({});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(plan(checker, kLeft, {}).code, PlanCode::kInvalidRequest);
  EXPECT_EQ(plan(checker, joints(nan, 0, 0), {kLeft}).code, PlanCode::kInvalidRequest);
  EXPECT_EQ(plan(checker, kLeft, {joints(0, nan, 0)}).code, PlanCode::kInvalidRequest);
  EXPECT_EQ(plan(checker, JointVector::Zero(2), {kLeft}).code, PlanCode::kInvalidRequest);
}

// The goal is inside a ring of posts that no arm can enter.
TEST(MotionPlanner, EndsInTimeWhereThereIsNoPath) {
  auto checker =
      checker_of(world_of({post("a", 0.8, 0.28, 0.3), post("b", 0.8, -0.28, 0.3), post("c", 0.25, 0.35, 0.3),
                           post("d", 0.25, -0.35, 0.3), post("e", -0.35, 0.0, 0.3)}));
  ASSERT_TRUE(checker.is_free(joints(0, 0, 0)));
  const auto outside = joints(1.57, 0, 0);
  ASSERT_TRUE(checker.is_free(outside));
  PlannerParams params;
  params.timeout_s = 0.3;
  const Stopwatch watch;
  const auto result = plan(checker, outside, {joints(0, 0, 0)}, params);
  EXPECT_EQ(result.code, PlanCode::kTimeout);
  EXPECT_LT(watch.seconds(), 5.0);
  EXPECT_TRUE(result.waypoints.empty());
}

TEST(MotionPlanner, StopsAtOnceWhenCancelled) {
  auto checker = checker_of(posts());
  int asked = 0;
  const auto result = MotionPlanner(checker, {}).plan({kLeft, {kRight}, [&] { return ++asked >= 2; }});
  EXPECT_EQ(result.code, PlanCode::kCancelled);
  EXPECT_TRUE(result.waypoints.empty());
}

TEST(MotionPlanner, RefusesBadParameters) {
  auto checker = checker_of({});
  PlannerParams params;
  params.planner = "rrtconnect";
  EXPECT_THROW(MotionPlanner(checker, params), std::invalid_argument);
  params = {};
  params.range_rad = 0;
  EXPECT_THROW(MotionPlanner(checker, params), std::invalid_argument);
  params = {};
  params.timeout_s = 0;
  EXPECT_THROW(MotionPlanner(checker, params), std::invalid_argument);
  params = {};
  params.shortcut_rounds = -1;
  EXPECT_THROW(MotionPlanner(checker, params), std::invalid_argument);
}

}  // namespace
}  // namespace extperfc::arm
