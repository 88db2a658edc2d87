#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>

#include "extperfc/simulate/trajectory_follower.hpp"

#include "ros/simulate/sim_host.hpp"

namespace extperfc::ros_robot {

/// Leads one arm along trajectories for the action and the tuck service. The newest request has
/// the arm. Of the simulation thread, all of it.
class ArmMotion {
 public:
  enum class Status {
    kReached,
    kFailed,    ///< `end` has the reason: a tolerance, a disabled robot, a joint command
    kStopped,   ///< after stop(), at rest
    kReplaced,  ///< a newer motion has the arm
  };
  using WhenDone = std::function<void(Status, const simulate::TrajectoryEnd&)>;

  ArmMotion(ros_simulate::SimHost& host, simulate::Side side,
            const simulate::TrajectoryFollowerParams& params);

  /// Takes the arm, or says why not; then the motion before goes on. `when_done` is called once, from the
  /// simulation thread, and not if this fails.
  simulate::TrajectoryResult<void> start(const simulate::Simulator& simulator,
                                         const simulate::TrajectoryGoal& goal, WhenDone when_done);
  /// Slows down; when_done is called at rest.
  void stop();
  /// Ends a motion at once because something else drives the arm.
  void yield_arm(const std::string& reason);

  void after_step(const simulate::Simulator& simulator, const ros::Time& stamp);

  /// Null before the first motion. Its desired() and measured() are those of the last step.
  [[nodiscard]] const simulate::TrajectoryFollower* follower() const {
    return follower_ ? &*follower_ : nullptr;
  }

 private:
  void finish(Status status, const simulate::TrajectoryEnd& end);
  void post_set_point(double time_s);

  ros_simulate::SimHost& host_;
  const simulate::Side side_;
  const simulate::TrajectoryFollowerParams params_;
  std::optional<simulate::TrajectoryFollower> follower_;  ///< made when the robot's limits are known
  std::optional<double> now_s_;                           ///< stamp of the last step
  WhenDone when_done_;                                    ///< empty: no one waits
};

/// One per side.
using ArmMotions = std::array<ArmMotion*, 2>;

}  // namespace extperfc::ros_robot
