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

namespace extperfc {

/// Publishes map, map_metadata (both latched) and trajectory in a thread of its own: the mapper is held only
/// while it hands its map over, not while messages are built and sent.
///
/// A map leaves when it has changed and `interval_s` has passed since the last; what takes long leaves less
/// often, so that this thread stays below a tenth of a core.
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
  /// The map is another one: the next change is published at once.
  void restart();
  /// Ends the thread; harmless twice.
  void stop();

  /// The map of now, for a service. False when there is none yet.
  [[nodiscard]] bool current(nav_msgs::OccupancyGrid& message);
  /// The map after all that loop closures left to do, `patience_s` at most; null when there is none.
  [[nodiscard]] std::shared_ptr<const OccupancyGrid> settled_map(double patience_s);
  [[nodiscard]] Statistics statistics() const;

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMostPoses = 10000;  ///< of a published trajectory

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

}  // namespace extperfc
