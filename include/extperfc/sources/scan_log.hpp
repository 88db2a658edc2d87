#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::sources {

/// One planar scan of a recording with the odometry pose.
struct ScanRecord {
  LaserScan scan;
  std::optional<Pose2> odom_T_base;  ///< at the scan's stamp; no value where the recording has no odometry
  std::size_t index{0};              ///< the scan's place in the recording, from 0; damaged ones count too
};

/// A recording of planar scans that is read once, from front to back, in the order of the file (stamps may
/// run backwards). One record at a time is in memory. One thread at a time.
class ScanLog {
 public:
  ScanLog() = default;
  ScanLog(const ScanLog&) = delete;
  ScanLog& operator=(const ScanLog&) = delete;
  virtual ~ScanLog() = default;

  /// The next scan; no value at the end. Errors: the file breaks off or cannot be read any further; earlier
  /// scans stay valid, and every further call gives the error again.
  [[nodiscard]] virtual Result<std::optional<ScanRecord>> next() = 0;
  /// How much of the file is read, from 0 to 1.
  [[nodiscard]] virtual double progress() const = 0;
  /// Damaged entries that were left out so far.
  [[nodiscard]] virtual std::size_t damaged() const = 0;
  /// Descriptions of the first of them with line or entry in the file; at most ten.
  [[nodiscard]] virtual const std::vector<std::string>& complaints() const = 0;
};

/// Settings that a recording does not contain.
struct ScanLogOptions {
  /// Ranges from here on are no return [m]. 0: the value of the format, and for CARMEN's FLASER lines, which
  /// have none, 81.8 m: the largest range that a SICK LMS delivers.
  double max_range_m{0};
  std::optional<Pose2> base_T_sensor;  ///< overrides the log
  std::string sensor_label;            ///< MRPT rawlogs: only scans of this sensor; empty: the first one seen
};

/// CARMEN's text log (.log, .clf), plain or packed by gzip (.gz) or bzip2 (.bz2), recognised by the first
/// bytes: FLASER and ROBOTLASER1 lines, others are skipped. Angles: 180 values span 180 degrees from -90
/// degrees on; 360 and 361 values half a degree apart; other counts span 180 degrees (FLASER) or the value in
/// the line (ROBOTLASER1). A damaged line is left out and counted. Errors: no such file.
[[nodiscard]] Result<std::unique_ptr<ScanLog>> open_carmen_log(const std::filesystem::path& file,
                                                               const ScanLogOptions& options = {});

/// MRPT's rawlog, plain or gzip: CObservation2DRangeScan with CObservationOdometry, or with the increments of
/// CActionRobotMovement2D. MRPT is loaded when the first such file is opened. Errors: no such file, not a
/// rawlog, or a build without MRPT.
[[nodiscard]] Result<std::unique_ptr<ScanLog>> open_scan_rawlog(const std::filesystem::path& file,
                                                                const ScanLogOptions& options = {});

}  // namespace extperfc::sources
