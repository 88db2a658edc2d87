#include <pluginlib/class_list_macros.hpp>

#include "extperfc/sources/recording.hpp"

#include "ros/sources/source_nodelet.hpp"

namespace extperfc {

/// Plays a folder of aligned colour and depth images (TUM-style association file or equal names).
///
/// Publishes: see RecordingPlayer; diagnostics.
/// Parameters (private; unknown keys are refused):
///   path                 folder                                                       required
///   rate_hz              frames per second, 0 = as recorded                           10, [0, 1000]
///   loop                 start again at the end                                       true
///   wait_for_subscriber  begin with the first subscriber                              true
///   recorded_stamps      stamps of the recording instead of the time of publishing    false
///   depth_scale          units per metre of the depth files (TUM: 5000)               1000 (millimetres)
///   frame_id             optical frame                                                camera_color_optical_frame
///   world_frame          frame of recorded camera poses (groundtruth.txt)             map
///   camera_info          calibration file; else the folder's camera_info.yaml         ""
///   width, height, fx, fy, cx, cy   intrinsics [px] instead of a file                 none
class ImagePairSourceNodelet : public SourceNodelet {
  Result<std::unique_ptr<sources::Recording>> open(const ros_params::SourceParams& params) override {
    return sources::open_pair_folder(params.path, params.depth_scale);
  }
};

}  // namespace extperfc

PLUGINLIB_EXPORT_CLASS(extperfc::ImagePairSourceNodelet, nodelet::Nodelet)
