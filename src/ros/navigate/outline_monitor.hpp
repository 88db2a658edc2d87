#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <ros/node_handle.h>
#include <sensor_msgs/JointState.h>

#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/overhang.hpp"

#include "ros/params/navigator_params.hpp"

namespace extperfc::ros_navigate {

/// The robot's footprint now: that of the parameters, the arms that stick out of it by the joint states, and
/// the padding. Thread-safe.
class OutlineMonitor {
 public:
  using FootprintPtr = std::shared_ptr<const navigate::Footprint>;

  /// Without a robot description the arms do not count, and problem() says so.
  OutlineMonitor(ros::NodeHandle handle, const ros::NodeHandle& private_handle,
                 const ros_params::NavigatorNodeParams& params);
  ~OutlineMonitor() { subscriber_.shutdown(); }
  OutlineMonitor(const OutlineMonitor&) = delete;
  OutlineMonitor& operator=(const OutlineMonitor&) = delete;

  [[nodiscard]] FootprintPtr footprint() const;
  /// Without padding.
  [[nodiscard]] FootprintPtr bare() const;
  /// Of the arms, the last that was seen [m]: how far the footprint reaches beyond that of the parameters.
  [[nodiscard]] double overhang_m() const;
  [[nodiscard]] std::string problem() const { return problem_; }
  void set_params(const ros_params::NavigatorNodeParams& params);

 private:
  void on_joints(const sensor_msgs::JointState& message);
  void rebuild();

  std::string problem_;
  std::optional<navigate::Overhang> overhang_;
  mutable std::mutex mutex_;  ///< guards what follows
  navigate::Footprint base_;
  double padding_m_;
  std::map<std::string, double> positions_;
  FootprintPtr footprint_;
  FootprintPtr bare_;
  double overhang_m_{0};
  ros::WallTime computed_;
  ros::Subscriber subscriber_;
};

}  // namespace extperfc::ros_navigate
