#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include <nav_msgs/OccupancyGrid.h>
#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"

#include "ros/localize/localizer_inbox.hpp"
#include "ros/params/localizer_params.hpp"

namespace extperfc::ros_localize {

/// Source of the map: the file map_file, the topic `map`, or, as with amcl, the service `static_map`, which
/// is called until it answers. `on_map` is called from a callback or a thread of this class.
class MapSource {
 public:
  using OnMap = std::function<void(MapPtr)>;
  MapSource(const ros::NodeHandle& handle, const ros_params::LocalizerNodeParams& params, OnMap on_map);
  ~MapSource();
  MapSource(const MapSource&) = delete;
  MapSource& operator=(const MapSource&) = delete;

  /// Starts. Errors: a map_file that cannot be read.
  [[nodiscard]] Result<void> start();
  void stop();

  /// Why there is no usable map: the last map's error, or the source it waits for; empty after a good map.
  [[nodiscard]] std::string problem() const;

 private:
  void on_message(const nav_msgs::OccupancyGridConstPtr& message);
  void accept(const nav_msgs::OccupancyGrid& message);
  void ask_until_answered();
  bool ask();
  [[nodiscard]] bool stopped_within(double seconds);
  void say(const std::string& problem);

  ros::NodeHandle handle_;
  const std::string file_;
  const bool use_topic_;
  const bool first_only_;
  const std::string global_frame_;
  const OnMap on_map_;
  ros::Subscriber subscriber_;
  std::thread thread_;

  mutable std::mutex mutex_;
  std::condition_variable stopping_;
  bool stopped_{false};
  bool has_map_{false};
  std::string problem_;
  ros::ServiceClient client_;  ///< of a call that lasts; shut down to end it
};

}  // namespace extperfc::ros_localize
