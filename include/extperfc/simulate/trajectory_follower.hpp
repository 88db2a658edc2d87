#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/simulate/joint_spline.hpp"
#include "extperfc/simulate/trajectory_goal.hpp"

namespace extperfc::simulate {

struct TrajectoryFollowerParams {
  double path_tolerance_rad{0.2};           ///< of every joint during the motion, (0, 10]; Baxter's default
  double goal_tolerance_rad{0.0087};        ///< of every joint at the end, (0, 10]; half a degree
  double goal_time_s{0.1};                  ///< wait for goal_tolerance after the last point, [0, 120]
  double stopped_velocity_rad_s{0.25};      ///< slower than this is at rest, (0, 10]
  double stop_deceleration_rad_s2{4.0};     ///< when a goal is given up, (0, 50]
  double longest_wait_for_start_s{3600.0};  ///< a start that lies further ahead is refused, [0, inf)
};

/// Bounds of the error of every joint; infinity: none.
struct MotionBounds {
  Eigen::VectorXd position;      ///< [rad]
  Eigen::VectorXd velocity;      ///< [rad/s]
  Eigen::VectorXd acceleration;  ///< [rad/s^2]
};

/// Leads some joints along a trajectory and judges how they follow, as control_msgs/FollowJointTrajectory
/// documents it. Has no clock and moves nothing: the caller gives time and measurements, and takes set
/// points.
///
///  - The trajectory begins where the joints are (or where the goal before wants them, with its velocity), so that
///  the
///    first point with a time above 0 is reached without a jump. A first point at time 0 is taken as it is:
///    far from the joints, it violates path_tolerance.
///  - A start in the future slows a running motion down and waits; with a start in the past the points that
///    are over are left out.
///  - stop() slows every joint down to rest with the deceleration of the parameters, from the set point of
///    now; so do the joints after a violated tolerance, from where they are.
class TrajectoryFollower {
 public:
  TrajectoryFollower(std::vector<FollowedJoint> joints, const TrajectoryFollowerParams& params);

  /// Takes a goal and forgets the one before; a refused goal changes nothing. `measured`: positions and
  /// velocities of now.
  TrajectoryResult<void> start(const TrajectoryGoal& goal, double now_s, const JointMotion& measured);
  /// Gives the goal up and slows down. No end is reported any more.
  void stop(double now_s);
  /// Gives the goal up at once, without set points from now on.
  void drop();

  /// Judges what is measured now: the end of the goal, once. Call it at every step.
  [[nodiscard]] std::optional<TrajectoryEnd> update(double now_s, const JointMotion& measured);

  /// A goal is waiting for its start or active.
  [[nodiscard]] bool following() const { return phase_ == Phase::kFollowing; }
  /// There is a set point to give: following, or slowing down after stop().
  [[nodiscard]] bool moving() const { return phase_ != Phase::kIdle; }
  /// Set point for a time, while moving().
  [[nodiscard]] JointMotion desired(double time_s) const;
  /// What update() was given last, with the acceleration as the difference of velocities.
  [[nodiscard]] const JointMotion& measured() const { return measured_; }
  [[nodiscard]] const std::vector<FollowedJoint>& joints() const { return joints_; }

 private:
  enum class Phase { kIdle, kFollowing, kStopping };

  void measure(double now_s, const JointMotion& measured);
  void brake_from(double now_s, const JointMotion& motion);
  [[nodiscard]] std::optional<TrajectoryEnd> judge_path(double now_s) const;
  [[nodiscard]] std::optional<TrajectoryEnd> judge_goal(double now_s) const;
  [[nodiscard]] std::string first_violation(const JointMotion& wanted, const MotionBounds& bounds) const;

  std::vector<FollowedJoint> joints_;
  TrajectoryFollowerParams params_;
  Phase phase_{Phase::kIdle};
  JointSpline spline_;  ///< times on the caller's clock
  JointMotion brake_;   ///< where slowing down begins
  double brake_start_s_{0};
  double start_s_{0};  ///< of the goal; before it brake_ holds
  bool begun_{false};  ///< the start was judged
  double goal_time_s_{0};
  MotionBounds path_bounds_;
  MotionBounds goal_bounds_;
  JointMotion measured_;
  std::optional<double> last_update_s_;
};

}  // namespace extperfc::simulate
