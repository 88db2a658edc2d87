#include "offline/tool/recording_options.hpp"

namespace extperfc::offline {

std::set<std::string> with_recording_options(std::set<std::string> options) {
  options.insert({"--scan-topic", "--odom-topic", "--base-frame", "--odom-frame", "--sensor"});
  return options;
}

RecordingOptions recording_options(const Arguments& arguments) {
  RecordingOptions reading;
  reading.log.sensor_label = arguments.last("--sensor").value_or("");
  reading.scan_topic = arguments.last("--scan-topic").value_or("");
  reading.odom_topic = arguments.last("--odom-topic").value_or("");
  reading.base_frame = arguments.last("--base-frame").value_or(reading.base_frame);
  reading.odom_frame = arguments.last("--odom-frame").value_or(reading.odom_frame);
  return reading;
}

Result<void> read_pose(const Arguments& arguments, const std::string& option, std::optional<Pose2>& pose) {
  const auto numbers = arguments.numbers(option, 3);
  if (!numbers) return tl::unexpected(numbers.error());
  if (*numbers) pose = Pose2{(**numbers)[0], (**numbers)[1], (**numbers)[2]};
  return {};
}

}  // namespace extperfc::offline
