#include <memory>
#include <stdexcept>

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include "ros/map_server/map_server_node.hpp"

namespace extperfc::ros_map_server {

/// MapServerNode as a nodelet.
class MapServerNodelet : public nodelet::Nodelet {
 private:
  void onInit() override {
    auto node = MapServerNode::make(getNodeHandle(), getPrivateNodeHandle(), getName());
    if (!node) {
      NODELET_FATAL("%s", node.error().message.c_str());
      throw std::runtime_error(node.error().message);
    }
    node_ = std::move(*node);
  }

  std::unique_ptr<MapServerNode> node_;
};

}  // namespace extperfc::ros_map_server

PLUGINLIB_EXPORT_CLASS(extperfc::ros_map_server::MapServerNodelet, nodelet::Nodelet)
