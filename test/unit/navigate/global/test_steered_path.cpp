// What a differential base's path is made of: straight passages, curves in place of rotations.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/navigate/path.hpp"

#include "navigate/global/steered_path.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kLongest_m = 0.1;

const MotionCheck kFree = [](const Pose2&, const Pose2&) { return true; };

/// Radians that a path turns without moving.
double rotation_rad(const std::vector<Pose2>& poses) {
  double rotation = 0;
  for (std::size_t i = 1; i < poses.size(); ++i)
    if (distance_m(poses[i - 1], poses[i]) < 1e-6)
      rotation += std::abs(wrap_angle(poses[i].yaw - poses[i - 1].yaw));
  return rotation;
}

/// Straight to each corner, a rotation there, and so on; the last yaw is that of the last motion.
std::vector<Pose2> corners(const std::vector<Pose2>& places) {
  std::vector<Pose2> poses{places.front()};
  for (std::size_t i = 1; i < places.size(); ++i) {
    const Pose2& from = places[i - 1];
    const Pose2& to = places[i];
    const double yaw = std::atan2(to.y - from.y, to.x - from.x);
    const int count = static_cast<int>(std::ceil(distance_m(from, to) / kLongest_m));
    for (int k = 0; k <= count; ++k) {
      const double part = static_cast<double>(k) / count;
      poses.push_back({from.x + part * (to.x - from.x), from.y + part * (to.y - from.y), yaw});
    }
  }
  return poses;
}

void expect_followed(const std::vector<Pose2>& poses) {
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const double motion_m = distance_m(poses[i - 1], poses[i]);
    if (motion_m < 1e-6) continue;
    const double along = std::atan2(poses[i].y - poses[i - 1].y, poses[i].x - poses[i - 1].x);
    EXPECT_LT(std::abs(wrap_angle(along - poses[i].yaw)), 0.06) << i;
    EXPECT_LE(std::abs(wrap_angle(poses[i].yaw - poses[i - 1].yaw)), 2.5 * motion_m + 1e-9) << i;
  }
}

TEST(RoundCorners, CurvesReplaceRotations) {
  for (const double y : {0.5, 1.5, 3.0}) {
    SCOPED_TRACE(y);
    const auto poses = corners({{0, 0, 0}, {3, 0, 0}, {4.5, y, 0}, {7.5, y, 0}});
    ASSERT_GT(rotation_rad(poses), 0.6);
    const auto rounded = round_corners(poses, kFree);
    EXPECT_EQ(0, rotation_rad(rounded));
    EXPECT_LT(length_m({rounded, 0}), length_m({poses, 0}));
    expect_followed(rounded);
    EXPECT_EQ(0, distance_m(poses.front(), rounded.front()));
    EXPECT_EQ(0, distance_m(poses.back(), rounded.back()));
  }
}

TEST(RoundCorners, TheStartAndTheGoalAreLeftAndReachedWithTheirOwnHeadings) {
  auto poses = corners({{0, 0, 0.7}, {3, 0, 0}});
  poses.push_back({3, 0, -0.8});
  const auto rounded = round_corners(poses, kFree);
  EXPECT_EQ(0, rotation_rad(rounded));
  expect_followed(rounded);
  EXPECT_EQ(0.7, rounded.front().yaw);
  EXPECT_EQ(-0.8, rounded.back().yaw);
}

TEST(RoundCorners, StaysWhereItPasses) {
  const auto poses = corners({{0, 0, 0}, {2, 0, 0}, {2, 2, 0}});
  const MotionCheck outside = [](const Pose2&, const Pose2& to) { return std::hypot(to.x, to.y - 2) > 1.9; };
  const auto rounded = round_corners(poses, outside);
  EXPECT_EQ(0, rotation_rad(rounded));
  for (const Pose2& pose : rounded) EXPECT_GT(std::hypot(pose.x, pose.y - 2), 1.9);
  const MotionCheck nowhere = [](const Pose2&, const Pose2&) { return false; };
  EXPECT_EQ(rotation_rad(poses), rotation_rad(round_corners(poses, nowhere)));
}

TEST(RoundCorners, AReversalStays) {
  auto poses = corners({{0, 0, 0}, {2, 0, 0}});
  for (const double x : {1.9, 1.8, 1.7}) poses.push_back({x, 0, 0});
  poses.push_back({1.7, 0, 1.2});
  const auto ahead = corners({{1.7, 0, 0}, {1.7 + 0.36, 0.93, 0}});
  poses.insert(poses.end(), ahead.begin(), ahead.end());
  EXPECT_NEAR(rotation_rad(poses), rotation_rad(round_corners(poses, kFree)), 1e-9);
  const auto back = corners({{0, 0, 0}, {2, 0, 0}, {0, 0.1, 0}});  // more than 2.2 rad
  EXPECT_NEAR(rotation_rad(back), rotation_rad(round_corners(back, kFree)), 1e-9);
}

TEST(StraightPassage, LeadsThroughAlongItsLine) {
  const Pose2 first{-1.5, -0.6, 0.4};
  const Pose2 middle{0, 0, 0.3};
  const Pose2 last{1.4, 0.9, 0.5};
  const auto passage = straight_passage(first, middle, last, kFree, kFree, kFree);
  ASSERT_TRUE(passage);
  EXPECT_EQ(0, distance_m(first, passage->front()));
  EXPECT_EQ(0, distance_m(last, passage->back()));
  bool on_line = false;
  for (std::size_t i = 1; i < passage->size(); ++i) {
    const Pose2 from = between(middle, (*passage)[i - 1]);
    const Pose2 to = between(middle, (*passage)[i]);
    if (from.x >= 0 || to.x <= 0) continue;
    on_line = true;
    EXPECT_NEAR(0, from.y, 1e-9);
    EXPECT_NEAR(0, to.y, 1e-9);
    EXPECT_LT(from.x, -0.3);
    EXPECT_GT(to.x, 0.3);
  }
  EXPECT_TRUE(on_line);
  expect_followed(*passage);
}

TEST(StraightPassage, RotatesWhereThereIsRoom) {
  const MotionCheck with_room = [](const Pose2& from, const Pose2& to) {
    return std::max(from.x, to.x) < -0.9 || std::min(from.x, to.x) > 0.7;
  };
  const auto passage =
      straight_passage({-1.2, -0.6, 1.0}, {0, 0, 0}, {0.9, -0.6, -1.2}, kFree, with_room, kFree);
  ASSERT_TRUE(passage);
  for (std::size_t i = 1; i < passage->size(); ++i) {
    const Pose2& from = (*passage)[i - 1];
    const Pose2& to = (*passage)[i];
    if (std::abs(wrap_angle(from.yaw - to.yaw)) > 1e-9) {
      EXPECT_TRUE(with_room(from, to)) << i;
    }
  }
}

TEST(StraightPassage, IsEmptyWhereItDoesNotPass) {
  const MotionCheck nowhere = [](const Pose2&, const Pose2&) { return false; };
  EXPECT_FALSE(straight_passage({-1, 0, 0}, {0, 0, 0}, {1, 0, 0}, kFree, kFree, nowhere));
  EXPECT_FALSE(straight_passage({-1, 0, 0}, {0, 0, 0}, {1, 0, 0}, nowhere, nowhere, kFree));
  EXPECT_FALSE(straight_passage({-1, 0, 0}, {0, 0, kPi}, {1, 0, 0}, kFree, kFree, kFree));  // from behind
}

}  // namespace

}  // namespace extperfc::navigate
