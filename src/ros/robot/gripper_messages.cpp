#include "ros/robot/gripper_messages.hpp"

#include <map>

#include <nlohmann/json.hpp>

namespace extperfc::ros_robot {

namespace {

using baxter_core_msgs::EndEffectorCommand;
using baxter_core_msgs::EndEffectorProperties;
using baxter_core_msgs::EndEffectorState;
using simulate::GripperCommand;
using Kind = GripperCommand::Kind;
using Arguments = std::map<std::string, double>;

Result<Arguments> parse_arguments(const std::string& text) {
  Arguments arguments;
  if (text.empty()) return arguments;
  const auto wrong = [&](const std::string& what) {
    return fail(ErrorCode::kInvalidArgument,
                "args '" + text.substr(0, 100) + "' " + what + R"(; an example is {"position": 50.0})");
  };
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object()) return wrong("are not a JSON object");
  for (const auto& [name, value] : json.items()) {
    if (!value.is_number()) return wrong("have no number for '" + name + "'");
    const double number = value;
    if (!(number >= 0 && number <= 100)) return wrong("have " + name + " outside [0, 100] per cent");
    arguments[name] = number;
  }
  return arguments;
}

std::optional<Kind> kind_of(const std::string& command) {
  static const std::map<std::string, Kind> kKinds{
      {EndEffectorCommand::CMD_NO_OP, Kind::kNoop},
      {EndEffectorCommand::CMD_SET, Kind::kConfigure},
      {EndEffectorCommand::CMD_CONFIGURE, Kind::kConfigure},
      {EndEffectorCommand::CMD_REBOOT, Kind::kReboot},
      {EndEffectorCommand::CMD_RESET, Kind::kReset},
      {EndEffectorCommand::CMD_CALIBRATE, Kind::kCalibrate},
      {EndEffectorCommand::CMD_CLEAR_CALIBRATION, Kind::kClearCalibration},
      {EndEffectorCommand::CMD_PREPARE_TO_GRIP, Kind::kGoTo},
      {EndEffectorCommand::CMD_GRIP, Kind::kGoTo},
      {EndEffectorCommand::CMD_RELEASE, Kind::kGoTo},
      {EndEffectorCommand::CMD_GO, Kind::kGoTo},
      {EndEffectorCommand::CMD_STOP, Kind::kStop}};
  const auto found = kKinds.find(command);
  if (found == kKinds.end()) return std::nullopt;
  return found->second;
}

/// Takes an argument out.
std::optional<double> take(Arguments& arguments, const char* name) {
  const auto found = arguments.find(name);
  if (found == arguments.end()) return std::nullopt;
  const double value = found->second;
  arguments.erase(found);
  return value;
}

std::uint8_t flag(bool value) {
  return value ? EndEffectorState::STATE_TRUE : EndEffectorState::STATE_FALSE;
}

}  // namespace

Result<GripperCommand> from_message(const EndEffectorCommand& message) {
  const auto refuse = [](const std::string& what) { return fail(ErrorCode::kInvalidArgument, what); };
  if (message.id != kGripperId)
    return refuse("id " + std::to_string(message.id) + " is another gripper's; this one is " +
                  std::to_string(kGripperId));
  const auto kind = kind_of(message.command);
  if (!kind) return refuse("'" + message.command + "' is no command of an electric gripper");
  auto arguments = parse_arguments(message.args);
  if (!arguments) return tl::unexpected(arguments.error());

  GripperCommand command;
  command.kind = *kind;
  const auto position = take(*arguments, "position");
  if (message.command == EndEffectorCommand::CMD_GO) {
    if (!position) return refuse(R"('go' needs args with a position, e.g. {"position": 50.0})");
    command.position_percent = *position;
  } else {
    command.position_percent = message.command == EndEffectorCommand::CMD_GRIP ? 0.0 : 100.0;
  }
  command.velocity_percent = take(*arguments, "velocity");
  command.moving_force_percent = take(*arguments, "moving_force");
  command.holding_force_percent = take(*arguments, "holding_force");
  command.dead_zone_percent = take(*arguments, "dead_zone");
  if (!arguments->empty())
    return refuse("'" + arguments->begin()->first +
                  "' is no argument; known are position, velocity, moving_force, holding_force, dead_zone");
  return command;
}

EndEffectorState to_message(const simulate::GripperState& state, bool enabled, const ros::Time& stamp) {
  EndEffectorState message;
  message.timestamp = stamp;
  message.id = kGripperId;
  message.enabled = flag(enabled);
  message.calibrated = flag(state.calibrated);
  message.ready = flag(state.ready);
  message.moving = flag(state.moving);
  message.gripping = flag(state.gripping);
  message.missed = flag(state.missed);
  message.error = flag(state.error);
  message.reverse = EndEffectorState::STATE_FALSE;
  message.position = static_cast<float>(state.position_percent);
  message.force = static_cast<float>(state.force_percent);
  return message;
}

EndEffectorProperties gripper_properties() {
  EndEffectorProperties message;
  message.id = kGripperId;
  message.ui_type = EndEffectorProperties::ELECTRIC_GRIPPER;
  message.manufacturer = "extperfc";
  message.product = "simulated electric parallel gripper";
  message.has_calibration = true;
  message.controls_grip = true;
  message.senses_grip = true;
  message.reverses_grip = false;
  message.controls_force = true;
  message.senses_force = true;
  message.controls_position = true;
  message.senses_position = true;
  return message;
}

}  // namespace extperfc::ros_robot
