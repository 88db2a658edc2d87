#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "extperfc/arm/joint_path.hpp"
#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/base/error.hpp"

namespace extperfc::arm {

/// Largest absolute value of each joint's derivatives, all > 0 and finite, in the order of the joints.
struct TrajectoryLimits {
  JointVector velocity;               ///< [rad/s]
  JointVector acceleration;           ///< [rad/s^2]
  std::optional<JointVector> jerk{};  ///< [rad/s^3]; none: accelerations may jump
};

/// What the joints do at one instant.
struct JointSample {
  JointVector position;      ///< [rad]
  JointVector velocity;      ///< [rad/s]
  JointVector acceleration;  ///< [rad/s^2]; where it jumps, the value just behind the jump
};

/// A piece of time with constant acceleration along the path: s(t) = begin_rad + speed t + acceleration t^2
/// / 2.
struct PathPhase {
  double begin_s{0};       ///< since the start of its run [s]
  double duration_s{0};    ///< > 0
  std::size_t piece{0};    ///< of the path; a phase never leaves it
  double offset{0};        ///< s at its start, from the start of the piece [rad]
  double speed{0};         ///< ds/dt at its start [rad/s], >= 0
  double acceleration{0};  ///< d2s/dt2 [rad/s^2]
};

/// A motion without a stop inside. With a window T > 0 it is the moving average over the last T seconds of
/// what the phases say, and lasts T longer; before and after the phases the joints rest.
struct TrajectoryRun {
  double begin_s{0};           ///< in the trajectory
  double phases_s{0};          ///< how long its phases last
  double window_s{0};          ///< T
  std::size_t first_phase{0};  ///< of the trajectory's phases ...
  std::size_t phases{0};       ///< ... and how many, >= 1
};

/// A path with a time parameterization, made by parameterize(). Any instant can be sampled.
///
/// Why a moving average over T seconds keeps what the phases keep: its velocity and acceleration are averages
/// of theirs, so per-joint bounds hold; its jerk is (a(t) - a(t - T)) / T, so a long enough window bounds it;
/// positions are convex combinations, so joint limits hold; and from the path's point of half a window before
/// it differs by a weighted sum of accelerations with weights that sum to T^2 / 24.
class JointTrajectory {
 public:
  /// `runs` follow each other in time, `phases` run by run. For parameterize(); both empty: a motion of no
  /// duration at the end of the path.
  JointTrajectory(JointPath path, TrajectoryLimits limits, std::vector<PathPhase> phases,
                  std::vector<TrajectoryRun> runs, double smoothing_deviation_rad);

  [[nodiscard]] Eigen::Index joints() const { return path_.joints(); }
  [[nodiscard]] double duration_s() const { return duration_s_; }
  /// Before the start: the state at the start; from the end on: the end of the path, exactly, with the
  /// velocity that it is reached with and no acceleration. O(log phases).
  [[nodiscard]] JointSample sample(double time_s) const;
  /// Jerk just behind `time_s` [rad/s^3] of a smoothed trajectory; none where accelerations jump.
  [[nodiscard]] std::optional<JointVector> jerk(double time_s) const;

  /// Largest distance from the lines between the waypoints, corners and smoothing together, Euclidean norm
  /// over the joints [rad]. A bound, not a measurement.
  [[nodiscard]] double deviation_rad() const { return path_.deviation_rad() + smoothing_deviation_rad_; }
  [[nodiscard]] const JointPath& path() const { return path_; }
  [[nodiscard]] const TrajectoryLimits& limits() const {
    return limits_;
  }  ///< what it keeps, scaling applied
  [[nodiscard]] const std::vector<PathPhase>& phases() const { return phases_; }
  [[nodiscard]] const std::vector<TrajectoryRun>& runs() const { return runs_; }
  /// Where acceleration (or jerk, where smoothed) may jump: sorted, from 0 to duration_s() [s].
  [[nodiscard]] std::vector<double> borders_s() const;

 private:
  [[nodiscard]] JointSample raw(const TrajectoryRun& run, double time_s) const;
  [[nodiscard]] JointSample at(const PathPhase& phase, double time_s) const;
  [[nodiscard]] const PathPhase& phase_at(const TrajectoryRun& run, double time_s) const;
  [[nodiscard]] JointVector run_start(const TrajectoryRun& run) const;
  [[nodiscard]] JointVector run_end(const TrajectoryRun& run) const;
  [[nodiscard]] JointVector area(const TrajectoryRun& run, double time_s) const;
  [[nodiscard]] JointVector phase_area(const PathPhase& phase, double duration_s,
                                       const JointVector& from) const;
  [[nodiscard]] const TrajectoryRun& run_at(double time_s) const;
  void prepare_areas();

  JointPath path_;
  TrajectoryLimits limits_;
  std::vector<PathPhase> phases_;
  std::vector<TrajectoryRun> runs_;
  std::vector<JointVector> areas_;  ///< per phase: integral of q - q(run's start) from there on [rad s]
  double smoothing_deviation_rad_{0};
  double duration_s_{0};
};

/// A point of a trajectory_msgs/JointTrajectory.
struct TrajectoryPoint {
  double time_s{0};  ///< from the start; whole nanoseconds
  JointVector position;
  JointVector velocity;
  std::optional<JointVector> acceleration;  ///< only for quintic interpolation
};

/// What the controller does between two points.
enum class Interpolation {
  kCubic,    ///< from positions and velocities
  kQuintic,  ///< from accelerations too; only for smoothed trajectories
};

struct PointParams {
  Interpolation interpolation{Interpolation::kCubic};
  double even_interval_s{0};   ///< > 0: evenly spaced by about this; 0: where the motion needs them [s]
  double max_interval_s{0.2};  ///< between points that are not evenly spaced [s], > 0
  double tolerance_rad{1e-4};  ///< permitted distance of one joint from the trajectory [rad], > 0
};

/// Points between which a controller may interpolate as chosen: the interpolated motion keeps the
/// trajectory's limits of velocity and acceleration at every instant (checked by the hull of its Bezier
/// points), and its path within tolerance_rad per joint unless spacing is even. Where interpolation
/// overshoots a limit, time is stretched as a whole until it does not, adaptive spacing: by 0.1 % or so; even
/// spacing: by up to 29 %, as a cubic overshoots accelerations that jump inside an interval by up to 5/3, and
/// time enters squared. The jerk of what the controller makes of it is not bounded. The first and last point
/// are the ends of the path, exactly. Errors (kInvalidArgument): parameters out of range, quintic
/// interpolation of accelerations that jump.
[[nodiscard]] Result<std::vector<TrajectoryPoint>> to_points(const JointTrajectory& trajectory,
                                                             const PointParams& params = {});

}  // namespace extperfc::arm
