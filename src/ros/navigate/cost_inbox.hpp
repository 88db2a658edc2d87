#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

#include <map_msgs/OccupancyGridUpdate.h>
#include <nav_msgs/OccupancyGrid.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>

#include "extperfc/base/pending_work.hpp"

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
    pending_.change([&](CostWork& work) {
      work.map = std::move(map);
      work.map_updates.clear();
    });
  }
  void put_map_update(map_msgs::OccupancyGridUpdateConstPtr update) {
    pending_.change([&](CostWork& work) {
      if (work.map_updates.size() < kMaxUpdates) work.map_updates.push_back(std::move(update));
    });
  }
  void put_scan(sensor_msgs::LaserScanConstPtr scan) {
    pending_.change([&](CostWork& work) {
      if (work.scan) ++dropped_;
      work.scan = std::move(scan);
    });
  }
  void put_cloud(sensor_msgs::PointCloud2ConstPtr cloud) {
    pending_.change([&](CostWork& work) {
      if (work.cloud) ++dropped_;
      work.cloud = std::move(cloud);
    });
  }
  void put_forget() {
    pending_.change([](CostWork& work) {
      work.forget = true;
      work.scan.reset();
      work.cloud.reset();
    });
  }

  /// Waits for work. No value: closed.
  [[nodiscard]] std::optional<CostWork> take() { return pending_.take(); }
  void close() { pending_.close(); }
  /// Scans and clouds that were replaced before the worker took them.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

 private:
  static constexpr std::size_t kMaxUpdates = 100;

  PendingWork<CostWork> pending_;
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace extperfc::ros_navigate
