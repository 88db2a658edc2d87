#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include <Eigen/Core>
#include <ros/time.h>
#include <sensor_msgs/LaserScan.h>

#include "extperfc/base/pending_work.hpp"
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
    pending_.change([&](Work& work) {
      work.map = std::move(map);
      if (placement) work.placement = std::move(placement);
    });
  }
  void put_placement(Placement placement) {
    pending_.change([&](Work& work) { work.placement = std::move(placement); });
  }
  void put_force() {
    pending_.change([](Work& work) { work.force = true; });
  }
  void put_time_jump() {
    pending_.change([](Work& work) {
      work.time_ran_back = true;
      work.scan.reset();  // of the time before
    });
  }
  void put_scan(sensor_msgs::LaserScanConstPtr scan) {
    pending_.change([&](Work& work) {
      if (work.scan) ++dropped_;
      work.scan = std::move(scan);
    });
  }

  /// Waits for work. No value: closed.
  [[nodiscard]] std::optional<Work> take() { return pending_.take(); }
  void close() { pending_.close(); }
  /// Scans that were replaced before the worker took them.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

 private:
  PendingWork<Work> pending_;
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace extperfc::ros_localize
