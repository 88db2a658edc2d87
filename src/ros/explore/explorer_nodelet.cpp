#include <stdexcept>

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include "ros/explore/explorer.hpp"

namespace extperfc::ros_explore {

/// Explorer as a nodelet.
class ExplorerNodelet : public nodelet::Nodelet {
 private:
  void onInit() override {
    const auto params = ros_params::load_explorer_params(getPrivateNodeHandle());
    if (!params) {
      NODELET_FATAL("%s", params.error().message.c_str());
      throw std::runtime_error(params.error().message);
    }
    explorer_ = std::make_unique<Explorer>(getMTNodeHandle(), getPrivateNodeHandle(), *params, getName());
  }

  std::unique_ptr<Explorer> explorer_;
};

}  // namespace extperfc::ros_explore

PLUGINLIB_EXPORT_CLASS(extperfc::ros_explore::ExplorerNodelet, nodelet::Nodelet)
