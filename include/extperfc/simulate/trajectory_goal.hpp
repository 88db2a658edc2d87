#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

/// What a trajectory controller is asked for, and how it answers: control_msgs/FollowJointTrajectory without
/// ROS.
namespace extperfc::simulate {

/// A joint that a follower moves.
struct FollowedJoint {
  std::string name;
  double lower{-std::numeric_limits<double>::infinity()};  ///< minimum position [rad]
  double upper{std::numeric_limits<double>::infinity()};   ///< greatest position [rad]
};

/// A point of a goal; lists in the order of the goal's joints.
struct TrajectoryPoint {
  double time_s{0};                   ///< since the start
  std::vector<double> positions;      ///< [rad]
  std::vector<double> velocities;     ///< [rad/s]; may be empty
  std::vector<double> accelerations;  ///< [rad/s^2]; may be empty, and must be without velocities
};

/// Bounds of one joint's errors. Above 0: the bound. 0: the follower's default. Below 0: no bound.
struct JointTolerance {
  std::string joint;
  double position{0};      ///< [rad]
  double velocity{0};      ///< [rad/s]
  double acceleration{0};  ///< [rad/s^2], of the velocity's differences
};

struct TrajectoryGoal {
  std::vector<std::string> joints;      ///< every joint of the follower, in any order
  std::vector<TrajectoryPoint> points;  ///< times increase strictly
  std::optional<double> start_s;        ///< on the caller's clock; empty: at once
  std::vector<JointTolerance> path_tolerance;
  std::vector<JointTolerance> goal_tolerance;
  double goal_time_tolerance_s{0};  ///< 0: the follower's default
};

/// The action's result codes; the numbers are the interface.
enum class TrajectoryCode {
  kSuccessful = 0,
  kInvalidGoal = -1,
  kInvalidJoints = -2,
  kOldHeaderTimestamp = -3,
  kPathToleranceViolated = -4,
  kGoalToleranceViolated = -5,
};

/// How a goal ended, or why it was refused.
struct TrajectoryEnd {
  TrajectoryCode code{TrajectoryCode::kSuccessful};
  std::string message;  ///< for a person: which joint, by how much, what to do
};

template <typename T>
using TrajectoryResult = tl::expected<T, TrajectoryEnd>;

}  // namespace extperfc::simulate
