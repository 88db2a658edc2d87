#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <trajectory_msgs/JointTrajectory.h>

#include "extperfc/arm/collision_world.hpp"

#include "ros/arm/status.hpp"

namespace extperfc::ros_arm {

/// Tells a motion to stop. It asks one check per possible reason, e.g. arm/stop, a newer motion, a cancelled
/// goal.
class CancelToken {
 public:
  using Check = std::function<std::optional<Status>()>;

  /// The check that was added last is asked first.
  void add(Check check) { checks_.push_back(std::move(check)); }

  /// Why the motion must stop; std::nullopt while it may continue.
  [[nodiscard]] std::optional<Status> reason() const {
    for (auto check = checks_.rbegin(); check != checks_.rend(); ++check)
      if (auto reason = (*check)()) return reason;
    return std::nullopt;
  }
  [[nodiscard]] bool cancelled() const { return reason().has_value(); }

 private:
  std::vector<Check> checks_;
};

/// What a motion asks of its caller and reports to it.
struct MotionCallbacks {
  /// Asked at the monitor's rate.
  CancelToken cancel;
  /// Executed fraction of the trajectory in [0, 1]. May be empty.
  std::function<void(const std::string& stage, double executed)> progress;
  /// Allows contacts of this motion in the present world. May be empty.
  std::function<void(arm::CollisionWorld& world)> allow;
  /// Called with every trajectory before it is executed. May be empty.
  std::function<void(const trajectory_msgs::JointTrajectory& trajectory)> planned;
};

}  // namespace extperfc::ros_arm
