#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/scan/cloud_view.hpp"
#include "extperfc/scan/ground.hpp"
#include "extperfc/scan/ring_selection.hpp"
#include "extperfc/scan/self_filter.hpp"
#include "extperfc/scan/sensor_track.hpp"

namespace extperfc::scan {

/// Intensity of a ray that several points fall on.
enum class IntensityOf {
  kNone,     ///< the scan has no intensities
  kNearest,  ///< of the point that the range belongs to
  kMaximum,  ///< the largest of all points of the ray
  kHeight,   ///< in place of an intensity the height [m] in the target frame of the point within 0.1 m of the
             ///< range that is nearest to the lidar's height, for cost maps
};

[[nodiscard]] Result<IntensityOf> intensity_from_name(
    const std::string& name);  ///< none, nearest, maximum, height
[[nodiscard]] const char* to_string(IntensityOf intensity);

/// Names and meaning follow the pointcloud_to_laserscan package, so that its configurations fit. One detail
/// differs: a ray stands in the middle of its bin, not at its lower edge, so that directions are unbiased.
struct ScanParams {
  double min_height{0.1};               ///< of a point in the target frame [m]
  double max_height{1.5};               ///< of a point in the target frame [m]
  double angle_min{-3.14159265358979};  ///< of the first ray [rad], [-2 pi, 2 pi]
  double angle_max{3.14159265358979};  ///< upper bound of the last ray [rad]; at most one revolution in total
  double angle_increment{0.00872664625997};  ///< from ray to ray [rad], [0.0001, 1]
  double range_min{0.4};    ///< nearer points do not count [m]; SelfFilter is for the robot beyond it
  double range_max{30.0};   ///< farther points do not count [m]
  bool use_inf{true};       ///< a ray that is seen to be free is +infinity, as REP 117 wants it; or ...
  double inf_epsilon{1.0};  ///< ... range_max + inf_epsilon [m]
  IntensityOf intensity{IntensityOf::kHeight};
  std::optional<RingSet> rings;  ///< no value: all
  double support_m{0.15};        ///< points this near to each other are one surface, (0, 2]
  /// A beam without any return counts as free up to here [m], [0, 1e6]; 0: it stays unknown. Dark, wet
  /// and glass surfaces give no returns either. Organised clouds only: others leave such beams out.
  double no_return_range{0.0};
  AzimuthTimes azimuth_times{AzimuthTimes::kNone};  ///< for clouds without times
  double scan_time{0.1};  ///< of one revolution, where times come from the azimuth [s], (0, 60]
  GroundParams ground;
  double range_noise_m{0.01};  ///< standard deviation of the lidar's ranges, [0, 0.1]
};

/// An error that names the first parameter out of its range.
[[nodiscard]] Result<void> validate(const ScanParams& params);

/// Rays in the x-y plane of the target frame, counter-clockwise.
struct PlanarScan {
  double angle_min{0};             ///< of ranges[0] [rad]
  double angle_max{0};             ///< of the last ray [rad]
  double angle_increment{0};       ///< [rad]
  std::vector<float> ranges;       ///< [m]
  std::vector<float> intensities;  ///< as long as ranges (0 where nothing was met), or empty
};

/// Counts of a cloud's points and of the rays by their result.
struct ScanStatistics {
  std::size_t points{0};          ///< in the cloud
  std::size_t on_ground{0};       ///< inside heights, ranges and angles, but taken for floor
  std::size_t on_robot{0};        ///< would have fallen on a ray, but belong to the robot itself
  std::size_t used{0};            ///< fell on a ray
  std::size_t rays_met{0};        ///< with a nearest point
  std::size_t rays_supported{0};  ///< with a range that two rings agree on
  std::size_t rays_free{0};       ///< no return, and a beam passed through
  std::size_t rays_unknown{0};    ///< no return, and no beam passed through
  bool ground_found{true};        ///< false: kPlane found no plane and assumed a level floor
  bool intensity_missing{false};  ///< intensities were wanted, and the cloud has none
  bool deskewed{false};           ///< the track has several poses, and the points' moments are known
  Ground ground;
};

/// The two scans of one cloud. Both have three kinds of rays: one with a return has its distance; one that is
/// seen to be free up to range_max is +infinity (or range_max + inf_epsilon); one without a beam, or hidden
/// by the robot itself, is NaN: unknown; do not treat it as free space.
struct PlanarScans {
  /// For maps: the nearest surface that two rings or more agree on, i.e. whose points lie within support_m.
  /// The range is the mean of those points, so that noise averages out. Where no two rings agree: with those
  /// of the two neighbouring rays; or else three points of one ring there; else a lone point does not count.
  PlanarScan supported;
  /// For cost maps: the nearest point of any kind. Of several points that lie within 4 range_noise_m, each
  /// with its error, the nearest would always be too near (2 cm for thirty of 1 cm): the range is where a
  /// surface whose nearest point this is on average stands. A lone point's is its own.
  PlanarScan nearest;
};

/// Flattens point clouds to planar scans: every ray has the horizontal distance of what stands on the floor
/// within its heights. Points with NaN or infinite coordinates do not count.
///
/// A ray is seen to be free when a beam of its direction went on beyond range_max, inside the height band and
/// above the floor from range_min to range_max.
///
/// Deterministic. Memory is kept from cloud to cloud, so one thread at a time. O(points log points + rays).
class CloudToScan {
 public:
  [[nodiscard]] static Result<CloudToScan> make(const ScanParams& params);
  CloudToScan(CloudToScan&&) noexcept;
  CloudToScan& operator=(CloudToScan&&) noexcept;
  ~CloudToScan();

  /// `scans` keep their memory from call to call. With several poses in `track`, every point is put where the
  /// sensor was when it was measured; without moments (see time_span()), the pose at the stamp counts for
  /// all. Points inside `robot` (placed in the sensor's frame) are left out. Errors: the cloud's layout does
  /// not fit its data, rings are selected and the cloud has no ring field, an empty track. An empty cloud
  /// gives a scan of unknown rays.
  [[nodiscard]] Result<ScanStatistics> convert(const CloudView& cloud, const SensorTrack& track,
                                               const SelfFilter& robot, PlanarScans& scans);

  [[nodiscard]] std::size_t rays() const;

 private:
  class Impl;
  explicit CloudToScan(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace extperfc::scan
