#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "extperfc/arm/arm_code.hpp"
#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/collision_world.hpp"
#include "extperfc/arm/inverse_kinematics.hpp"
#include "extperfc/arm/joint_trajectory.hpp"
#include "extperfc/arm/motion_planner.hpp"
#include "extperfc/arm/path_constraint.hpp"
#include "extperfc/arm/robot_arms.hpp"

namespace extperfc::arm {

/// Target pose of a link.
struct ToolTarget {
  std::string link;  ///< empty: the group's tip, where it has one only
  Pose root_T_tool{Pose::Identity()};
  IkTolerance tolerance{Eigen::Vector3d::Constant(1e-4), Eigen::Vector3d::Constant(1e-4)};
};

/// A state of the SRDF by its name.
struct NamedState {
  std::string name;
};

enum class MotionKind {
  kFree,    ///< any collision-free path
  kLinear,  ///< the tool along straight lines through all of the targets, which are of one link
};

struct MotionRequest {
  std::string group;
  JointPositions start;  ///< of every moving joint of the robot that is known; the group's are needed
  /// A state, joint values (joints of the group that are not named stay), or tools.
  std::variant<NamedState, JointPositions, std::vector<ToolTarget>> goal;
  MotionKind kind{MotionKind::kFree};
  /// Not empty: these states of the group one after the other, the first of which is where the robot is (to
  /// 0.05 rad); `goal` and `kind` do not count. Proven again.
  std::vector<JointVector> path;
  /// Kept along the whole path; without a target, as at the start; to 1e-4 m or rad. Not
  /// with kLinear.
  std::vector<ToolConstraint> constraints;
  double planning_time_s{5};     ///< above 0
  double velocity_scale{1};      ///< of the limits, (0, 1]
  double acceleration_scale{1};  ///< of the limits, (0, 1]
  double minimum_fraction{1};    ///< kLinear: a smaller planned fraction is a failure, (0, 1]
  bool improve{false};           ///< kFree: use all of the planning time, and take the shortest path found
  std::string planner;           ///< empty: the parameters'
  std::optional<std::uint64_t> seed;
  std::function<bool()> cancelled;  ///< may be empty
};

struct MotionTimes {
  double checker_s{0};  ///< model of the robot and the world
  double goals_s{0};    ///< joint values for poses
  double search_s{0};
  double shortcut_s{0};
  double time_parameterization_s{0};  ///< corners, their proof, and points
  [[nodiscard]] double sum_s() const {
    return checker_s + goals_s + search_s + shortcut_s + time_parameterization_s;
  }
};

struct MotionOutcome {
  ArmCode code{ArmCode::kInternal};
  std::string message;  ///< one line for people
  std::vector<std::string> joints;
  std::vector<JointVector> waypoints;
  std::optional<JointTrajectory> trajectory;  ///< on success
  std::vector<TrajectoryPoint> points;        ///< on success: of the trajectory, for cubic interpolation
  double fraction{0};                         ///< planned fraction of the path, [0, 1]
  MotionTimes times;
};

struct MotionPipelineParams {
  PlannerParams planner;  ///< timeout and seed are the request's
  /// Distance that plans keep from everything; 0.0015 to 0.05 m. What the trajectory leaves the proven lines
  /// by (rounded corners' chords, points for the controller, joints of the other arm that stand a little
  /// elsewhere) moves no point of a Baxter by more than 0.0015 m. Where the start, a goal or a straight path
  /// is nearer to something, the plan keeps no distance; free motions then stop at their corners, and those
  /// of straight and constrained ones move no point by more than 0.0005 m off what is proven.
  double padding_m{0.002};
  double corner_deviation_rad{0.05};  ///< of rounded corners, where that is proven free; [0, 0.5]
  int goal_samples{12};               ///< joint values looked for per pose, [1, 100]
  int threads{1};           ///< planners at once, each with a seed of its own, [1, 8]; to improve, 2 at least
  double goal_time_s{0.5};  ///< of planning_time_s at most for them, above 0
};

/// From a request to a trajectory: model of the robot with its other joints where they are, goals by inverse
/// kinematics, path, time parameterization. What it returns is proven free at every instant.
///
/// Not thread-safe: it keeps the model of the robot between calls.
class MotionPipeline {
 public:
  /// Throws std::invalid_argument for a parameter out of its range.
  MotionPipeline(RobotArms arms, const MotionPipelineParams& params);
  ~MotionPipeline();
  MotionPipeline(MotionPipeline&&) noexcept;

  [[nodiscard]] MotionOutcome plan(const MotionRequest& request, const CollisionWorld& world);

  struct Solved {
    ArmCode code{ArmCode::kInternal};
    std::string message;
    JointPositions joints;  ///< of the group, the solution nearest to the start
  };
  /// Joint values for the request's goal, nothing else. `avoid_collisions`: those of the world and with
  /// itself.
  [[nodiscard]] Solved solve(const MotionRequest& request, const CollisionWorld& world,
                             bool avoid_collisions);

  /// A checker of the group with the robot's other joints as in `positions`. `padded`: as plans keep.
  /// Errors: an unknown group, an object that does not fit the robot.
  [[nodiscard]] Result<CollisionChecker> checker(const std::string& group, const JointPositions& positions,
                                                 const CollisionWorld& world, bool padded);

  [[nodiscard]] const RobotArms& arms() const { return arms_; }
  [[nodiscard]] const MotionPipelineParams& params() const { return params_; }

 private:
  struct Models;
  RobotArms arms_;
  MotionPipelineParams params_;
  std::unique_ptr<Models> models_;
};

}  // namespace extperfc::arm
