#include <pluginlib/class_list_macros.hpp>

#include "extperfc/sources/recording.hpp"

#include "ros/sources/source_nodelet.hpp"

namespace extperfc::ros_sources {

/// Plays a folder of aligned colour and depth images (TUM-style association file or equal names).
///
/// Publishes:
///   diagnostics  diagnostic_msgs/DiagnosticArray
/// Parts: RecordingPlayer
/// Parameters: config/source.yaml.
class ImagePairSourceNodelet : public SourceNodelet {
  Result<std::unique_ptr<sources::Recording>> open(const ros_params::SourceParams& params) override {
    return sources::open_pair_folder(params.path, params.depth_scale);
  }
};

}  // namespace extperfc::ros_sources

PLUGINLIB_EXPORT_CLASS(extperfc::ros_sources::ImagePairSourceNodelet, nodelet::Nodelet)
