#pragma once

#include <string>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/arm/motion_planner.hpp"
#include "extperfc/arm/path_constraint.hpp"
#include "extperfc/base/error.hpp"

namespace extperfc::arm {

/// Those of PlannerParams with other defaults, and more. `planner` is one of constrained_planner_names().
struct ConstrainedPlannerParams : PlannerParams {
  ConstrainedPlannerParams() {
    planner = "cbirrt";
    range_rad = 2.0;
    max_states = 1'000'000;  // those within edges counted
  }
  /// Largest PathConstraint::error() anywhere on the path, between its waypoints too [m] or [rad]; 1e-6 to
  /// 1e-2. What is left to the error that a motion may have is for its rounded corners: see
  /// corner_deviations().
  double tolerance{5e-5};
  /// Length of the steps along the tangent space within an edge, 0.01 to 0.5 rad.
  double step_rad{0.3};
};

/// What plan() says beyond PlanResult. `waypoints` are dense: straight segments between them follow the
/// constraint, some 0.02 rad each. A start or a goal that breaks a constraint is kInvalidRequest, with
/// `violated` set.
struct ConstrainedPlanResult : PlanResult {
  int violated{-1};  ///< index of the constraint that the start, or every goal, breaks; -1: none
  double error_bound{
      0};  ///< of PathConstraint::error() on the whole path, <= ConstrainedPlannerParams::tolerance
};

/// What ConstrainedPlannerParams::planner may be: "cbirrt", and of OMPL "atlas_rrt", "projected_rrt".
[[nodiscard]] const std::vector<std::string>& constrained_planner_names();

/// Collision-free paths between joint configurations on which tools keep what a PathConstraint says.
///
/// Two trees grow towards each other on the manifold of states that keep the constraint: random states are
/// projected onto it, edges are steps in its tangent space, each projected back (Berenson, Srinivasa,
/// Ferguson and Kuffner, "Manipulation planning on constraint manifolds", ICRA 2009; tangent steps as in
/// Stilman, "Global manipulation planning in robot joint space with task constraints", IEEE T-RO 2010). An
/// edge is halved, each middle projected, until PathConstraint::segment_error() of every piece is within the
/// tolerance; then CollisionChecker::motion_free() proves every piece. Samples are bounded by dynamic domains
/// as in MotionPlanner. Shortcuts join random waypoints likewise.
///
/// The planners of OMPL are RRTConnect in its spaces of constrained states (Jaillet and Porta, "Path planning
/// under kinematic constraints by rapidly exploring manifolds", IEEE T-RO 2013; Kingston, Moll and Kavraki,
/// "Exploring implicit spaces for constrained sampling-based planning", IJRR 2019); what they find is refined
/// and proven likewise, and what cannot be is no path: the search goes on.
///
/// Limits are the model's; a continuous joint is planned within [-pi, pi]. Not thread-safe: it uses the
/// checker; checker and constraint must be about the same joints, the checker must outlive it.
class ConstrainedPlanner {
 public:
  /// Throws std::invalid_argument for a parameter out of its range and a constraint on another number of
  /// joints.
  ConstrainedPlanner(CollisionChecker& checker, PathConstraint constraint,
                     const ConstrainedPlannerParams& params);

  [[nodiscard]] ConstrainedPlanResult plan(const PlanRequest& request);

 private:
  CollisionChecker& checker_;
  PathConstraint constraint_;
  ConstrainedPlannerParams params_;
  JointLimits limits_;
};

/// How far the corner at every waypoint may be rounded (JointPathParams::corner_deviation_rad; 0 at both
/// ends) so that PathConstraint::error() stays within `error` on the whole rounded path: what the segments
/// beside a corner leave of `error`, divided by PathConstraint::steepness(). With `smoothing_rad` > 0 as much
/// is kept free for a motion that leaves the path by that Euclidean distance (jerk limits). Errors: sizes
/// that do not fit, segments that exceed `error` without any rounding (kInvalidArgument).
///
/// Use: plan with the tolerance at its default; JointPath::make(waypoints, {1.0, corner_deviations(...,
/// 1e-4)}); parameterize() without jerk limits. A controller that interpolates between points adds their
/// tolerance (PointParams::tolerance_rad, per joint) times steepness and sqrt(joints): ask for `error` less
/// that.
[[nodiscard]] Result<std::vector<double>> corner_deviations(const PathConstraint& constraint,
                                                            const std::vector<JointVector>& waypoints,
                                                            double error, double smoothing_rad = 0);

}  // namespace extperfc::arm
