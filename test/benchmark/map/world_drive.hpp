#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/rng.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/pose.hpp"

#include "test/benchmark/map/floor_world.hpp"

namespace extperfc::benchmark {

/// Ranges come rounded to the centimetre; what is out of range, and three of four rays into glass, come as
/// infinity.
struct WorldScanner {
  int rays{180};
  double angle_min{-M_PI / 2};         ///< [rad]
  double angle_increment{M_PI / 180};  ///< [rad]
  double range_max_m{30};
  double sigma_m{0.015};       ///< of a range
  double outlier_fraction{0};  ///< of the rays, anywhere in the range
  Pose2 base_T_sensor;
};

/// Wheels that are with constant relative errors and random walks.
struct WorldOdometry {
  bool there{true};    ///< false: the mapper gets scans alone
  double scale{0.01};  ///< relative error of lengths
  double veer_rad_per_m{0.002};
  double rotation_scale{0.01};  ///< relative error of rotations
  double sigma_m_per_sqrt_m{0.01};
  double sigma_rad_per_sqrt_m{0.005};
  double sigma_rad_per_sqrt_rad{0.01};
};

/// A building, and how a robot drives through it and sees it.
struct WorldCase {
  FloorWorld floor;
  std::vector<Eigen::Vector2d> route;  ///< corners, on the floor [m]
  double step_m{0.12};                 ///< distance between two scans
  double wander_m{0.2};                ///< off the route's straight lines, at most
  int pedestrians{0};                  ///< people near the robot
  WorldScanner scanner;
  WorldOdometry odometry;
};

/// People of 0.4 m who appear near the robot's path, walk along it or against it, and go again.
class Pedestrians {
 public:
  explicit Pedestrians(int count) : all_(static_cast<std::size_t>(count)) {}

  /// One scan later; the robot is at `poses[now]`.
  void move(const WorldCase& world, const std::vector<Pose2>& poses, std::size_t now, Rng& rng);
  /// Distance to the nearest [m]; infinity when the ray meets none.
  [[nodiscard]] double range(const Eigen::Vector2d& from, double angle_rad) const;

 private:
  struct Pedestrian {
    Eigen::Vector2d at{0, 0};
    Eigen::Vector2d velocity{0, 0};  // per metre of the robot's path
    double left_m{0};                // of the robot's path, until the pedestrian leaves; 0: not there
  };
  static Pedestrian appear(const WorldCase& world, const std::vector<Pose2>& poses, std::size_t now,
                           Rng& rng);

  std::vector<Pedestrian> all_;
};

/// The recording of a drive, made scan by scan: a whole one would take tens of megabytes.
class WorldRecorder {
 public:
  /// `world` must outlive the recorder.
  WorldRecorder(const WorldCase& world, std::uint64_t seed);

  struct Step {
    LaserScan scan;
    Pose2 odom_T_base;
    Pose2 world_T_base;  ///< the truth
    double path_m{0};    ///< driven so far
  };
  /// No value at the end.
  [[nodiscard]] std::optional<Step> next();

 private:
  void drive_on();
  [[nodiscard]] LaserScan scan();
  [[nodiscard]] float range(const Pose2& sensor, double angle_rad);

  const WorldCase& world_;
  Rng rng_;
  std::vector<Pose2> poses_;
  Pedestrians pedestrians_;
  Pose2 odom_T_base_;
  double path_m_{0};
  std::size_t now_{0};
};

}  // namespace extperfc::benchmark
