#include "ros/map_server/map_server_node.hpp"

#include <utility>

#include <nav_msgs/MapMetaData.h>

#include "extperfc/world/map_file.hpp"

#include "ros/convert/occupancy_grid.hpp"

namespace extperfc::ros_map_server {

namespace {

constexpr bool kLatched = true;

std::uint8_t result_of(ErrorCode code) {
  using Response = nav_msgs::LoadMap::Response;
  switch (code) {
    case ErrorCode::kNotFound:
      return Response::RESULT_MAP_DOES_NOT_EXIST;
    case ErrorCode::kCorrupt:
    case ErrorCode::kUnsupported:
      return Response::RESULT_INVALID_MAP_DATA;
    case ErrorCode::kInvalidArgument:
      return Response::RESULT_INVALID_MAP_METADATA;
    case ErrorCode::kFailed:
      break;
  }
  return Response::RESULT_UNDEFINED_FAILURE;
}

std::string without_scheme(const std::string& url) {
  static const std::string scheme = "file://";
  return url.rfind(scheme, 0) == 0 ? url.substr(scheme.size()) : url;
}

}  // namespace

Result<std::unique_ptr<MapServerNode>> MapServerNode::make(const ros::NodeHandle& handle,
                                                           const ros::NodeHandle& private_handle,
                                                           const std::string& name,
                                                           const std::string& map_file) {
  auto params = ros_params::load_map_server_params(private_handle, map_file);
  if (!params) return tl::unexpected(params.error());
  std::unique_ptr<MapServerNode> node(new MapServerNode(handle, private_handle, std::move(*params), name));
  if (auto started = node->start(); !started) return tl::unexpected(started.error());
  return node;
}

MapServerNode::MapServerNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                             ros_params::MapServerParams params, const std::string& name)
    : handle_(handle), params_(std::move(params)), reporter_(handle, private_handle, name) {}

Result<void> MapServerNode::start() {
  map_publisher_ = handle_.advertise<nav_msgs::OccupancyGrid>("map", 1, kLatched);
  metadata_publisher_ = handle_.advertise<nav_msgs::MapMetaData>("map_metadata", 1, kLatched);
  std::string first = params_.map_file;
  if (!params_.floors.empty()) {
    auto floors = Floors::read(params_.floors);
    if (!floors) return tl::unexpected(floors.error());
    floors_ = std::move(*floors);
    first = params_.floor.empty() ? floors_->names().front() : params_.floor;
    if (!floors_->has(first)) return tl::unexpected(floors_->load(first).error());
  }
  if (auto loaded = load(first); !loaded) return loaded;
  static_map_ = handle_.advertiseService("static_map", &MapServerNode::on_static_map, this);
  change_map_ = handle_.advertiseService("change_map", &MapServerNode::on_change_map, this);
  reporter_.add("map", [this](auto& status) { report(status); });
  reporter_.start();
  return {};
}

Result<void> MapServerNode::load(const std::string& map) {
  const bool is_floor = floors_ && floors_->has(map);
  const bool is_name = floors_ && !is_floor && map.find_first_of("/.") == std::string::npos;
  const auto loaded = is_floor || is_name ? floors_->load(map) : load_map(without_scheme(map));
  if (!loaded) {
    ++failures_;
    last_failure_ = loaded.error().message;
    return tl::unexpected(loaded.error());
  }
  std_msgs::Header header;
  header.frame_id = params_.frame_id;
  header.stamp = ros::Time::now();
  const auto message = boost::make_shared<nav_msgs::OccupancyGrid>(ros_convert::to_message(*loaded, header));
  message->info.map_load_time = header.stamp;
  map_ = message;
  source_ = map;
  map_publisher_.publish(message);
  metadata_publisher_.publish(message->info);
  return {};
}

bool MapServerNode::on_change_map(nav_msgs::LoadMap::Request& request,
                                  nav_msgs::LoadMap::Response& response) {
  const auto loaded = load(request.map_url);
  if (!loaded) {
    ROS_ERROR("the map stays: %s", loaded.error().message.c_str());
    response.result = result_of(loaded.error().code);
    return true;
  }
  response.map = *map_;
  response.result = nav_msgs::LoadMap::Response::RESULT_SUCCESS;
  return true;
}

bool MapServerNode::on_static_map(nav_msgs::GetMap::Request& /*request*/,
                                  nav_msgs::GetMap::Response& response) {
  response.map = *map_;
  return true;
}

void MapServerNode::report(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  status.summary(diagnostic_msgs::DiagnosticStatus::OK, "serving " + source_);
  status.add("map", source_);
  status.add("width", map_->info.width);
  status.add("height", map_->info.height);
  status.add("resolution", map_->info.resolution);
  status.add("failures", failures_);
  status.add("last failure", last_failure_);
}

}  // namespace extperfc::ros_map_server
