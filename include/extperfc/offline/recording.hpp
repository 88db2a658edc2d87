#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "extperfc/base/error.hpp"
#include "extperfc/sources/scan_log.hpp"

namespace extperfc::offline {

/// How a recording of planar scans is read, for all formats.
struct RecordingOptions {
  sources::ScanLogOptions log;
  // ROS bags only:
  std::string scan_topic;  ///< empty: the only topic with planar scans
  std::string odom_topic;  ///< nav_msgs/Odometry; empty: tf, else the only such topic
  std::string base_frame{"base_link"};
  std::string odom_frame{"odom"};
};

/// Opens a CARMEN log, an MRPT rawlog or a ROS bag, recognised by the first bytes. Errors name the file and
/// what is wrong: missing, of none of these formats, or of one that this build cannot read.
[[nodiscard]] Result<std::unique_ptr<sources::ScanLog>> open_recording(const std::filesystem::path& file,
                                                                       const RecordingOptions& options = {});

}  // namespace extperfc::offline

/// Entry of the library extperfc_scan_bag, which is loaded only when a bag is opened: only this library uses
/// ROS.
extern "C" void extperfc_open_scan_bag(const std::filesystem::path& file,
                                       const extperfc::offline::RecordingOptions& options,
                                       extperfc::Result<std::unique_ptr<extperfc::sources::ScanLog>>& opened);
