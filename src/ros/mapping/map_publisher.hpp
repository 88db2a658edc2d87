#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include <nav_msgs/OccupancyGrid.h>
#include <ros/node_handle.h>

#include "ros/mapping/shared_mapper.hpp"

namespace extperfc::ros_mapping {

/// Publishes map, map_metadata (both latched) and trajectory in a separate thread: the mapper is locked only
/// while its map is copied, not while messages are built and sent.
///
/// A map is published when it has changed and `interval_s` has passed since the last; costly messages are
/// published less often, so that this thread uses less than a tenth of a core.
class MapPublisher {
 public:
  struct Options {
    std::string map_frame;
    double interval_s{5.0};
    double trajectory_interval_s{1.0};
  };

  struct Statistics {
    std::uint64_t maps{0};  ///< published
    std::size_t width{0};   ///< of the last [cells]
    std::size_t height{0};
    double resolution_m{0};
    double held_ms{0};  ///< how long the last one held the mapper
    double longest_held_ms{0};
    double build_ms{0};  ///< building and sending the last message
  };

  MapPublisher(ros::NodeHandle handle, SharedMapper& mapper, Options options);
  ~MapPublisher();
  MapPublisher(const MapPublisher&) = delete;
  MapPublisher& operator=(const MapPublisher&) = delete;

  /// A scan changed the mapper.
  void changed(const ros::Time& stamp);
  /// The map was replaced: the next change is published at once.
  void restart();
  /// Ends the thread; harmless twice.
  void stop();

  /// The current map, for a service. False without a map.
  [[nodiscard]] bool current(nav_msgs::OccupancyGrid& message);
  /// The map after all redraws of loop closures, waiting for `patience_s` at most; null without a map.
  [[nodiscard]] std::shared_ptr<const OccupancyGrid> settled_map(double patience_s);
  [[nodiscard]] Statistics statistics() const;

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMaxPoses = 10000;  ///< of a published trajectory

  void run();
  void publish_map(const ros::Time& stamp);
  void settle();
  void publish_trajectory(const ros::Time& stamp);
  std::shared_ptr<const OccupancyGrid> take_map();

  SharedMapper& mapper_;
  const Options options_;
  ros::Publisher map_publisher_;
  ros::Publisher metadata_publisher_;
  ros::Publisher trajectory_publisher_;

  std::uint64_t version_{0};  ///< of the published map; thread
  bool published_{false};     ///< thread

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  ros::Time stamp_;
  bool map_wanted_{false};
  bool settling_wanted_{false};
  bool trajectory_wanted_{false};
  Clock::time_point map_due_{Clock::time_point::min()};
  Clock::time_point settling_due_{Clock::time_point::min()};
  Clock::time_point trajectory_due_{Clock::time_point::min()};
  bool restarted_{false};
  bool stopping_{false};
  Statistics statistics_;
  std::thread thread_;
};

}  // namespace extperfc::ros_mapping
