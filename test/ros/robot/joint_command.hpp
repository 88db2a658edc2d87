#pragma once

#include <string>
#include <utility>
#include <vector>

#include <baxter_core_msgs/JointCommand.h>

namespace extperfc::ros_test {

[[nodiscard]] inline baxter_core_msgs::JointCommand joint_command(int mode, std::vector<std::string> names,
                                                                  std::vector<double> values) {
  baxter_core_msgs::JointCommand message;
  message.mode = mode;
  message.names = std::move(names);
  message.command = std::move(values);
  return message;
}

}  // namespace extperfc::ros_test
