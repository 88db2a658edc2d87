#include <memory>
#include <stdexcept>

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include "ros/arm/arm_node.hpp"

namespace extperfc::ros_arm {

/// ArmNode as a nodelet.
class ArmNodelet : public nodelet::Nodelet {
 private:
  void onInit() override {
    auto node = ArmNode::make(getMTNodeHandle(), getMTPrivateNodeHandle(), getName());
    if (!node) {
      NODELET_FATAL("%s", node.error().message.c_str());
      throw std::runtime_error(node.error().message);
    }
    node_ = std::move(*node);
  }

  std::unique_ptr<ArmNode> node_;
};

}  // namespace extperfc::ros_arm

PLUGINLIB_EXPORT_CLASS(extperfc::ros_arm::ArmNodelet, nodelet::Nodelet)
