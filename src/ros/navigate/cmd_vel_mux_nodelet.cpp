#include <memory>
#include <stdexcept>

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include "ros/navigate/cmd_vel_mux_node.hpp"

namespace extperfc::ros_navigate {

/// CmdVelMuxNode as a nodelet.
class CmdVelMuxNodelet : public nodelet::Nodelet {
 private:
  void onInit() override {
    auto node = CmdVelMuxNode::make(getNodeHandle(), getPrivateNodeHandle(), getName());
    if (!node) {
      NODELET_FATAL("%s", node.error().message.c_str());
      throw std::runtime_error(node.error().message);
    }
    node_ = std::move(*node);
  }

  std::unique_ptr<CmdVelMuxNode> node_;
};

}  // namespace extperfc::ros_navigate

PLUGINLIB_EXPORT_CLASS(extperfc::ros_navigate::CmdVelMuxNodelet, nodelet::Nodelet)
