#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <extperfc/TrackArray.h>

#include "extperfc/navigate/local_planner.hpp"
#include "extperfc/navigate/moving_objects.hpp"
#include "extperfc/track/tracker.hpp"
#include "extperfc/world/occupancy_grid.hpp"

#include "ros/navigate/placed_scan.hpp"
#include "ros/params/navigator_params.hpp"

namespace extperfc::ros_navigate {

/// People from scan to scan: what the map does not explain, followed, and walking, or standing after it has
/// walked. One thread updates; any thread may ask.
class PeopleTracker {
 public:
  explicit PeopleTracker(const ros_params::PeopleParams& params);

  void set_map(const OccupancyGrid& map);
  void update(const PlacedScan& placed);
  void forget();
  /// Those who walk, or stand after they have come far (Walk::far), in odom, where they are at `now_s`. Empty
  /// when the last scan is older than 1 s.
  [[nodiscard]] std::vector<navigate::MovingObstacle> people(double now_s) const;
  /// Of them, those who have come far and have not stood for PeopleParams::stand_s: soon they are
  /// elsewhere. And what has a person's size, is far off, and came into sight so recently that it may walk.
  [[nodiscard]] std::vector<navigate::MovingObstacle> passers(double now_s) const;
  /// All confirmed objects of the last scan, in odom: those who stand, too, as long as the map does not
  /// explain them.
  [[nodiscard]] TrackArray tracks(const std::string& odom_frame) const;

 private:
  struct Person {
    navigate::MovingObstacle state;  ///< at the stamp
    bool passes{false};
    bool far{false};  ///< as Walk::far
  };
  struct Walk {
    Eigen::Vector2d begin_m{0, 0};              ///< where it was seen first
    std::shared_ptr<const PlacedScan> began{};  ///< the scan of then
    std::optional<double> last_s{};             ///< when it walked last
    bool far{false};                            ///< as came_far() said once
  };

  /// Will be elsewhere soon.
  [[nodiscard]] bool passes(const Walk& walk) const;
  void note_people(const PlacedScan& placed, const std::vector<navigate::MovingCandidate>& candidates);
  /// It is no furniture, of which another part is seen from elsewhere, or when who hid it has gone: it came
  /// a metre, and the place where it began is empty now, or the robot moved a metre less; or half a metre
  /// into a place that was empty then.
  [[nodiscard]] static bool came_far(const Walk& walk, const Eigen::Vector2d& at_m, const PlacedScan& placed);
  /// Those of the last scan.
  void note_newcomers(const std::vector<navigate::MovingCandidate>& candidates,
                      const Eigen::Vector2d& robot_m);
  enum class Which {
    kAll,
    kFar,      ///< who has come far: certainly no furniture
    kPassers,  ///< and newcomers
  };

  /// The mutex is held.
  [[nodiscard]] std::vector<navigate::MovingObstacle> at(double now_s, Which which) const;

  const ros_params::PeopleParams params_;
  mutable std::mutex mutex_;  ///< guards what follows
  navigate::MovingObjectDetector detector_;
  track::Tracker tracker_;
  std::vector<Person> people_;
  std::vector<navigate::MovingObstacle> newcomers_;  ///< who may walk: at the stamp
  std::map<std::uint64_t, Walk> walks_;              ///< of all tracks
  double stamp_s_{0};
};

}  // namespace extperfc::ros_navigate
