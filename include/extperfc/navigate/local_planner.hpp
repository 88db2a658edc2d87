#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/nav_error.hpp"
#include "extperfc/navigate/path.hpp"
#include "extperfc/navigate/velocity.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// A person who walks: expected to keep the same velocity.
struct MovingObstacle {
  Eigen::Vector2d position_m{Eigen::Vector2d::Zero()};  ///< in the grid's frame
  Eigen::Vector2d velocity_m_s{Eigen::Vector2d::Zero()};
  double radius_m{0.3};
};

struct LocalState {
  Pose2 pose;                          ///< of the base, in the grid's frame
  Twist2 velocity;                     ///< of the base, in the base's frame
  std::vector<MovingObstacle> people;  ///< that are not part of the costs, or may be
  double speed_factor{1};              ///< of speed zones, [0, 1]
};

struct LocalCommand {
  Twist2 velocity;                ///< to send now
  std::vector<Pose2> trajectory;  ///< that it begins, in the grid's frame
  std::vector<std::vector<Pose2>>
      candidates;       ///< a few of those considered, for display; empty unless wanted
  bool at_goal{false};  ///< within the tolerances, and at rest
};

struct GoalTolerance {
  double xy_m{0.08};     ///< > 0
  double yaw_rad{0.08};  ///< > 0
};

/// Interface of local planners (nav_core's BaseLocalPlanner). One thread at a time.
class LocalPlanner {
 public:
  virtual ~LocalPlanner() = default;
  /// A path in the grid's frame: a new goal, or the same goal replanned or moved by localization.
  /// Precondition: not empty.
  virtual void set_path(const Path& path, const GoalTolerance& tolerance) = 0;
  /// The velocity for the next `dt_s`. Errors: kBlocked when every admissible motion touches something (the
  /// command is then to stop), kInvalidRequest for values that are not finite or before set_path().
  [[nodiscard]] virtual NavResult<LocalCommand> command(const CostGrid& costs, const Footprint& footprint,
                                                        const LocalState& state, double dt_s,
                                                        bool with_candidates) = 0;
  /// Forgets the path and the last commands.
  virtual void reset() = 0;
};

struct MppiParams {
  VelocityLimits limits;
  BaseKind base{BaseKind::kHolonomic};
  int samples{400};               ///< trajectories per cycle, [10, 10000]
  double horizon_s{2.0};          ///< [0.5, 10]
  double step_s{0.1};             ///< of a trajectory, [0.02, 0.5]
  double temperature{0.3};        ///< of the weights, > 0
  double sigma_vx_m_s{0.25};      ///< of the sampled velocities, > 0
  double sigma_vy_m_s{0.2};       ///< the same
  double sigma_wz_rad_s{0.5};     ///< the same
  double path_weight{10};         ///< distance from the path, >= 0
  double heading_weight{2};       ///< difference from the path's heading, >= 0
  double progress_weight{5};      ///< distance that is left along the path, >= 0
  double obstacle_weight{3};      ///< costs of cells, >= 0
  double people_weight{5};        ///< predicted people, >= 0
  double smooth_weight{0.5};      ///< change of velocity, >= 0
  double max_shift_m{0.5};        ///< sideways from the path, around what the map does not show, [0, 2]
  double narrow_speed_m_s{0.25};  ///< where the footprint nearly touches, [0.02, 5]
  double wide_clearance_m{0.3};   ///< full speed from this clearance of the footprint on, [0.01, 1]
  double reaction_s{0.15};        ///< from a command to the base's motion, for braking, [0, 2]
  double blocked_after_s{1.5};    ///< kBlocked after so long without a motion, [0.1, 60]
  std::uint64_t seed{1};
};

/// Model predictive path integral control (Williams et al., "Information theoretic MPC", ICRA 2017). Throws
/// std::invalid_argument for parameters out of their range.
[[nodiscard]] std::unique_ptr<LocalPlanner> make_mppi_planner(const MppiParams& params);

}  // namespace extperfc::navigate
