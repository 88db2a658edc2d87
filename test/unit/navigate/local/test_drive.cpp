// Closed loops in generated buildings: a base with delay and noise, a lidar, a rolling cost map.

#include <optional>

#include <gtest/gtest.h>

#include "test/support/drive_simulation.hpp"

namespace extperfc::navigate {
namespace {

MppiParams params_of(BaseKind base) {
  MppiParams params;
  params.base = base;
  if (base == BaseKind::kDifferential) params.limits.max_vy_m_s = 0;
  return params;
}

/// A building with a route through it.
struct Trip {
  Building building;
  Path path;
};

std::optional<Trip> trip(std::uint64_t seed) {
  Trip trip{BuildingGenerator(seed).make(), {}};
  CostGrid grid = rasterized(trip.building, 0.05);
  grid.may_hold_unknown = false;
  inflate(grid, {chassis().inscribed_radius_m(), 1.0, 5});
  GridRoute route(grid);
  Rng rng(seed);
  const Eigen::Vector2d& size = trip.building.size_m;
  for (int attempt = 0; attempt < 200; ++attempt) {
    const Eigen::Vector2d start(rng.uniform(0.7, size.x() - 0.7), rng.uniform(0.7, size.y() - 0.7));
    const Eigen::Vector2d goal(rng.uniform(0.7, size.x() - 0.7), rng.uniform(0.7, size.y() - 0.7));
    if ((start - goal).norm() < 4) continue;
    if (auto path = route.plan(chassis(), start, goal)) {
      trip.path = std::move(*path);
      return trip;
    }
  }
  return std::nullopt;
}

void expect_good_drive(const DriveResult& result, std::uint64_t seed) {
  EXPECT_TRUE(result.reached) << seed;
  EXPECT_EQ(result.contacts, 0) << seed;
  EXPECT_LT(result.driven_m, 1.1 * result.planned_m + 0.1) << seed;
  EXPECT_LT(result.swing_m, 0.1) << seed;
}

TEST(Drive, ReachesGoalsInBuildingsWithoutContacts) {
  for (const BaseKind base : {BaseKind::kHolonomic, BaseKind::kDifferential}) {
    double driven_m = 0;
    double time_s = 0;
    for (std::uint64_t seed = 21; seed < 23; ++seed) {
      const auto planned = trip(seed);
      ASSERT_TRUE(planned) << seed;
      DriveSimulation simulation(planned->building, chassis(), {}, seed);
      const auto planner = make_mppi_planner(params_of(base));
      const DriveResult result = simulation.drive(*planner, planned->path, {}, planned->path.poses.front());
      expect_good_drive(result, seed);
      driven_m += result.mean_speed_m_s * result.time_s;
      time_s += result.time_s;
    }
    EXPECT_GT(driven_m / time_s, 0.4);
  }
}

/// A wall across a hall with a door of 0.9 m.
Building hall_with_door() {
  Building building;
  building.size_m = {8, 5};
  building.enclose();
  building.add(3.94, 0.1, 4.06, 2.08);
  building.add(3.94, 2.98, 4.06, 4.9);
  return building;
}

Path through_door() {
  return straight_path({1.5, 2.53, 0}, 5);
}

TEST(Drive, PassesANarrowDoorSlowly) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    DriveSimulation simulation(hall_with_door(), chassis(), {}, seed);
    const auto planner = make_mppi_planner({});
    expect_good_drive(simulation.drive(*planner, through_door(), {}, {1.5, 2.53, 0}), seed);
  }
}

TEST(Drive, AClosedDoorBlocks) {
  Building building = hall_with_door();
  building.add(3.97, 2.08, 4.03, 2.98);
  DriveSimulation simulation(building, chassis(), {}, 1);
  const auto planner = make_mppi_planner({});
  const DriveResult result = simulation.drive(*planner, through_door(), {}, {1.5, 2.53, 0});
  EXPECT_TRUE(result.blocked);
  EXPECT_EQ(result.contacts, 0);
  EXPECT_LT(result.time_s, 15);
}

TEST(Drive, LetsPeopleCross) {
  Building hall;
  hall.size_m = {10, 6};
  hall.add(0, 0, 10, 0.1);
  hall.add(0, 5.9, 10, 6);
  const Path path = straight_path({1.5, 3, 0}, 7);
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    DriveSimulation simulation(hall, chassis(), {}, seed);
    Rng rng(seed);
    for (const double x : {3.5, 5.5, 7.0}) {
      Pedestrian person;
      person.route_m = {{x, 0.6}, {x + rng.uniform(-0.5, 0.5), 5.4}};
      person.speed_m_s = rng.uniform(0.5, 1.2);
      simulation.people.push_back(person);
    }
    const auto planner = make_mppi_planner({});
    const DriveResult result = simulation.drive(*planner, path, {}, path.poses.front());
    EXPECT_TRUE(result.reached) << seed;
    EXPECT_EQ(result.person_contacts, 0) << seed;
    EXPECT_EQ(result.contacts, 0) << seed;
  }
}

/// The office's corridor, the robot in its middle and a person at its wall: they fit beside each
/// other, closely.
struct Corridor {
  Building building;
  Path path{straight_path({1.5, 1.0, 0}, 8)};

  Corridor() {
    building.size_m = {12, 2.2};
    building.add(0, 0, 12, 0.1);
    building.add(0, 2.1, 12, 2.2);
  }
};

void expect_to_pass(const Pedestrian& person) {
  const Corridor corridor;
  DriveOptions options;
  options.max_time_s = 25;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    DriveSimulation simulation(corridor.building, chassis(), options, seed);
    simulation.people = {person};
    const auto planner = make_mppi_planner({});
    const DriveResult result = simulation.drive(*planner, corridor.path, {}, corridor.path.poses.front());
    EXPECT_TRUE(result.reached) << seed;
    EXPECT_EQ(result.person_contacts, 0) << seed;
    EXPECT_EQ(result.contacts, 0) << seed;
  }
}

TEST(Drive, PassesWhoStandsInACorridor) {
  Pedestrian person;
  person.route_m = {{5.5, 1.6}, {5.6, 1.6}};
  person.speed_m_s = 1e-6;
  expect_to_pass(person);
}

TEST(Drive, PassesWhoComesAlongACorridor) {
  Pedestrian person;
  person.route_m = {{10.5, 1.6}, {1.0, 1.6}};
  person.speed_m_s = 0.7;
  expect_to_pass(person);
}

/// How far a base at rest goes back within 3 s before a person who stands on its path.
double ground_given_m(double person_x_m) {
  const auto planner = make_mppi_planner({});
  planner->set_path(straight_path({}, 4), {});
  const CostGrid costs = make_cost_grid(240, 240, 0.05, {-6, -6}, kFreeCost);
  LocalState state;
  state.people = {{{person_x_m, 0}, {0, 0}, 0.25}};
  double back_m = 0;
  for (int i = 0; i < 60; ++i) {
    const auto command = planner->command(costs, chassis(), state, 0.05, false);
    EXPECT_TRUE(command) << command.error().message;
    state.velocity = command->velocity;
    state.pose = advance(state.pose, command->velocity, 0.05);
    back_m = std::max(back_m, -state.pose.x);
  }
  return back_m;
}

TEST(Drive, DoesNotGiveGroundToWhoStandsBeforeIt) {
  for (const double person_x_m : {0.85, 0.95, 1.05})
    EXPECT_LT(ground_given_m(person_x_m), 0.05) << person_x_m;
}

/// How far a base at rest in a narrow corridor goes back before a person who comes along it and stops a metre
/// before the base's middle, whose velocity is known half a second late.
double ground_given_to_who_comes_m(double speed_m_s) {
  const auto planner = make_mppi_planner({});
  planner->set_path(straight_path({}, 6), {});
  CostGrid costs = make_cost_grid(240, 240, 0.05, {-6, -6}, kFreeCost);
  for (int column = 0; column < 240; ++column)
    for (const double wall_m : {-0.8, 0.8})
      costs.at({column, costs.cell_around({0, wall_m}).row}) = kLethalCost;
  LocalState state;
  state.people = {{{4, 0}, {-speed_m_s, 0}, 0.25}};
  MovingObstacle& person = state.people.front();
  double back_m = 0;
  for (int i = 0; i < 240; ++i) {
    const bool waits = (person.position_m - Eigen::Vector2d(state.pose.x, state.pose.y)).norm() < 1;
    if (!waits) person.position_m.x() -= 0.05 * speed_m_s;
    person.velocity_m_s.x() += 0.1 * ((waits ? 0 : -speed_m_s) - person.velocity_m_s.x());
    const auto command = planner->command(costs, chassis(), state, 0.05, false);
    EXPECT_TRUE(command) << command.error().message;
    state.velocity = command->velocity;
    const double before_m = state.pose.x;
    state.pose = advance(state.pose, command->velocity, 0.05);
    back_m += std::max(0.0, before_m - state.pose.x);
  }
  return back_m;
}

TEST(Drive, DoesNotGiveGroundToWhoComes) {
  for (const double speed_m_s : {0.3, 0.6, 0.9})
    EXPECT_LT(ground_given_to_who_comes_m(speed_m_s), 0.15) << speed_m_s;
}

}  // namespace
}  // namespace extperfc::navigate
