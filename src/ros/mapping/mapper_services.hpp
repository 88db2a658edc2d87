#pragma once

#include <functional>
#include <string>
#include <vector>

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/GetMap.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include "extperfc/LoadSession.h"
#include "extperfc/SaveMap.h"

#include "ros/mapping/map_publisher.hpp"
#include "ros/mapping/shared_mapper.hpp"

namespace extperfc::ros_mapping {

/// dynamic_map, ~save_map, ~optimize, ~load_session, ~set_localization, ~pause, ~resume and ~reset, whose
/// answers name what was wrong; the topic initialpose; and the searches that join parts of the map.
class MapperServices {
 public:
  struct Callbacks {
    std::function<void(bool)> pause;
    std::function<void()> restarted;  ///< the mapper is another one
  };

  /// Calls run in a separate thread, because saving takes long. Not in the nodelet manager's, whose second
  /// queue may be gone before a nodelet that is unloaded while one of its callbacks runs.
  MapperServices(ros::NodeHandle handle, ros::NodeHandle private_handle, const mapping::MapperParams& params,
                 std::string map_frame, SharedMapper& mapper, MapPublisher& maps, Callbacks callbacks);
  ~MapperServices() { stop(); }
  MapperServices(const MapperServices&) = delete;
  MapperServices& operator=(const MapperServices&) = delete;

  /// No call begins afterwards. Harmless twice.
  void stop();

 private:
  using Trigger = std_srvs::Trigger;

  bool dynamic_map(nav_msgs::GetMap::Request& request, nav_msgs::GetMap::Response& response);
  bool save_map(SaveMap::Request& request, SaveMap::Response& response);
  bool load_session(LoadSession::Request& request, LoadSession::Response& response);
  void search_for_loops();
  void join_parts();
  void put_at(const geometry_msgs::PoseWithCovarianceStamped& message);
  bool optimize(Trigger::Request& request, Trigger::Response& response);
  bool set_localization(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  bool pause(Trigger::Request& request, Trigger::Response& response);
  bool resume(Trigger::Request& request, Trigger::Response& response);
  bool reset(Trigger::Request& request, Trigger::Response& response);
  Result<std::string> save(const std::string& path);

  const mapping::MapperParams params_;
  const std::string map_frame_;
  SharedMapper& mapper_;
  MapPublisher& maps_;
  const Callbacks callbacks_;
  ros::CallbackQueue queue_;
  std::vector<ros::ServiceServer> servers_;
  ros::Subscriber initial_pose_subscriber_;
  ros::WallTimer join_timer_;
  ros::AsyncSpinner spinner_{1, &queue_};
};

}  // namespace extperfc::ros_mapping
