#include "ros/mapping/map_publisher.hpp"

#include <algorithm>
#include <utility>

#include <nav_msgs/MapMetaData.h>
#include <nav_msgs/Path.h>

#include "extperfc/base/stopwatch.hpp"

#include "ros/convert/occupancy_grid.hpp"
#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_mapping {

namespace {

constexpr bool kLatched = true;
constexpr double kSettlingPauseS = 0.05;  ///< between the steps of settling after a loop closure
constexpr double kMaxCpuLoad = 0.1;       ///< of a core
constexpr double kLatestStampS = 4.29e9;  ///< ros::Time cannot hold later ones, and throws

std::chrono::steady_clock::duration seconds(double value) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(value));
}

}  // namespace

MapPublisher::MapPublisher(ros::NodeHandle handle, SharedMapper& mapper, Options options)
    : mapper_(mapper),
      options_(std::move(options)),
      map_publisher_(handle.advertise<nav_msgs::OccupancyGrid>("map", 1, kLatched)),
      metadata_publisher_(handle.advertise<nav_msgs::MapMetaData>("map_metadata", 1, kLatched)) {
  const auto connected = [this](const ros::SingleSubscriberPublisher&) {
    const std::lock_guard lock(mutex_);
    trajectory_wanted_ = !stamp_.isZero();
    wake_.notify_all();
  };
  trajectory_publisher_ = handle.advertise<nav_msgs::Path>("trajectory", 1, connected);
  thread_ = std::thread([this] { run(); });
}

MapPublisher::~MapPublisher() {
  stop();
}

void MapPublisher::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void MapPublisher::changed(const ros::Time& stamp) {
  {
    const std::lock_guard lock(mutex_);
    stamp_ = stamp;
    map_wanted_ = trajectory_wanted_ = true;
  }
  wake_.notify_all();
}

void MapPublisher::restart() {
  {
    const std::lock_guard lock(mutex_);
    restarted_ = true;
    map_wanted_ = trajectory_wanted_ = settling_wanted_ = false;
    map_due_ = Clock::time_point::min();
  }
  wake_.notify_all();
}

void MapPublisher::run() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const auto now = Clock::now();
    const bool map = map_wanted_ && now >= map_due_;
    const bool settling = !map && settling_wanted_ && now >= settling_due_;
    const bool trajectory = trajectory_wanted_ && now >= trajectory_due_;
    if (!map && !settling && !trajectory) {
      auto next = now + seconds(3600.0);
      if (map_wanted_) next = std::min(next, map_due_);
      if (settling_wanted_) next = std::min(next, settling_due_);
      if (trajectory_wanted_) next = std::min(next, trajectory_due_);
      wake_.wait_until(lock, next);
      continue;
    }
    map_wanted_ = map_wanted_ && !map;
    settling_wanted_ = settling_wanted_ && !settling;
    trajectory_wanted_ = trajectory_wanted_ && !trajectory;
    if (std::exchange(restarted_, false)) published_ = false;
    const auto stamp = stamp_;
    lock.unlock();
    if (map) publish_map(stamp);
    if (settling) settle();
    if (trajectory) publish_trajectory(stamp);
    lock.lock();
  }
}

std::shared_ptr<const OccupancyGrid> MapPublisher::take_map() {
  double held_ms = 0;
  bool settled = true;
  auto map = mapper_.with([&](mapping::Mapper& mapper) {
    const Stopwatch watch;
    auto taken = mapper.map();
    settled = mapper.settled();
    held_ms = watch.milliseconds();
    return taken;
  });
  const std::lock_guard lock(mutex_);
  statistics_.held_ms = held_ms;
  statistics_.longest_held_ms = std::max(statistics_.longest_held_ms, held_ms);
  if (!settled) {
    map_wanted_ = settling_wanted_ = true;
    settling_due_ = Clock::now() + seconds(std::max(kSettlingPauseS, 1e-3 * held_ms / kMaxCpuLoad));
  }
  return map && !map->empty() ? map : nullptr;
}

void MapPublisher::settle() {
  (void)take_map();
}

void MapPublisher::publish_map(const ros::Time& stamp) {
  const auto version = mapper_.with([](const mapping::Mapper& mapper) { return mapper.map_version(); });
  if (published_ && version == version_) return;
  const auto map = take_map();
  if (!map) return;
  const Stopwatch watch;
  std_msgs::Header header;
  header.frame_id = options_.map_frame;
  header.stamp = stamp;
  const auto message = boost::make_shared<nav_msgs::OccupancyGrid>(ros_convert::to_message(*map, header));
  message->info.map_load_time = stamp;
  map_publisher_.publish(message);
  metadata_publisher_.publish(message->info);
  published_ = true;
  version_ = version;
  const std::lock_guard lock(mutex_);
  statistics_.build_ms = watch.milliseconds();
  const double cost_s = 1e-3 * (statistics_.build_ms + statistics_.held_ms);
  map_due_ = Clock::now() + seconds(std::max(options_.interval_s, cost_s / kMaxCpuLoad));
  ++statistics_.maps;
  statistics_.width = map->width;
  statistics_.height = map->height;
  statistics_.resolution_m = map->resolution_m;
}

void MapPublisher::publish_trajectory(const ros::Time& stamp) {
  if (trajectory_publisher_.getNumSubscribers() == 0) return;
  const Stopwatch watch;
  const auto trajectory = mapper_.with([](const mapping::Mapper& mapper) { return mapper.trajectory(); });
  const auto message = boost::make_shared<nav_msgs::Path>();
  message->header.frame_id = options_.map_frame;
  message->header.stamp = stamp;
  const std::size_t stride = 1 + trajectory.size() / kMaxPoses;
  for (std::size_t i = trajectory.size() % stride; i < trajectory.size(); i += stride) {
    geometry_msgs::PoseStamped pose;
    pose.header.frame_id = options_.map_frame;
    pose.header.stamp.fromSec(std::clamp(trajectory[i].stamp_s, 0.0, kLatestStampS));
    pose.pose = ros_convert::to_pose_message(trajectory[i].pose);
    message->poses.push_back(pose);
  }
  trajectory_publisher_.publish(message);
  const std::lock_guard lock(mutex_);
  trajectory_due_ =
      Clock::now() + seconds(std::max(options_.trajectory_interval_s, watch.seconds() / kMaxCpuLoad));
}

bool MapPublisher::current(nav_msgs::OccupancyGrid& message) {
  const auto map = take_map();
  if (!map) return false;
  std_msgs::Header header;
  header.frame_id = options_.map_frame;
  {
    const std::lock_guard lock(mutex_);
    header.stamp = stamp_;
  }
  message = ros_convert::to_message(*map, header);
  message.info.map_load_time = header.stamp;
  return true;
}

std::shared_ptr<const OccupancyGrid> MapPublisher::settled_map(double patience_s) {
  const Stopwatch watch;
  auto map = take_map();
  while (!mapper_.with([](const mapping::Mapper& mapper) { return mapper.settled(); }) &&
         watch.seconds() < patience_s)
    map = take_map();
  return map;
}

MapPublisher::Statistics MapPublisher::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

}  // namespace extperfc::ros_mapping
