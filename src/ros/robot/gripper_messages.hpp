#pragma once

#include <optional>
#include <string>

#include <baxter_core_msgs/EndEffectorCommand.h>
#include <baxter_core_msgs/EndEffectorProperties.h>
#include <baxter_core_msgs/EndEffectorState.h>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/robot_io.hpp"

/// Messages of Baxter's electric gripper <-> the simulator's types.
namespace extperfc::ros_robot {

inline constexpr std::uint32_t kGripperId = 65664;  ///< hardware id of both simulated grippers

/// Commands and their arguments: go {"position": 0..100}; set or configure {"velocity", "moving_force",
/// "holding_force", "dead_zone": 0..100 each, "position": left out}; grip closes, release and
/// prepare_to_grip open; the others have none. Errors: another gripper's id, an unknown command, arguments
/// that are not a JSON object of numbers, a missing or unknown argument, a value out of [0, 100].
[[nodiscard]] Result<simulate::GripperCommand> from_message(
    const baxter_core_msgs::EndEffectorCommand& message);

/// State of the hand without what was commanded last.
[[nodiscard]] baxter_core_msgs::EndEffectorState to_message(const simulate::GripperState& state, bool enabled,
                                                            const ros::Time& stamp);
[[nodiscard]] baxter_core_msgs::EndEffectorProperties gripper_properties();

}  // namespace extperfc::ros_robot
