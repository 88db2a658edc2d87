#pragma once

#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Header.h>

#include "extperfc/base/error.hpp"
#include "extperfc/scan/cloud_to_scan.hpp"
#include "extperfc/scan/cloud_view.hpp"

namespace extperfc::ros_convert {

/// The message's data seen as a cloud; valid as long as the message. Fields: x, y, z, and where they are
/// there intensity (or "i"), ring, and time, t or timestamp. Errors: no x, y or z; a field of several numbers
/// or of an unknown type.
[[nodiscard]] Result<scan::CloudView> to_cloud_view(const sensor_msgs::PointCloud2& message);

/// What a planar scan itself does not know.
struct ScanFacts {
  double scan_time_s{0};  ///< from scan to scan
  double range_min_m{0};
  double range_max_m{0};
};
[[nodiscard]] sensor_msgs::LaserScan to_message(const scan::PlanarScan& scan, const ScanFacts& facts,
                                                const std_msgs::Header& header);

}  // namespace extperfc::ros_convert
