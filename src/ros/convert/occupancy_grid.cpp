#include "ros/convert/occupancy_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_convert {

namespace {

constexpr double kMaxTiltRad = 1e-3;  // of a map against the floor; origins come from text
constexpr std::size_t kMaxCells = 1'000'000'000;

/// Angle between the z axis of a rotation and the vertical [rad]; `q` need not have length one.
double tilt_of(const geometry_msgs::Quaternion& q) {
  const double square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  return 2 * std::asin(std::min(1.0, std::sqrt((q.x * q.x + q.y * q.y) / square)));
}

/// The shortest decimal number that is this float: 0.05F means 0.05, not 0.0500000007.
double decimal_of(float value) {
  std::array<char, 32> text{};
  for (int digits = 6; digits <= 9; ++digits) {
    std::snprintf(text.data(), text.size(), "%.*g", digits, static_cast<double>(value));
    if (std::strtof(text.data(), nullptr) == value) break;
  }
  return std::strtod(text.data(), nullptr);
}

}  // namespace

nav_msgs::OccupancyGrid to_message(const OccupancyGrid& map, const std_msgs::Header& header) {
  nav_msgs::OccupancyGrid message;
  message.header = header;
  message.info.map_load_time = header.stamp;
  message.info.resolution = static_cast<float>(map.resolution_m);
  message.info.width = static_cast<std::uint32_t>(map.width);
  message.info.height = static_cast<std::uint32_t>(map.height);
  message.info.origin = to_pose_message(map.origin);
  message.data.assign(map.cells.begin(), map.cells.end());
  return message;
}

Result<OccupancyGrid> to_occupancy_grid(const nav_msgs::OccupancyGrid& message) {
  const auto& info = message.info;
  const std::size_t cells = std::size_t{info.width} * info.height;
  if (cells == 0) return fail(ErrorCode::kInvalidArgument, "the map has no cells");
  if (cells > kMaxCells || message.data.size() != cells)
    return fail(ErrorCode::kInvalidArgument, "the map says " + std::to_string(info.width) + " x " +
                                                 std::to_string(info.height) + " cells, but brings " +
                                                 std::to_string(message.data.size()));
  if (!std::isfinite(info.resolution) || info.resolution <= 0)
    return fail(ErrorCode::kInvalidArgument,
                "the map's resolution must be a positive number of metres, but is " +
                    std::to_string(info.resolution));
  const auto origin = to_pose2(info.origin);
  if (!origin) return fail(ErrorCode::kInvalidArgument, "the map's origin: " + origin.error().message);
  if (tilt_of(info.origin.orientation) > kMaxTiltRad)
    return fail(ErrorCode::kInvalidArgument, "the map's origin is tilted: it must lie flat on the floor");
  OccupancyGrid map;
  map.width = info.width;
  map.height = info.height;
  map.resolution_m = decimal_of(info.resolution);
  map.origin = *origin;
  map.cells.assign(message.data.begin(), message.data.end());
  return map;
}

}  // namespace extperfc::ros_convert
