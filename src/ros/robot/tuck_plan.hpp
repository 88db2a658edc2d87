#pragma once

#include <array>

#include "extperfc/simulate/robot_io.hpp"
#include "extperfc/simulate/trajectory_goal.hpp"

namespace extperfc::ros_robot {

/// Poses of Baxter's own tuck program [rad].
[[nodiscard]] simulate::ArmValues tucked_pose(simulate::Side side);
[[nodiscard]] simulate::ArmValues untucked_pose(simulate::Side side);

struct TuckSpeed {
  double velocity_rad_s{0.75};  ///< of the fastest joint, > 0
  double accel_rad_s2{2.0};     ///< of the fastest joint, > 0
};

/// How both arms get from where they are to the tucked or untucked pose without hitting each other or the
/// body: through `untucked`, which keeps them apart in front, and from anywhere else through `neutral`
/// before, which spreads them. Both arms reach each pose together and rest there for an instant; an arm that
/// needs fewer of them waits. Indexed by Side.
[[nodiscard]] std::array<simulate::TrajectoryGoal, 2> plan_tuck(
    bool tuck, const std::array<simulate::ArmValues, 2>& from, const TuckSpeed& speed);

}  // namespace extperfc::ros_robot
