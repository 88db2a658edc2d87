#include <pluginlib/class_list_macros.hpp>

#include "extperfc/sources/recording.hpp"

#include "ros/sources/source_nodelet.hpp"

namespace extperfc::ros_sources {

/// Plays the RGB-D observations of an MRPT rawlog.
///
/// Publishes:
///   diagnostics  diagnostic_msgs/DiagnosticArray
/// Parts: RecordingPlayer
/// Parameters: those of extperfc/image_pair_source. `path` is the rawlog file, `depth_scale` is not used, and
///   the rawlog's own intrinsics are used unless others are given.
class RawlogSourceNodelet : public SourceNodelet {
  Result<std::unique_ptr<sources::Recording>> open(const ros_params::SourceParams& params) override {
    return sources::open_rawlog(params.path);
  }
};

}  // namespace extperfc::ros_sources

PLUGINLIB_EXPORT_CLASS(extperfc::ros_sources::RawlogSourceNodelet, nodelet::Nodelet)
