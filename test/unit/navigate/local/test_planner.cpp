#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "extperfc/navigate/local_planner.hpp"

#include "test/support/drive_simulation.hpp"

namespace extperfc::navigate {
namespace {

CostGrid empty_grid() {
  CostGrid grid = make_cost_grid(200, 120, 0.05, {-2, -3}, kFreeCost);
  grid.may_hold_unknown = false;
  return grid;
}

MppiParams differential() {
  MppiParams params;
  params.base = BaseKind::kDifferential;
  params.limits.max_vy_m_s = 0;
  return params;
}

/// Commands come true at once.
struct Ideal {
  CostGrid costs = empty_grid();
  LocalState state;
  double time_s{0};
  double fastest_m_s{0};

  bool run(LocalPlanner& planner, double until_s) {
    for (; time_s < until_s; time_s += 0.05) {
      const auto command = planner.command(costs, chassis(), state, 0.05, false);
      if (!command) return false;
      if (command->at_goal) return true;
      state.velocity = command->velocity;
      state.pose = advance(state.pose, state.velocity, 0.05);
      fastest_m_s = std::max(fastest_m_s, std::hypot(state.velocity.vx, state.velocity.vy));
    }
    return false;
  }
};

TEST(MppiPlanner, RefusesParametersOutOfTheirRange) {
  const auto refused = [](auto change) {
    MppiParams params;
    change(params);
    EXPECT_THROW((void)make_mppi_planner(params), std::invalid_argument);
  };
  refused([](MppiParams& p) { p.samples = 0; });
  refused([](MppiParams& p) { p.temperature = 0; });
  refused([](MppiParams& p) { p.limits.max_vx_m_s = -1; });
  refused([](MppiParams& p) { p.horizon_s = NAN; });
  refused([](MppiParams& p) { p.base = BaseKind::kDifferential; });  // with a sideways speed
}

TEST(MppiPlanner, RefusesRequestsThatCannotBe) {
  const auto planner = make_mppi_planner({});
  const CostGrid costs = empty_grid();
  LocalState state;
  const auto code = [&](double dt_s) {
    const auto command = planner->command(costs, chassis(), state, dt_s, false);
    return command ? NavCode::kSuccess : command.error().code;
  };
  EXPECT_EQ(code(0.05), NavCode::kInvalidRequest);  // no path
  planner->set_path(straight_path({}, 3), {});
  EXPECT_EQ(code(0.05), NavCode::kSuccess);
  EXPECT_EQ(code(0), NavCode::kInvalidRequest);
  state.pose.x = NAN;
  EXPECT_EQ(code(0.05), NavCode::kInvalidRequest);
  state.pose.x = 0;
  state.people.push_back({{NAN, 0}, {0, 0}, 0.3});
  EXPECT_EQ(code(0.05), NavCode::kInvalidRequest);
  state.people.clear();
  planner->reset();
  EXPECT_EQ(code(0.05), NavCode::kInvalidRequest);
}

TEST(MppiPlanner, DrivesAtFullSpeedAndStopsAtTheGoal) {
  for (const bool holonomic : {true, false}) {
    const auto planner = make_mppi_planner(holonomic ? MppiParams{} : differential());
    planner->set_path(straight_path({}, 5), {});
    Ideal world;
    ASSERT_TRUE(world.run(*planner, 20)) << holonomic;
    EXPECT_LT(world.time_s, 10) << holonomic;
    EXPECT_GT(world.fastest_m_s, 0.75) << holonomic;
    EXPECT_LE(world.fastest_m_s, 0.8 + 1e-6) << holonomic;
    EXPECT_NEAR(world.state.pose.x, 5, 0.08) << holonomic;
    EXPECT_NEAR(world.state.pose.y, 0, 0.08) << holonomic;
    EXPECT_NEAR(world.state.pose.yaw, 0, 0.08) << holonomic;
    const Pose2 there = world.state.pose;
    for (int i = 0; i < 40; ++i) {  // stays
      const auto command = planner->command(world.costs, chassis(), world.state, 0.05, false);
      ASSERT_TRUE(command && command->at_goal) << holonomic;
      EXPECT_EQ(command->velocity.wz, 0) << holonomic;
    }
    EXPECT_EQ(world.state.pose.x, there.x) << holonomic;
  }
}

TEST(MppiPlanner, HonoursThePlannedHeading) {
  Path sideways = straight_path({}, 3);
  for (Pose2& pose : sideways.poses) pose = {0, pose.x - 1.5, 0};
  const auto planner = make_mppi_planner({});
  planner->set_path(sideways, {});
  Ideal world;
  world.state.pose = {0, -1.5, 0};
  double largest_yaw = 0;
  while (world.time_s < 20 && !world.run(*planner, world.time_s + 0.05))
    largest_yaw = std::max(largest_yaw, std::abs(world.state.pose.yaw));
  EXPECT_LT(world.time_s, 15);
  EXPECT_LT(largest_yaw, 0.1);
}

TEST(MppiPlanner, SpeedZonesSlow) {
  const auto planner = make_mppi_planner({});
  planner->set_path(straight_path({}, 3), {});
  Ideal world;
  world.state.speed_factor = 0.4;
  EXPECT_TRUE(world.run(*planner, 20));
  EXPECT_LE(world.fastest_m_s, 0.4 * 0.8 + 1e-6);
}

TEST(MppiPlanner, ACommandIsRepeatable) {
  const auto first = make_mppi_planner({});
  const auto second = make_mppi_planner({});
  for (LocalPlanner* planner : {first.get(), second.get()}) planner->set_path(straight_path({}, 3), {});
  Ideal a;
  Ideal b;
  (void)a.run(*first, 3);
  (void)b.run(*second, 3);
  EXPECT_EQ(a.state.pose.x, b.state.pose.x);
  EXPECT_EQ(a.state.pose.y, b.state.pose.y);
}

TEST(MppiPlanner, AClosedDoorwayIsBlocked) {
  const auto planner = make_mppi_planner({});
  planner->set_path(straight_path({}, 5), {});
  Ideal world;
  for (int row = 0; row < world.costs.height; ++row)
    for (int column = 80; column < 83; ++column) world.costs.at({column, row}) = kLethalCost;  // x = 2.0 m
  EXPECT_FALSE(world.run(*planner, 20));
  EXPECT_LT(world.time_s, 10);
  EXPECT_GT(world.state.pose.x, 1.0);  // up to it
  EXPECT_EQ(contact(world.costs, chassis(), world.state.pose), Contact::kFree);
  const auto command = planner->command(world.costs, chassis(), world.state, 0.05, false);
  ASSERT_FALSE(command);
  EXPECT_EQ(command.error().code, NavCode::kBlocked);
  EXPECT_FALSE(command.error().message.empty());
}

// A door whose cells leave 4 cm less than the footprint is passed all the same, but not beside a person, who
// will walk on.
TEST(MppiPlanner, DoesNotSqueezeThroughADoorBesideAPerson) {
  for (const bool beside : {false, true}) {
    const auto planner = make_mppi_planner({});
    Ideal world;
    world.state.pose.y = 0.025;
    planner->set_path(straight_path(world.state.pose, 5), {});
    for (int row = 0; row < world.costs.height; ++row)
      for (int column = 80; column < 83; ++column)
        if (row < 53 || row > 67) world.costs.at({column, row}) = kLethalCost;
    if (beside) world.state.people.push_back({{1.3, 1.3}, {0, 0}, 0.3});
    EXPECT_EQ(world.run(*planner, 30), !beside);
    EXPECT_EQ(world.state.pose.x + 0.4064 < 2.05, beside);
  }
}

TEST(MppiPlanner, UnknownSpaceIsNotFree) {
  const auto planner = make_mppi_planner({});
  planner->set_path(straight_path({}, 5), {});
  Ideal world;
  world.costs.may_hold_unknown = true;
  for (int row = 0; row < world.costs.height; ++row)
    for (int column = 80; column < 200; ++column) world.costs.at({column, row}) = kUnknownCost;
  EXPECT_FALSE(world.run(*planner, 20));
  EXPECT_EQ(contact(world.costs, chassis(), world.state.pose), Contact::kFree);
}

TEST(MppiPlanner, ComesOutOfAnObstacle) {
  const auto planner = make_mppi_planner({});
  planner->set_path(straight_path({}, 4), {});
  Ideal world;
  for (int row = 55; row < 65; ++row) world.costs.at({35, row}) = kLethalCost;  // 0.15 m inside its rear
  ASSERT_EQ(contact(world.costs, chassis(), world.state.pose), Contact::kObstacle);
  EXPECT_TRUE(world.run(*planner, 20));
}

TEST(MppiPlanner, StopsForAPersonWhoStandsOnThePath) {
  const auto planner = make_mppi_planner({});
  planner->set_path(straight_path({}, 5), {});
  Ideal world;
  world.state.people.push_back({{2.5, 0}, {0, 0}, 0.3});
  for (int column = 0; column < 200; ++column)  // a corridor that leaves no space beside
    for (const int row : {45, 75}) world.costs.at({column, row}) = kLethalCost;
  EXPECT_FALSE(world.run(*planner, 20));
  EXPECT_LT(world.state.pose.x + 0.4064, 2.2);
}

TEST(MppiPlanner, DrivesAwayFromAPersonWhoStandsTooNear) {
  const auto planner = make_mppi_planner({});
  planner->set_path(straight_path({}, 3), {});
  Ideal world;
  world.state.people.push_back({{-0.7, 0}, {0, 0}, 0.3});  // 0.29 m behind its rear
  EXPECT_TRUE(world.run(*planner, 20));
  world.state.pose = {};
  planner->set_path(straight_path({}, 3), {});
  world.state.people[0].position_m = {0.7, 0};  // before it
  world.state.people.push_back({{0, 0.75}, {0, 0}, 0.3});
  world.state.people.push_back({{0, -0.75}, {0, 0}, 0.3});
  EXPECT_FALSE(world.run(*planner, 5));
  EXPECT_LT(world.state.pose.x, 0.05);
}

TEST(MppiPlanner, ShowsCandidatesOnlyWhenWanted) {
  const auto planner = make_mppi_planner({});
  planner->set_path(straight_path({}, 5), {});
  const CostGrid costs = empty_grid();
  const auto with = planner->command(costs, chassis(), {}, 0.05, true);
  ASSERT_TRUE(with);
  EXPECT_FALSE(with->candidates.empty());
  EXPECT_GT(with->trajectory.size(), 1U);
  EXPECT_TRUE(planner->command(costs, chassis(), {}, 0.05, false)->candidates.empty());
}

}  // namespace
}  // namespace extperfc::navigate
