#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "extperfc/localize/localizer.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::benchmark {

constexpr char kPeerName[] = "MRPT";

/// A filter under test: ours or the peer's.
class Subject {
 public:
  virtual ~Subject() = default;
  /// Particles with 0.3 m and 0.2 rad around `pose`.
  virtual void begin_at(const Pose2& pose) = 0;
  virtual void initialize_globally() = 0;
  virtual void update(const LaserScan& scan, const Pose2& odom) = 0;
  [[nodiscard]] virtual Pose2 pose() const = 0;
  /// Reported standard deviation of the position, where it is known least [m]; none: the filter's interface
  /// here has no covariance.
  [[nodiscard]] virtual std::optional<double> sigma_m() const = 0;
};

[[nodiscard]] std::unique_ptr<Subject> make_ours(const std::shared_ptr<const OccupancyGrid>& map,
                                                 const localize::LocalizerParams& params);
/// 60 beams of the `rays` of a scan. Null where MRPT is missing.
[[nodiscard]] std::unique_ptr<Subject> make_theirs(const OccupancyGrid& map, int min_particles,
                                                   int max_particles, std::size_t rays);

/// Odometry moved by 0.2 m or 0.2 rad: time for an update.
[[nodiscard]] bool moved(const Pose2& last, const Pose2& now);
/// Of the headings.
[[nodiscard]] double apart_deg(const Pose2& a, const Pose2& b);

/// Nearer than 0.5 m and 12 degrees.
[[nodiscard]] bool is_right(const Pose2& pose, const Pose2& truth);

}  // namespace extperfc::benchmark
