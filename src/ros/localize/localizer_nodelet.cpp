#include <memory>
#include <stdexcept>

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include "ros/localize/localizer_node.hpp"

namespace extperfc {

/// LocalizerNode as a nodelet.
class LocalizerNodelet : public nodelet::Nodelet {
 private:
  void onInit() override {
    auto node = localizer::LocalizerNode::make(getNodeHandle(), getPrivateNodeHandle(), getName());
    if (!node) {
      NODELET_FATAL("%s", node.error().message.c_str());
      throw std::runtime_error(node.error().message);
    }
    node_ = std::move(*node);
  }

  std::unique_ptr<localizer::LocalizerNode> node_;
};

}  // namespace extperfc

PLUGINLIB_EXPORT_CLASS(extperfc::LocalizerNodelet, nodelet::Nodelet)
