#pragma once

#include <memory>
#include <optional>
#include <string>

#include <nav_msgs/GetMap.h>
#include <nav_msgs/LoadMap.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/node_handle.h>

#include "extperfc/world/floors.hpp"

#include "ros/health/reporter.hpp"
#include "ros/params/map_server_params.hpp"

namespace extperfc::ros_map_server {

/// Serves a map, with map_server's topics and services; changes between the floors of a building by name.
/// Also a program: rosrun extperfc map_server MAP.yaml.
///
/// Publishes:
///   map           nav_msgs/OccupancyGrid, latched, after start-up and each change
///   map_metadata  nav_msgs/MapMetaData, latched, with it
///   diagnostics   diagnostic_msgs/DiagnosticArray
/// Services:
///   static_map  nav_msgs/GetMap
///   change_map  nav_msgs/LoadMap: map_url is the name of a floor or the YAML file of a map (also with
///               file://); the map stays when it cannot be loaded, and the log says why
/// Parameters: config/map_server.yaml.
/// Frames: the map is in frame_id.
/// Diagnostics: floor, size and resolution of the map; maps that could not be loaded.
/// Threads: one callback at a time; loading takes some 10 ms for a million cells.
class MapServerNode {
 public:
  /// `map_file`: of the command line; empty: the parameters say. Errors: bad parameters, a map that cannot be
  /// loaded.
  [[nodiscard]] static Result<std::unique_ptr<MapServerNode>> make(const ros::NodeHandle& handle,
                                                                   const ros::NodeHandle& private_handle,
                                                                   const std::string& name,
                                                                   const std::string& map_file = "");
  MapServerNode(const MapServerNode&) = delete;
  MapServerNode& operator=(const MapServerNode&) = delete;

 private:
  MapServerNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                ros_params::MapServerParams params, const std::string& name);
  Result<void> start();
  /// The name of a floor or a file.
  Result<void> load(const std::string& map);
  bool on_change_map(nav_msgs::LoadMap::Request& request, nav_msgs::LoadMap::Response& response);
  bool on_static_map(nav_msgs::GetMap::Request&, nav_msgs::GetMap::Response& response);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status) const;

  ros::NodeHandle handle_;
  const ros_params::MapServerParams params_;
  std::optional<Floors> floors_;
  std::string source_;  ///< of the map: floor or file
  nav_msgs::OccupancyGridConstPtr map_;
  std::uint64_t failures_{0};
  std::string last_failure_;

  ros::Publisher map_publisher_;
  ros::Publisher metadata_publisher_;
  ros::ServiceServer static_map_;
  ros::ServiceServer change_map_;
  ros_health::Reporter reporter_;
};

}  // namespace extperfc::ros_map_server
