// Where a robot lets a person pass.
#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/navigate/yield_place.hpp"

#include "test/support/building.hpp"
#include "test/support/grid_route.hpp"

namespace extperfc::navigate {
namespace {

Footprint base() {
  return *Footprint::make({{0.4, 0.3}, {-0.4, 0.3}, {-0.4, -0.3}, {0.4, -0.3}});
}

/// With the costs that a robot of base() has around obstacles.
CostGrid inflated(const Building& building) {
  CostGrid grid = rasterized(building, 0.05);
  inflate(grid, {base().inscribed_radius_m(), 0.8, 4});
  return grid;
}

/// A corridor of 12 x 1.4 m along x between walls, at y from 4 to 5.4.
Building corridor() {
  Building building;
  building.size_m = {12, 8};
  building.add(0, 5.4, 12, 8);
  return building;
}

/// Below the corridor, x from 4 to 8, with a door from 5 to `door_end_m`.
void add_room(Building& building, double door_end_m) {
  building.add(0, 3.9, 5.0, 4.0);
  building.add(door_end_m, 3.9, 12, 4.0);
  building.add(4, 0, 8, 0.1);
  building.add(4, 0, 4.1, 4);
  building.add(8, 0, 8.1, 4);
}

double off_corridor_m(const Pose2& pose) {
  return 4 - pose.y;
}

TEST(YieldPlace, IntoTheRoomBehindIt) {
  Building building = corridor();
  add_room(building, 6.1);
  const CostGrid grid = inflated(building);
  const Pose2 start{8.5, 4.7, 0};
  const auto place = yield_place(grid, base(), start, {9.6, 4.7});
  ASSERT_TRUE(place);
  EXPECT_EQ(contact(grid, base(), *place), Contact::kFree);
  EXPECT_GT(off_corridor_m(*place), 0.3);
}

/// 1.9 m wide: who keeps 1.1 m from a robot at the wall would have to walk along the other one.
TEST(YieldPlace, IntoTheRoomAlsoWhereTheCorridorIsWide) {
  Building building;
  building.size_m = {12, 8};
  building.add(0, 5.9, 12, 8);
  add_room(building, 6.0);
  const CostGrid grid = inflated(building);
  const auto place = yield_place(grid, base(), {7.5, 5.2, 0}, {8.6, 5.0});
  ASSERT_TRUE(place);
  EXPECT_EQ(contact(grid, base(), *place), Contact::kFree);
  EXPECT_GT(off_corridor_m(*place), 0);
}

TEST(YieldPlace, NeverPastThePerson) {
  Building building = corridor();
  building.add(0, 3.9, 8.0, 4.0);
  building.add(9.1, 3.9, 12, 4.0);  // the only door is behind the person
  const CostGrid grid = inflated(building);
  EXPECT_FALSE(yield_place(grid, base(), {5.5, 4.7, 0}, {6.6, 4.7}));
}

TEST(YieldPlace, ACorridorWithoutAnythingBesideItHasNoPlace) {
  Building building = corridor();
  building.add(0, 3.9, 12, 4.0);
  const CostGrid grid = inflated(building);
  EXPECT_FALSE(yield_place(grid, base(), {5.5, 4.7, 0}, {6.6, 4.7}));
}

TEST(YieldPlace, InAWideRoomAStepAside) {
  Building building;
  building.size_m = {12, 8};
  building.enclose();
  const CostGrid grid = inflated(building);
  const Pose2 start{6, 4, 0.3};
  const auto place = yield_place(grid, base(), start, {7, 4});
  ASSERT_TRUE(place);
  EXPECT_LT(distance_m(*place, start), 2.5);
  EXPECT_GT(distance_m(*place, start), kYieldM - 0.01);
}

TEST(YieldPlace, NothingForWhatIsNotOnTheMap) {
  const CostGrid grid = inflated(corridor());
  EXPECT_FALSE(yield_place(grid, base(), {-5, 4.7, 0}, {6.6, 4.7}));
  EXPECT_FALSE(yield_place(grid, base(), {NAN, 4.7, 0}, {6.6, 4.7}));
  EXPECT_FALSE(yield_place(grid, base(), {5, 4.7, 0}, {NAN, 4.7}));
}

}  // namespace
}  // namespace extperfc::navigate
