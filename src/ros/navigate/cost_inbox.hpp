#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

#include <map_msgs/OccupancyGridUpdate.h>
#include <nav_msgs/OccupancyGrid.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>

namespace extperfc::ros_navigate {

/// Pending work for the cost maps, processed in this order.
struct CostWork {
  bool forget{false};  ///< everything that sensors saw
  nav_msgs::OccupancyGridConstPtr map;
  std::deque<map_msgs::OccupancyGridUpdateConstPtr> map_updates;  ///< of that map
  sensor_msgs::PointCloud2ConstPtr cloud;
  sensor_msgs::LaserScanConstPtr scan;
};

/// Mailbox between callbacks, which only store, and the worker of the cost maps. A newer scan, cloud or map
/// replaces a waiting one. Any number of threads may store; one takes.
class CostInbox {
 public:
  void put_map(nav_msgs::OccupancyGridConstPtr map) {
    change([&](CostWork& work) {
      work.map = std::move(map);
      work.map_updates.clear();
    });
  }
  void put_map_update(map_msgs::OccupancyGridUpdateConstPtr update) {
    change([&](CostWork& work) {
      if (work.map_updates.size() < kMaxUpdates) work.map_updates.push_back(std::move(update));
    });
  }
  void put_scan(sensor_msgs::LaserScanConstPtr scan) {
    change([&](CostWork& work) {
      if (work.scan) ++dropped_;
      work.scan = std::move(scan);
    });
  }
  void put_cloud(sensor_msgs::PointCloud2ConstPtr cloud) {
    change([&](CostWork& work) {
      if (work.cloud) ++dropped_;
      work.cloud = std::move(cloud);
    });
  }
  void put_forget() {
    change([](CostWork& work) {
      work.forget = true;
      work.scan.reset();
      work.cloud.reset();
    });
  }

  /// Waits for work. No value: closed.
  [[nodiscard]] std::optional<CostWork> take() {
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
  /// Scans and clouds that were replaced before the worker took them.
  [[nodiscard]] std::uint64_t dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }

 private:
  static constexpr std::size_t kMaxUpdates = 100;

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
  std::optional<CostWork> waiting_;
  std::uint64_t dropped_{0};
  bool closed_{false};
};

}  // namespace extperfc::ros_navigate
