#pragma once

#include <vector>

#include <Eigen/Core>

#include "test/unit/mapping/mapper_drive.hpp"

namespace extperfc::mapping {

using Corners = std::vector<Eigen::Vector2d>;

/// Three rooms in a row, 8 m x 6 m each, with doorways of 1.2 m; no two have the same furniture.
inline PlanarWorld three_rooms() {
  PlanarWorld world;
  world.add_box(0, 0, 24, 6);
  for (const double x : {8.0, 16.0}) {
    world.add_box(x - 0.1, 0, x + 0.1, 2.4);
    world.add_box(x - 0.1, 3.6, x + 0.1, 6);
  }
  world.add_box(0, 4.6, 1.3, 6);  // the first room
  world.add_box(5.2, 0, 6.3, 0.7);
  world.add_box(3.1, 5.5, 4.6, 6);
  world.add_box(10.2, 4.9, 12.6, 6);  // the second
  world.add_box(8.1, 0, 9.0, 1.1);
  world.add_wall({13.2, 0}, {14.6, 1.4});
  world.add_box(19.6, 2.2, 20.5, 3.1);  // the third
  world.add_box(22.9, 0, 24, 2.0);
  world.add_box(17.0, 5.2, 18.1, 6);
  return world;
}

inline const Corners kThroughAll = {{2, 2},  {4, 3},    {8, 3},      {10, 2},     {14, 3.5},
                                    {16, 3}, {18, 1.5}, {21.5, 1.5}, {21.5, 4.5}, {18.5, 4},
                                    {16, 3}, {12, 3},   {8, 3},      {5, 4},      {2, 3}};
inline const Corners kBackFromThird = {{18.5, 1.2}, {21.6, 1.4}, {21.6, 4.6}, {18.6, 4.2}, {16, 3},
                                       {12, 2.5},   {8, 3},      {4, 3.5},    {2.5, 2}};

inline MapperDrive drive_through(const Corners& corners, std::uint64_t seed) {
  return record_drive(three_rooms(), planar_drive(corners, 0.12, 0.12), seed);
}

/// The second drive behind the first: the wheels do not notice how the robot came from one to the other.
inline MapperDrive carried_between(const Corners& first, const Corners& second, std::uint64_t seed) {
  MapperDrive drive = drive_through(first, seed);
  const MapperDrive rest = drive_through(second, seed + 1);
  const Pose2 end = drive.odometry.back();
  const Pose2 start{first[0].x(), first[0].y(), planar_drive(first, 0.12, 0.12).front().yaw};
  const Pose2 put_down = planar_drive(second, 0.12, 0.12).front();
  for (std::size_t i = 0; i < rest.scans.size(); ++i) {
    drive.scans.push_back(rest.scans[i]);
    drive.odometry.push_back(compose(end, rest.odometry[i]));
    drive.truth.push_back(compose(between(start, put_down), rest.truth[i]));
  }
  return drive;
}

}  // namespace extperfc::mapping
