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
#include "extperfc/world/pose.hpp"

namespace extperfc::scan {

/// Intensity of a ray that several points fall on.
enum class IntensityOf {
  kNone,     ///< the scan has no intensities
  kNearest,  ///< of the point that the range belongs to
  kMaximum,  ///< the largest of all points of the ray
};

[[nodiscard]] Result<IntensityOf> intensity_from_name(const std::string& name);  ///< none, nearest, maximum
[[nodiscard]] const char* to_string(IntensityOf intensity);

/// Names and meaning follow the pointcloud_to_laserscan package, so that its configurations fit. One thing
/// differs: a ray stands in the middle of its bin, not at its lower edge, so that directions are unbiased.
struct ScanParams {
  double min_height{0.1};               ///< of a point in the target frame [m]
  double max_height{1.5};               ///< of a point in the target frame [m]
  double angle_min{-3.14159265358979};  ///< of the first ray [rad], [-2 pi, 2 pi]
  double angle_max{3.14159265358979};   ///< the last ray stands here at most [rad]; one turn in all at most
  double angle_increment{0.00872664625997};  ///< from ray to ray [rad], [0.0001, 1]
  double range_min{0.6};    ///< nearer points do not count [m]; keep it beyond the robot's own hull
  double range_max{30.0};   ///< farther points do not count [m]
  bool use_inf{true};       ///< a ray that meets nothing is +infinity, as REP 117 wants it; or ...
  double inf_epsilon{1.0};  ///< ... range_max + inf_epsilon [m]
  IntensityOf intensity{IntensityOf::kNearest};
  std::optional<RingSet> rings;  ///< nothing: all
  GroundParams ground;
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

/// What became of a cloud's points.
struct ScanStatistics {
  std::size_t points{0};          ///< in the cloud
  std::size_t on_ground{0};       ///< inside heights, ranges and angles, but taken for floor
  std::size_t used{0};            ///< fell on a ray
  bool ground_found{true};        ///< false: kPlane found no plane and took the floor for level
  bool intensity_missing{false};  ///< intensities were wanted, and the cloud has none
  Ground ground;
};

/// Flattens point clouds to planar scans: every ray has the horizontal distance of the nearest point that
/// stands on the floor within its heights. Points with NaN or infinite coordinates do not count.
///
/// Deterministic. Memory is kept from cloud to cloud, so one thread at a time. O(points + rays).
class CloudToScan {
 public:
  [[nodiscard]] static Result<CloudToScan> make(const ScanParams& params);
  CloudToScan(CloudToScan&&) noexcept;
  CloudToScan& operator=(CloudToScan&&) noexcept;
  ~CloudToScan();

  /// `scan` keeps its memory from call to call. Errors: the cloud's layout does not fit its data, rings are
  /// selected and the cloud has no ring field. An empty cloud gives a scan that meets nothing.
  [[nodiscard]] Result<ScanStatistics> convert(const CloudView& cloud, const Pose& target_T_cloud,
                                               PlanarScan& scan);

  [[nodiscard]] std::size_t rays() const;

 private:
  class Impl;
  explicit CloudToScan(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace extperfc::scan
