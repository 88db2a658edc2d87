#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/arm/inverse_kinematics.hpp"
#include "extperfc/base/stopwatch.hpp"

#include "test/unit/arm/constrained/level_arm.hpp"

namespace extperfc::arm {
namespace {

using test::along;
using test::both_arms;
using test::constraint_on;
using test::left_arm;
using test::random_level_state;
using Kind = ToolConstraintKind;

WorldObject box(const std::string& name, const Eigen::Vector3d& centre_m, const Eigen::Vector3d& size_m) {
  WorldObject object;
  object.name = name;
  object.shapes.push_back({Box{size_m}, Pose::Identity(), {}});
  object.root_T_object = make_pose(centre_m);
  return object;
}

/// Boxes at random places in front of the robot.
CollisionWorld random_boxes(Rng& rng, int count) {
  CollisionWorld world;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d centre(rng.uniform(0.6, 1.1), rng.uniform(-0.4, 1.0), rng.uniform(0.6, 1.3));
    const Eigen::Vector3d size(rng.uniform(0.05, 0.2), rng.uniform(0.05, 0.2), rng.uniform(0.05, 0.3));
    test::must(world.add(box("box_" + std::to_string(i), centre, size)));
  }
  return world;
}

/// The left arm with a level tool among random boxes, with a start and a goal.
struct Problem {
  explicit Problem(std::uint64_t seed, int boxes = 5)
      : rng(seed),
        checker(CollisionChecker::make(left_arm(), random_boxes(rng, boxes)).value()),
        constraint(constraint_on(left_arm(), {test::level()})),
        start(random_level_state(constraint, checker, rng)),
        goal(random_level_state(constraint, checker, rng)) {}

  ConstrainedPlanResult plan(const ConstrainedPlannerParams& params = {}) {
    return ConstrainedPlanner(checker, constraint, params).plan({start, {goal}, {}});
  }

  Rng rng;
  CollisionChecker checker;
  PathConstraint constraint;
  JointVector start, goal;
};

JointVector moved(const JointVector& state, Eigen::Index joint, double by_rad) {
  return state + by_rad * JointVector::Unit(state.size(), joint);
}

double worst_tilt_rad(const std::vector<JointVector>& path) {
  double worst = 0;
  along(path, 0.001,
        [&](const JointVector& state) { worst = std::max(worst, test::tilt_rad(left_arm(), state)); });
  return worst;
}

TEST(ConstrainedPlanner, KeepsTheConstraintAndTouchesNothing) {
  int solved = 0;
  int beyond_direct = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Problem problem(seed);
    const auto result = problem.plan();
    if (result.code != PlanCode::kSuccess) continue;
    ++solved;
    beyond_direct += result.states > 0;
    EXPECT_EQ(result.waypoints.front(), problem.start);
    EXPECT_EQ(result.waypoints.back(), problem.goal);
    EXPECT_LE(result.error_bound, 5e-5);
    EXPECT_LE(worst_tilt_rad(result.waypoints), result.error_bound + 1e-9) << "seed " << seed;
    EXPECT_TRUE(test::free_all_along(problem.checker, result.waypoints)) << "seed " << seed;
    for (const auto& state : result.waypoints)
      EXPECT_TRUE((state.array() >= left_arm().limits().lower.array()).all() &&
                  (state.array() <= left_arm().limits().upper.array()).all());
  }
  EXPECT_GE(solved, 10);  // random states need not be connected
  EXPECT_GE(beyond_direct, 3);
}

TEST(ConstrainedPlanner, ATighterToleranceIsKeptToo) {
  Problem problem(2);
  ConstrainedPlannerParams params;
  params.tolerance = 2e-6;
  const auto result = problem.plan(params);
  ASSERT_EQ(result.code, PlanCode::kSuccess) << result.message;
  EXPECT_LE(result.error_bound, 2e-6);
  EXPECT_LE(worst_tilt_rad(result.waypoints), 2e-6 + 1e-9);
}

// Near enough that OMPL finds them soon; boxes stand elsewhere.
TEST(ConstrainedPlanner, EveryPlannerFindsAPathThatHolds) {
  for (const auto& name : constrained_planner_names()) {
    Problem problem(3, 2);
    JointVector shift(7);
    shift << 0.3, 0.2, -0.2, 0.2, 0.1, 0.0, 0.4;
    const auto near = problem.constraint.project(problem.start + shift, left_arm().limits());
    ASSERT_TRUE(near.has_value());
    ASSERT_TRUE(problem.checker.is_free(*near));
    problem.goal = *near;
    ConstrainedPlannerParams params;
    params.planner = name;
    params.timeout_s = 20;
    const auto result = problem.plan(params);
    ASSERT_EQ(result.code, PlanCode::kSuccess) << name << ": " << result.message;
    EXPECT_EQ(result.waypoints.front(), problem.start) << name;
    EXPECT_EQ(result.waypoints.back(), problem.goal) << name;
    EXPECT_LE(worst_tilt_rad(result.waypoints), 5e-5) << name;
    EXPECT_TRUE(test::free_all_along(problem.checker, result.waypoints)) << name;
  }
}

TEST(ConstrainedPlanner, TheSameSeedGivesTheSamePath) {
  Problem problem(2);
  Problem again(2);
  ConstrainedPlannerParams params;
  const auto first = problem.plan(params);
  ASSERT_EQ(first.code, PlanCode::kSuccess);
  ASSERT_GT(first.states, 0) << "the problem should need the trees";
  EXPECT_EQ(first.waypoints, again.plan(params).waypoints);
  params.seed = 2;
  EXPECT_NE(first.waypoints, problem.plan(params).waypoints);
}

TEST(ConstrainedPlanner, ShortcutsNeverLengthen) {
  double before = 0, after = 0;
  for (std::uint64_t seed = 2; seed <= 4; ++seed) {
    Problem problem(seed);
    ConstrainedPlannerParams params;
    params.shortcut_rounds = 0;
    const auto raw = problem.plan(params);
    params.shortcut_rounds = 40;
    const auto cut = problem.plan(params);
    if (raw.code != PlanCode::kSuccess || cut.code != PlanCode::kSuccess) continue;
    EXPECT_LE(cut.length_rad, raw.length_rad + 1e-9);
    before += raw.length_rad;
    after += cut.length_rad;
  }
  EXPECT_LT(after, before);
}

// Both hands hold a box of 0.3 m between their palms; it is moved and turned without being stretched.
class BothHands : public ::testing::Test {
 protected:
  /// Joint values near `from` with the hands at both sides of a box, whose frame has y to the left. Near,
  /// since a closed chain cannot go from one posture of an elbow to every other.
  JointVector holding(const Pose& root_T_box, const JointVector& from) {
    JointVector state(14);
    for (const std::string side : {"left", "right"}) {
      const double sign = side == "left" ? 1.0 : -1.0;
      Pose box_T_hand = Pose::Identity();
      box_T_hand.translation().y() = sign * 0.3;
      box_T_hand.linear() << 0, -sign, 0, 0, 0, -sign, 1, 0, 0;
      const auto chain = ArmChain::make(test::baxter(), root_, side + "_gripper").value();
      IkOptions options;
      options.timeout_s = 10;
      options.objective = IkObjective::kNearSeed;
      const auto& names = both_arms().joint_names();
      const auto index_of = [&](int j) {
        const auto& name = chain.joint_names()[static_cast<std::size_t>(j)];
        return std::find(names.begin(), names.end(), name) - names.begin();
      };
      JointVector seed(7);
      for (int j = 0; j < 7; ++j) seed[j] = from[index_of(j)];
      const auto solution = InverseKinematics(chain).solve(root_T_box * box_T_hand, seed, options);
      if (!solution) throw std::runtime_error(to_string(solution.error().reason));
      for (int j = 0; j < 7; ++j) state[index_of(j)] = solution->joints[j];
    }
    return state;
  }

  Pose torso(const Eigen::Vector3d& xyz, const Eigen::Vector3d& rpy) {
    return *both_arms().link_pose(JointVector::Zero(14), "torso") * make_pose(xyz, rpy);
  }

  std::string root_ = test::baxter().links().front().name;
};

TEST_F(BothHands, CarryABoxAsAClosedChain) {
  const JointVector start = holding(torso({0.5, 0.0, 0.0}, {0, 0, 0}), JointVector::Zero(14));
  const auto constraint = constraint_on(
      both_arms(), {{Kind::kKeepRelative, "right_gripper", "left_gripper", Eigen::Vector3d::UnitZ(), {}}},
      start);
  const auto goal =
      constraint.project(holding(torso({0.5, 0.0, 0.4}, {0, 0, 0.2}), start), both_arms().limits());
  ASSERT_TRUE(goal.has_value());
  CollisionWorld world;
  AttachedObject held{"held", "left_gripper", {{Box{{0.25, 0.25, 0.3}}, Pose::Identity(), {}}}, {}, {}};
  held.link_T_object = make_pose({0, 0, 0.3});
  test::must(world.attach(held));
  auto bar = box("bar", {}, {0.1, 0.1, 0.04});  // between the two places
  bar.root_T_object = torso({0.5, 0.0, 0.2}, {0, 0, 0});
  test::must(world.add(bar));
  auto checker = CollisionChecker::make(both_arms(), world).value();
  ASSERT_TRUE(checker.is_free(start)) << checker.contact(start)->first << checker.contact(start)->second;
  ASSERT_TRUE(checker.is_free(*goal)) << checker.contact(*goal)->first << checker.contact(*goal)->second;
  ConstrainedPlannerParams params;
  params.timeout_s = 60;  // builds with sanitizers are some fifty times slower
  const auto result = ConstrainedPlanner(checker, constraint, params).plan({start, {*goal}, {}});
  ASSERT_EQ(result.code, PlanCode::kSuccess) << result.message;
  EXPECT_GT(result.states, 0) << "the bar should block the path";
  const auto hands = [](const JointVector& state) {
    return Pose(both_arms().link_pose(state, "left_gripper")->inverse() *
                *both_arms().link_pose(state, "right_gripper"));
  };
  const Pose grip = hands(start);
  along(result.waypoints, 0.002, [&](const JointVector& state) {
    const Pose now = hands(state);
    EXPECT_LE((now.translation() - grip.translation()).norm(), 5e-5);
    EXPECT_LE((now.linear() - grip.linear()).norm() / std::sqrt(2.0), 5e-5);
  });
  EXPECT_TRUE(test::free_all_along(checker, result.waypoints));
}

TEST(ConstrainedPlanner, TakesAnyGoalThatIsOfUse) {
  Problem problem(4);
  const JointVector tilted = moved(problem.goal, 5, 0.1);
  const JointVector beyond = moved(problem.goal, 6, 7.0);
  const auto result = ConstrainedPlanner(problem.checker, problem.constraint, {})
                          .plan({problem.start, {tilted, beyond, problem.goal}, {}});
  ASSERT_EQ(result.code, PlanCode::kSuccess) << result.message;
  EXPECT_EQ(result.goal, 2);
}

TEST(ConstrainedPlanner, StayingIsAPath) {
  Problem problem(4);
  problem.goal = problem.start;
  const auto result = problem.plan();
  ASSERT_EQ(result.code, PlanCode::kSuccess) << result.message;
  EXPECT_EQ(result.waypoints.front(), problem.start);
  EXPECT_EQ(result.length_rad, 0.0);
}

// A start that a controller left off by less than the tolerance.
TEST(ConstrainedPlanner, TakesAStartThatIsALittleOff) {
  Problem problem(2);
  problem.start = moved(problem.start, 5, 2e-5);
  ASSERT_GT(problem.constraint.error(problem.start), 1e-6);
  const auto result = problem.plan();
  ASSERT_EQ(result.code, PlanCode::kSuccess) << result.message;
  EXPECT_EQ(result.waypoints.front(), problem.start);
  EXPECT_LE(worst_tilt_rad(result.waypoints), 5e-5);
}

TEST(ConstrainedPlanner, SaysWhatIsWrong) {
  Problem problem(5);
  ConstrainedPlanner planner(problem.checker, problem.constraint, {});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(planner.plan({problem.start, {}, {}}).code, PlanCode::kInvalidRequest);
  EXPECT_EQ(planner.plan({JointVector::Zero(3), {problem.goal}, {}}).code, PlanCode::kInvalidRequest);
  EXPECT_EQ(planner.plan({JointVector::Constant(7, nan), {problem.goal}, {}}).code,
            PlanCode::kInvalidRequest);
  EXPECT_EQ(planner.plan({problem.start, {JointVector::Constant(7, nan)}, {}}).code,
            PlanCode::kInvalidRequest);
  const JointVector tilted = moved(problem.start, 5, 0.01);
  for (const auto& result :
       {planner.plan({tilted, {problem.goal}, {}}), planner.plan({problem.start, {tilted}, {}})}) {
    EXPECT_EQ(result.code, PlanCode::kInvalidRequest);
    EXPECT_EQ(result.violated, 0);
    EXPECT_NE(result.message.find("axis of left_gripper"), std::string::npos) << result.message;
  }
  const JointVector beyond = moved(problem.start, 6, 7.0);
  EXPECT_EQ(planner.plan({beyond, {problem.goal}, {}}).code, PlanCode::kStartOutsideLimits);
  EXPECT_EQ(planner.plan({problem.start, {beyond}, {}}).code, PlanCode::kGoalOutsideLimits);
}

TEST(ConstrainedPlanner, SaysWhatIsTouched) {
  Problem problem(6);
  const Eigen::Vector3d there = left_arm().link_pose(problem.goal, "left_gripper")->translation();
  CollisionWorld world;
  test::must(world.add(box("crate", there, {0.1, 0.1, 0.1})));
  auto checker = CollisionChecker::make(left_arm(), world).value();
  ConstrainedPlanner planner(checker, problem.constraint, {});
  ASSERT_TRUE(checker.is_free(problem.start)) << "the start must not reach into the crate too";
  const auto result = planner.plan({problem.start, {problem.goal}, {}});
  EXPECT_EQ(result.code, PlanCode::kGoalInCollision);
  EXPECT_NE(result.message.find("crate"), std::string::npos) << result.message;
  EXPECT_EQ(planner.plan({problem.goal, {problem.start}, {}}).code, PlanCode::kStartInCollision);
}

TEST(ConstrainedPlanner, StopsWhenCancelled) {
  for (const auto& name : constrained_planner_names()) {
    Problem problem(2);
    ConstrainedPlannerParams params;
    params.planner = name;
    int asked = 0;
    const auto result = ConstrainedPlanner(problem.checker, problem.constraint, params)
                            .plan({problem.start, {problem.goal}, [&] { return ++asked >= 3; }});
    EXPECT_EQ(result.code, PlanCode::kCancelled) << name;
    EXPECT_TRUE(result.waypoints.empty()) << name;
  }
}

// The level tool slides along a line across the robot, on which a plate stands between start and goal.
TEST(ConstrainedPlanner, EndsInTimeWhereThereIsNoPath) {
  Problem problem(1, 0);
  const ToolConstraint line{Kind::kKeepLine, "left_gripper", "", Eigen::Vector3d::UnitY(), {}};
  const auto constraint = constraint_on(left_arm(), {test::level(), line}, problem.start);
  Pose there = *left_arm().link_pose(problem.start, "left_gripper");
  there.translation().y() += 0.4;
  auto place = line;
  place.kind = Kind::kKeepPlane;
  place.target = there;
  const auto goal = constraint_on(left_arm(), {test::level(), line, place}, problem.start)
                        .project(problem.start, left_arm().limits());
  ASSERT_TRUE(goal.has_value());
  there.translation().y() -= 0.2;
  CollisionWorld world;
  test::must(world.add(box("plate", there.translation(), {0.1, 0.01, 0.1})));
  auto checker = CollisionChecker::make(left_arm(), world).value();
  ASSERT_TRUE(checker.is_free(problem.start));
  ASSERT_TRUE(checker.is_free(*goal));
  ConstrainedPlannerParams params;
  params.timeout_s = 0.3;
  const Stopwatch watch;
  const auto result = ConstrainedPlanner(checker, constraint, params).plan({problem.start, {*goal}, {}});
  EXPECT_EQ(result.code, PlanCode::kTimeout);
  EXPECT_LT(watch.seconds(), 3.0);
  auto free = CollisionChecker::make(left_arm(), {}).value();
  EXPECT_EQ(ConstrainedPlanner(free, constraint, params).plan({problem.start, {*goal}, {}}).code,
            PlanCode::kSuccess)
      << "without the plate there is a path";
}

TEST(ConstrainedPlanner, TreesAreBounded) {
  Problem problem(2);
  ConstrainedPlannerParams params;
  params.max_states = 10;
  const auto result = problem.plan(params);
  EXPECT_EQ(result.code, PlanCode::kTimeout);
  EXPECT_LT(result.states, 2000);  // the bound and the edge that passes it
}

TEST(ConstrainedPlanner, RefusesBadParameters) {
  Problem problem(1, 0);
  const auto refuses = [&](auto change) {
    ConstrainedPlannerParams params;
    change(params);
    EXPECT_THROW(ConstrainedPlanner(problem.checker, problem.constraint, params), std::invalid_argument);
  };
  refuses([](auto& params) { params.planner = "rrt_connect"; });
  refuses([](auto& params) { params.tolerance = 0; });
  refuses([](auto& params) { params.range_rad = std::nan(""); });
  refuses([](auto& params) { params.step_rad = 1; });
  refuses([](auto& params) { params.timeout_s = 0; });
  refuses([](auto& params) { params.max_states = 1; });
  refuses([](auto& params) { params.shortcut_rounds = -1; });
  refuses([](auto& params) { params.limit_repair_rad = 1; });
  auto both = CollisionChecker::make(both_arms(), {}).value();
  EXPECT_THROW(ConstrainedPlanner(both, problem.constraint, {}), std::invalid_argument);
}

}  // namespace
}  // namespace extperfc::arm
