#include "test/ros/mapping/room.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <boost/make_shared.hpp>

#include "extperfc/base/rng.hpp"

namespace extperfc::ros_test {

namespace {

struct Wall {
  double x1, y1, x2, y2;
};

std::vector<Wall> walls() {
  std::vector<Wall> all{{-4, 2, -1.5, 2}};
  const auto box = [&](double x1, double y1, double x2, double y2) {
    all.insert(all.end(), {{x1, y1, x2, y1}, {x2, y1, x2, y2}, {x2, y2, x1, y2}, {x1, y2, x1, y1}});
  };
  box(-4, -3, 5, 4);
  box(1.2, 2.3, 2.2, 3.0);
  box(-2.8, -3, -1.8, -1.6);
  return all;
}

/// Along the ray from (x, y) to where it meets the wall; infinity when it does not.
double hit(const Wall& wall, double x, double y, double dx, double dy) {
  const double wx = wall.x2 - wall.x1;
  const double wy = wall.y2 - wall.y1;
  const double determinant = dx * wy - dy * wx;
  if (std::abs(determinant) < 1e-12) return std::numeric_limits<double>::infinity();
  const double ox = wall.x1 - x;
  const double oy = wall.y1 - y;
  const double range = (ox * wy - oy * wx) / determinant;
  const double ratio = (ox * dy - oy * dx) / determinant;
  return range > 0 && ratio >= -1e-9 && ratio <= 1 + 1e-9 ? range : std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<float> look(const Pose2& room_T_lidar, const Lidar& lidar, unsigned seed) {
  static const auto kWalls = walls();
  Rng rng(seed);
  std::vector<float> ranges;
  for (int i = 0; i < lidar.rays; ++i) {
    const double angle = room_T_lidar.yaw + lidar.angle_min + i * lidar.angle_increment;
    double range = std::numeric_limits<double>::infinity();
    for (const auto& wall : kWalls)
      range = std::min(range, hit(wall, room_T_lidar.x, room_T_lidar.y, std::cos(angle), std::sin(angle)));
    ranges.push_back(static_cast<float>(range + rng.normal(0.0, lidar.noise_m)));
  }
  return ranges;
}

sensor_msgs::LaserScanPtr scan_message(const Pose2& room_T_lidar, const ros::Time& stamp, const Lidar& lidar,
                                       unsigned seed) {
  auto message = boost::make_shared<sensor_msgs::LaserScan>();
  message->header.stamp = stamp;
  message->header.frame_id = "laser";
  message->angle_min = static_cast<float>(lidar.angle_min);
  message->angle_increment = static_cast<float>(lidar.angle_increment);
  message->angle_max = static_cast<float>(lidar.angle_min + (lidar.rays - 1) * lidar.angle_increment);
  message->range_min = 0.05F;
  message->range_max = static_cast<float>(lidar.range_max);
  message->ranges = look(room_T_lidar, lidar, seed);
  return message;
}

double distance_to_wall(double x_m, double y_m) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& wall : walls()) {
    const double wx = wall.x2 - wall.x1;
    const double wy = wall.y2 - wall.y1;
    const double ratio =
        std::clamp(((x_m - wall.x1) * wx + (y_m - wall.y1) * wy) / (wx * wx + wy * wy), 0.0, 1.0);
    nearest = std::min(nearest, std::hypot(x_m - wall.x1 - ratio * wx, y_m - wall.y1 - ratio * wy));
  }
  return nearest;
}

}  // namespace extperfc::ros_test
