#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "extperfc/base/error.hpp"
#include "extperfc/world/camera_model.hpp"

namespace extperfc::sources {

/// One recorded moment of an RGB-D camera.
struct RgbdFrame {
  double stamp_s{0};  ///< time of the recording [s]; frames without one are numbered at 30 Hz
  cv::Mat color;      ///< CV_8UC3 BGR, or CV_8UC1; empty when the recording has none here
  cv::Mat depth;      ///< CV_16UC1 [mm], aligned to colour; empty when the recording has none here
  /// Pose of the optical frame in the recording's world, if it is known.
  std::optional<Eigen::Isometry3d> world_T_optical;
  std::string label;  ///< where it comes from, e.g. the colour file's name
};

/// A recording that can be played frame by frame, in order, any number of times.
class Recording {
 public:
  Recording() = default;
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
  virtual ~Recording() = default;

  [[nodiscard]] virtual std::size_t size() const = 0;
  /// Frame `index` in [0, size()). Errors name the file and what is wrong with it.
  [[nodiscard]] virtual Result<RgbdFrame> frame(std::size_t index) = 0;
  /// Intrinsics that the recording itself brings, if any.
  [[nodiscard]] virtual std::optional<CameraModel> camera() const = 0;
};

/// A folder of aligned colour and depth images. Pairs come from `associations.txt` (TUM RGB-D style: stamp,
/// colour file, stamp, depth file; `#` comments) or else from equal names in `rgb/` and `depth/` (or
/// `color/`), sorted naturally. `camera_info.yaml` (camera_calibration format), if present, gives the
/// intrinsics; `groundtruth.txt` (TUM: stamp, tx ty tz, qx qy qz qw) the camera's poses. `depth_scale` is
/// units per metre of the depth files (1000 = millimetres, TUM's own 5000). Errors name the folder and what
/// was looked for.
[[nodiscard]] Result<std::unique_ptr<Recording>> open_pair_folder(const std::filesystem::path& folder,
                                                                  double depth_scale = 1000.0);

/// RGB-D observations (CObservation3DRangeScan) of an MRPT rawlog, plain or gzip, on their own or in sensory
/// frames. Depth is registered to colour with the log's own camera parameters. One pass over the file counts
/// the frames; afterwards one observation is in memory at a time, forward is streaming, backward starts
/// again. A file that is damaged after good frames gets one last frame that reports it. kUnsupported in a
/// build without MRPT.
[[nodiscard]] Result<std::unique_ptr<Recording>> open_rawlog(const std::filesystem::path& file);

/// Reads a camera_calibration YAML file.
[[nodiscard]] Result<CameraModel> load_camera_yaml(const std::filesystem::path& file);

}  // namespace extperfc::sources
