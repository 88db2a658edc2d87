#pragma once

#include <mutex>
#include <vector>

#include "extperfc/navigate/local_planner.hpp"
#include "extperfc/navigate/moving_objects.hpp"
#include "extperfc/track/tracker.hpp"
#include "extperfc/world/occupancy_grid.hpp"

#include "ros/navigate/placed_scan.hpp"
#include "ros/params/navigator_params.hpp"

namespace extperfc::ros_navigate {

/// People from scan to scan: what the map does not explain, followed, and moving. One thread updates; any
/// thread may ask.
class PeopleTracker {
 public:
  explicit PeopleTracker(const ros_params::PeopleParams& params);

  void set_map(const OccupancyGrid& map);
  void update(const PlacedScan& placed);
  void forget();
  /// Those who walk, in odom, where they are at `now_s`. Empty when the last scan is older than 1 s.
  [[nodiscard]] std::vector<navigate::MovingObstacle> people(double now_s) const;

 private:
  struct Person {
    navigate::MovingObstacle state;  ///< at the stamp
  };

  const ros_params::PeopleParams params_;
  mutable std::mutex mutex_;  ///< guards what follows
  navigate::MovingObjectDetector detector_;
  track::Tracker tracker_;
  std::vector<Person> people_;
  double stamp_s_{0};
};

}  // namespace extperfc::ros_navigate
