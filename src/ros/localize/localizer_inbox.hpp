#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <variant>

#include <Eigen/Core>
#include <ros/time.h>
#include <sensor_msgs/LaserScan.h>

#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::ros_localize {

/// An initial pose: pose of the base in the map at a time.
struct GivenPose {
  ros::Time stamp;  ///< zero: now
  Pose2 pose;
  Eigen::Matrix3d covariance{Eigen::Matrix3d::Zero()};
};
struct GlobalInitialization {};  ///< global localization: particles on the whole map

using Placement = std::variant<GivenPose, GlobalInitialization>;
using MapPtr = std::shared_ptr<const OccupancyGrid>;

/// Pending work for the worker, processed in this order.
struct Work {
  bool time_ran_back{false};
  MapPtr map;                          ///< null: none came
  std::optional<Placement> placement;  ///< the latest
  bool force{false};                   ///< update without motion
  sensor_msgs::LaserScanConstPtr scan;
};

/// Mailbox between the callbacks, which only store, and the worker. A newer item replaces a waiting one of
/// the same kind, so it holds five items at most. Any number of threads may store; one takes.
class LocalizerInbox {
 public:
  void put_map(MapPtr map, std::optional<Placement> placement = std::nullopt) {
    change([&](Work& work) {
      work.map = std::move(map);
      if (placement) work.placement = std::move(placement);
    });
  }
  void put_placement(Placement placement) {
    change([&](Work& work) { work.placement = std::move(placement); });
  }
  void put_force() {
    change([](Work& work) { work.force = true; });
  }
  void put_time_jump() {
    change([](Work& work) {
      work.time_ran_back = true;
      work.scan.reset();  // of the time before
    });
  }
  void put_scan(sensor_msgs::LaserScanConstPtr scan) {
    change([&](Work& work) {
      if (work.scan) ++dropped_;
      work.scan = std::move(scan);
    });
  }

  /// Waits for work. No value: closed.
  [[nodiscard]] std::optional<Work> take() {
    std::unique_lock lock(mutex_);
    ready_.wait(lock, [this] { return waiting_ || closed_; });
    if (closed_) return std::nullopt;
    return std::exchange(waiting_, std::nullopt);
  }

  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    ready_.notify_all();
  }

  /// Scans that were replaced before the worker took them.
  [[nodiscard]] std::uint64_t dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }

 private:
  template <typename Change>
  void change(const Change& apply) {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    if (!waiting_) waiting_.emplace();
    apply(*waiting_);
    ready_.notify_one();
  }

  mutable std::mutex mutex_;
  std::condition_variable ready_;
  std::optional<Work> waiting_;
  std::uint64_t dropped_{0};
  bool closed_{false};
};

}  // namespace extperfc::ros_localize
