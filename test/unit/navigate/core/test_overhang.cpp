// Arms that stick out beyond the chassis.
#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/navigate/overhang.hpp"

namespace extperfc::navigate {
namespace {

// A chassis of 1 x 1 m; an arm of 1 m length that a joint in its middle, 0.8 m above the floor, swings about
// z; a mast of 3 m above it, with a beam on its top.
constexpr const char* kUrdf = R"(<robot name="crane">
  <link name="floor"/>
  <link name="chassis"><collision><origin xyz="0 0 0.25"/><geometry><box size="1 1 0.5"/></geometry></collision></link>
  <joint name="down" type="fixed"><parent link="floor"/><child link="chassis"/></joint>
  <link name="arm"><collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry></collision></link>
  <joint name="swing" type="revolute"><parent link="chassis"/><child link="arm"/><origin xyz="0 0 0.8"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <link name="beam"><collision><geometry><cylinder radius="0.1" length="6"/></geometry></collision></link>
  <joint name="top" type="fixed"><parent link="chassis"/><child link="beam"/>
    <origin xyz="0 0 3" rpy="1.5707963 0 0"/></joint>
</robot>)";

class OverhangTest : public testing::Test {
 protected:
  [[nodiscard]] Eigen::AlignedBox2d extent(double swing_rad, double max_height_m) const {
    const auto overhang = Overhang::make(robot_, "floor", max_height_m);
    Eigen::AlignedBox2d all;
    for (const auto& point : overhang->points({{"swing", swing_rad}}, chassis_)) all.extend(point);
    return all;
  }
  RobotModel robot_{*RobotModel::from_urdf(kUrdf, "/")};
  Footprint chassis_{*Footprint::make({{0.5, 0.5}, {-0.5, 0.5}, {-0.5, -0.5}, {0.5, -0.5}})};
};

TEST_F(OverhangTest, PointsOfTheArmOutsideTheChassis) {
  const auto ahead = extent(0, 2);
  EXPECT_NEAR(ahead.max().x(), 1.0, 1e-6);
  EXPECT_NEAR(ahead.max().y(), 0.05, 1e-6);
  EXPECT_GT(ahead.min().x(), 0.5);
  const auto left = extent(kPi / 2, 2);
  EXPECT_NEAR(left.max().y(), 1.0, 1e-6);
}

TEST_F(OverhangTest, WhatIsHighAboveTheFloorDoesNotCount) {
  EXPECT_TRUE(extent(0, 0.5).isEmpty());
  EXPECT_NEAR(extent(0, 4).max().y(), 3.0, 1e-6) << "the beam";
}

TEST_F(OverhangTest, TheFootprintHoldsThemAfterwards) {
  const auto overhang = Overhang::make(robot_, "floor", 2);
  const auto points = overhang->points({{"swing", 0.3}}, chassis_);
  const auto extended = chassis_.extended(points);
  EXPECT_NEAR(extended.circumscribed_radius_m(), std::hypot(1.0, 0.05), 0.01);
  EXPECT_TRUE(overhang->points({{"swing", 0.3}}, extended.padded(1e-6)).empty());
}

TEST_F(OverhangTest, AnUnknownLinkIsAnError) {
  EXPECT_NE(Overhang::make(robot_, "wheel", 2).error().message.find("has no link wheel"), std::string::npos);
}

TEST_F(OverhangTest, WithoutPositionsJointsAreAtZero) {
  EXPECT_FALSE(Overhang::make(robot_, "floor", 2)->points({}, chassis_).empty());
}

}  // namespace
}  // namespace extperfc::navigate
