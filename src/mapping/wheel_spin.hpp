#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include <Eigen/Core>

#include "extperfc/world/pose.hpp"

#include "mapping/matcher.hpp"
#include "mapping/scan_points.hpp"
#include "mapping/surface_map.hpp"

namespace extperfc::mapping {

/// Tells in a corridor, where scans hardly constrain the position along it, whether the robot moves as its
/// wheels report or stands while they spin. The few surfaces that face along the corridor, as door frames do,
/// decide: for every place between where the wheels began to be believed and where they have the robot now,
/// it adds up how many of those points fit what was seen well before. People who walk along were elsewhere
/// then, and what looks like another place by chance does so for a scan or two. Poses are in the tracker's
/// frame.
class WheelSpin {
 public:
  static constexpr double kWellBeforeM = 0.5;  ///< that the scans of `before` were taken away from `from`

  enum class Verdict { kOpen, kMoves, kStands };

  /// `along` has unit length.
  WheelSpin(const Pose2& from, const Eigen::Vector2d& along, SurfaceMap before)
      : from_(from), along_(along), before_(std::move(before)) {}

  /// Takes the next scan and where odometry has it.
  [[nodiscard]] Verdict add(const ScanPoints& points, const Pose2& by_odometry);
  /// After kStands: where the robot stands, by the last scan.
  [[nodiscard]] const ScanMatch& place() const { return place_; }

 private:
  static constexpr double kPlaceStepM = 0.02;
  static constexpr int kReachSteps = 50;  ///< a metre

  [[nodiscard]] Verdict judge(double stands, double moves) const;
  [[nodiscard]] bool several_agree(const ScanPoints& facing, const Pose2& stands, const Pose2& moves) const;
  /// Points that say that the robot stands so many steps from `from`, or got there by its wheels.
  double& standing(int step) {
    const int index = step + kReachSteps;
    return standing_.at(static_cast<std::size_t>(index));
  }

  Pose2 from_;
  Eigen::Vector2d along_;
  SurfaceMap before_;
  std::array<double, 2 * kReachSteps + 1> standing_{};
  double facing_{0};  ///< points in all that face along the corridor
  int scans_{0};
  ScanMatch place_;
};

}  // namespace extperfc::mapping
