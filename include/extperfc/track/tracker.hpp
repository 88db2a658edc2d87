#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/track/moving_point.hpp"

namespace extperfc::track {

/// One detected object of one image.
struct Observation {
  int class_index{0};
  double score{0};  ///< [0, 1]
  Eigen::Vector3d position_m{Eigen::Vector3d::Zero()};
  Eigen::Matrix3d covariance_m2{Eigen::Matrix3d::Identity()};  ///< of the position, symmetric
};

struct TrackerParams {
  double acceleration_m_s2{0.5};  ///< standard deviation of an object's acceleration, > 0
  double speed_m_s{0.3};          ///< standard deviation of a new object's speed along each axis, > 0
  double min_sigma_m{0.005};      ///< a position is never taken for more exact than this, > 0
  double gate{16.27};        ///< largest squared Mahalanobis distance between an object and an observation of
                             ///< it, > 0; 16.27 leaves out 1 of 1000 (chi-squared, 3 degrees of freedom)
  double class_cost{6.0};    ///< added to this distance when the observation has another class, >= 0
  int confirm_hits{3};       ///< observations after which an object is confirmed, >= 1
  double max_missed_s{1.0};  ///< a confirmed object without an observation for longer is forgotten, > 0
  double max_missed_new_s{0.25};  ///< the same of one that is not confirmed, > 0
  int max_tracks{200};            ///< more objects are not followed: the rest is left out, >= 1
  /// Standard deviation of the change of speed of who stops or turns round at once: a confirmed object that
  /// would be missed is looked for by it among the observations that belong to no other, >= 0; 0: never.
  double manoeuvre_m_s{0};
};

/// An error that names the first parameter out of its range.
[[nodiscard]] Result<void> validate(const TrackerParams& params);

/// An object that is followed, at the time of the last update.
struct Track {
  std::uint64_t id{0};  ///< from 1 upwards, never given twice by one tracker
  MovingPoint point;
  std::map<int, double> votes;  ///< for classes: sums of scores in which older ones count less
  double score{0};              ///< of the last observation
  int hits{0};                  ///< observations so far
  bool confirmed{false};
  double first_seen_s{0};
  double last_seen_s{0};
  std::optional<std::size_t> observation;  ///< index into the last update's; empty: missed

  [[nodiscard]] int class_index() const;  ///< with most votes
};

/// Follows objects from image to image: a Kalman filter each (MovingPoint), and the assignment of
/// observations to objects with the smallest sum of squared Mahalanobis distances inside a gate ("global
/// nearest neighbour": Blackman and Popoli, "Design and Analysis of Modern Tracking Systems", 1999, ch. 6).
///
/// An observation that belongs to no object begins a new one; it is confirmed after `confirm_hits`
/// observations. All positions are in one frame; a still one (odom, map) when the camera moves. One thread at
/// a time. O(n^3) in the number of objects.
class Tracker {
 public:
  /// Throws std::invalid_argument unless validate(params).
  explicit Tracker(const TrackerParams& params);

  enum class Status {
    kUpdated,
    kTooOld,     ///< older than the last update by max_missed_s at most: ignored
    kRestarted,  ///< older by more, e.g. a bag that begins again: every object was forgotten, then updated
  };

  /// The observations of one image, `stamp_s` is its time. Those that are not finite are left out.
  Status update(double stamp_s, const std::vector<Observation>& observations);

  /// All objects, oldest first, those that are not confirmed included.
  [[nodiscard]] const std::vector<Track>& tracks() const { return tracks_; }

 private:
  void predict(double dt_s);
  using Matches = std::vector<std::optional<std::size_t>>;  ///< index of the observation of each track
  /// `taken`: observations that belong to others.
  [[nodiscard]] Matches match(const std::vector<Track>& tracks, const std::vector<Observation>& observations,
                              const std::vector<bool>& taken) const;
  void give(const Matches& matches, double stamp_s, const std::vector<Observation>& observations,
            std::vector<bool>& taken);
  void match_manoeuvres(double dt_s, double stamp_s, const std::vector<Observation>& observations,
                        std::vector<bool>& taken);
  void correct(Track& track, double stamp_s, const Observation& observation) const;
  void begin(double stamp_s, std::size_t index, const Observation& observation);
  void forget(double stamp_s);
  [[nodiscard]] Eigen::Matrix3d floored(const Eigen::Matrix3d& covariance_m2) const;

  TrackerParams params_;
  std::vector<Track> tracks_;
  std::optional<double> stamp_s_;
  std::uint64_t next_id_{1};
};

}  // namespace extperfc::track
