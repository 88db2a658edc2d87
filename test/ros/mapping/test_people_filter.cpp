#include <cmath>

#include <gtest/gtest.h>

#include "ros/mapping/people_filter.hpp"

namespace extperfc::ros_mapping {
namespace {

/// A person at (x, 0) who walks along y.
TrackArray person(double x_m, double speed_m_s, double score) {
  TrackArray message;
  message.header.frame_id = "odom";
  message.header.stamp.fromSec(10);
  message.tracks.resize(1);
  message.tracks[0].pose.pose.position.x = x_m;
  message.tracks[0].velocity.y = speed_m_s;
  message.tracks[0].size.x = 0.5;
  message.tracks[0].score = score;
  return message;
}

/// Of a robot at (1, 0) with one ray ahead.
LaserScan ray(double stamp_s, float range_m) {
  LaserScan scan;
  scan.stamp_s = stamp_s;
  scan.angle_increment = 0.01;
  scan.range_min = 0.1;
  scan.range_max = 20;
  scan.ranges = {range_m};
  return scan;
}

bool leaves_out(PeopleFilter& filter, double stamp_s, float range_m) {
  return std::isnan(filter.without_people(ray(stamp_s, range_m), {1, 0, 0}).ranges[0]);
}

TEST(PeopleFilter, LeavesOutWhoWasSeenToWalk) {
  PeopleFilter filter("odom");
  EXPECT_FALSE(leaves_out(filter, 10, 2));
  filter.add(person(3, 0, 1));
  EXPECT_TRUE(leaves_out(filter, 10, 2));
  EXPECT_TRUE(leaves_out(filter, 10.1, 1.7F));
  EXPECT_FALSE(leaves_out(filter, 10, 1.4F));
  EXPECT_FALSE(leaves_out(filter, 10, 2.7F));
  EXPECT_EQ(filter.left_out(), 2U);
  filter.add(person(3, 0, 0));
  EXPECT_FALSE(leaves_out(filter, 10, 2)) << "furniture of a person's size";
}

TEST(PeopleFilter, PeopleAreWhereTheyWalkToMeanwhile) {
  PeopleFilter filter("odom");
  filter.add(person(3, 1.0, 1));
  EXPECT_TRUE(leaves_out(filter, 10.2, 2));
  EXPECT_FALSE(leaves_out(filter, 10.8, 2));
}

TEST(PeopleFilter, OldTracksAndOtherFramesDoNotCount) {
  PeopleFilter filter("odom");
  filter.add(person(3, 0, 1));
  EXPECT_FALSE(leaves_out(filter, 11.5, 2));
  auto other = person(3, 0, 1);
  other.header.frame_id = "map";
  filter.add(other);
  EXPECT_FALSE(leaves_out(filter, 10, 2));
  filter.add(person(std::nan(""), 0, 1));
  EXPECT_FALSE(leaves_out(filter, 10, 2));
}

}  // namespace
}  // namespace extperfc::ros_mapping
