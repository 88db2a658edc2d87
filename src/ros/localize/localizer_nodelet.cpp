#include <memory>
#include <stdexcept>

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include "ros/localize/localizer_node.hpp"

namespace extperfc::ros_localize {

/// LocalizerNode as a nodelet.
class LocalizerNodelet : public nodelet::Nodelet {
 private:
  void onInit() override {
    auto node = LocalizerNode::make(getNodeHandle(), getPrivateNodeHandle(), getName());
    if (!node) {
      NODELET_FATAL("%s", node.error().message.c_str());
      throw std::runtime_error(node.error().message);
    }
    node_ = std::move(*node);
  }

  std::unique_ptr<LocalizerNode> node_;
};

}  // namespace extperfc::ros_localize

PLUGINLIB_EXPORT_CLASS(extperfc::ros_localize::LocalizerNodelet, nodelet::Nodelet)
