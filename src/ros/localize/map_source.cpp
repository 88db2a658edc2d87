#include "ros/localize/map_source.hpp"

#include <chrono>
#include <utility>

#include <nav_msgs/GetMap.h>
#include <ros/console.h>
#include <ros/service.h>

#include "extperfc/sources/mrpt_map.hpp"
#include "extperfc/world/map_file.hpp"

#include "ros/convert/occupancy_grid.hpp"

namespace extperfc::ros_localize {

namespace {
constexpr const char* kTopic = "map";
constexpr const char* kService = "static_map";
constexpr double kAskAgainS = 0.5;
}  // namespace

MapSource::MapSource(const ros::NodeHandle& handle, const ros_params::LocalizerNodeParams& params,
                     OnMap on_map)
    : handle_(handle),
      file_(params.map_file),
      use_topic_(params.use_map_topic),
      first_only_(params.first_map_only),
      global_frame_(params.global_frame),
      on_map_(std::move(on_map)) {}

MapSource::~MapSource() {
  stop();
}

Result<void> MapSource::start() {
  if (!file_.empty()) {
    auto map = sources::names_gridmap(file_) ? sources::load_gridmap(file_) : load_map(file_);
    if (!map) return tl::unexpected(map.error());
    on_map_(std::make_shared<const OccupancyGrid>(std::move(*map)));
    return {};
  }
  if (use_topic_) {
    say("no map yet: waiting for the topic " + handle_.resolveName(kTopic));
    subscriber_ = handle_.subscribe(kTopic, 1, &MapSource::on_message, this);
    return {};
  }
  say("no map yet: waiting for the service " + handle_.resolveName(kService));
  thread_ = std::thread([this] { ask_until_answered(); });
  return {};
}

void MapSource::stop() {
  subscriber_.shutdown();
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    client_.shutdown();
  }
  stopping_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::string MapSource::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

void MapSource::on_message(const nav_msgs::OccupancyGridConstPtr& message) {
  {
    const std::lock_guard lock(mutex_);
    if (has_map_ && first_only_) return;
  }
  accept(*message);
}

void MapSource::accept(const nav_msgs::OccupancyGrid& message) {
  auto map = ros_convert::to_occupancy_grid(message);
  if (!map) {
    ROS_ERROR("%s", map.error().message.c_str());
    return say(map.error().message);
  }
  if (!message.header.frame_id.empty() && message.header.frame_id != global_frame_)
    ROS_WARN("the map's frame is %s, but global_frame_id is %s: using the map in %s",
             message.header.frame_id.c_str(), global_frame_.c_str(), global_frame_.c_str());
  {
    const std::lock_guard lock(mutex_);
    has_map_ = true;
    problem_.clear();
  }
  on_map_(std::make_shared<const OccupancyGrid>(std::move(*map)));
}

void MapSource::ask_until_answered() {
  while (!ask())
    if (stopped_within(kAskAgainS)) return;
}

/// A persistent client: unlike others it can be shut down while a call lasts.
bool MapSource::ask() {
  if (!ros::service::exists(handle_.resolveName(kService), false)) return false;
  ros::ServiceClient client = handle_.serviceClient<nav_msgs::GetMap>(kService, true);
  {
    const std::lock_guard lock(mutex_);
    if (stopped_) return true;
    client_ = client;
  }
  nav_msgs::GetMap service;
  if (!client.call(service)) return false;
  accept(service.response.map);
  const std::lock_guard lock(mutex_);
  return has_map_ || stopped_;
}

bool MapSource::stopped_within(double seconds) {
  std::unique_lock lock(mutex_);
  return stopping_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return stopped_; });
}

void MapSource::say(const std::string& problem) {
  const std::lock_guard lock(mutex_);
  problem_ = problem;
}

}  // namespace extperfc::ros_localize
