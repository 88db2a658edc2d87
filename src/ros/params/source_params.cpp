#include "ros/params/source_params.hpp"

#include "extperfc/sources/recording.hpp"

#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

namespace {

/// `camera_info` names a calibration file; otherwise fx, fy, cx, cy with width and height, all or none.
std::optional<CameraModel> read_camera(ParamReader& reader) {
  std::string file;
  CameraModel camera;
  reader.read("camera_info", file);
  reader.read("width", camera.width, {1, 16384});
  reader.read("height", camera.height, {1, 16384});
  reader.read("fx", camera.fx, {0.0, 1e5});
  reader.read("fy", camera.fy, {0.0, 1e5});
  reader.read("cx", camera.cx, {-1e5, 1e5});
  reader.read("cy", camera.cy, {-1e5, 1e5});
  if (!file.empty()) {
    auto loaded = sources::load_camera_yaml(file);
    if (loaded) return *loaded;
    reader.complain(loaded.error().message);
    return std::nullopt;
  }
  const bool none = camera.width == 0 && camera.height == 0 && camera.fx == 0.0 && camera.fy == 0.0 &&
                    camera.cx == 0.0 && camera.cy == 0.0;
  if (none) return std::nullopt;
  if (auto valid = camera.validate(); !valid) {
    reader.complain(valid.error().message + " (fx, fy, cx, cy, width and height belong together)");
    return std::nullopt;
  }
  return camera;
}

}  // namespace

Result<SourceParams> load_source_params(const ros::NodeHandle& private_handle) {
  SourceParams params;
  std::string path;
  ParamReader reader(private_handle);
  reader.require("path", path, "the folder or file to play");
  reader.read("rate_hz", params.rate_hz, {0.0, 1000.0});
  reader.read("loop", params.loop);
  reader.read("wait_for_subscriber", params.wait_for_subscriber);
  reader.read("recorded_stamps", params.recorded_stamps);
  reader.read("depth_scale", params.depth_scale, {1.0, 1e6});
  reader.read("frame_id", params.frame_id);
  reader.read("world_frame", params.world_frame);
  params.camera = read_camera(reader);
  params.path = path;
  if (auto finished = reader.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

}  // namespace extperfc::ros_params
