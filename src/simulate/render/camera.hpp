#pragma once

#include <cstdint>
#include <vector>

#include "extperfc/simulate/sensor_rig.hpp"

#include "simulate/render/depth_noise.hpp"
#include "simulate/render/hash_noise.hpp"
#include "simulate/render/image_planes.hpp"
#include "simulate/render/scene.hpp"
#include "simulate/render/shading.hpp"

namespace extperfc::simulate {

/// x/z and y/z of every pixel of a camera, tile by tile: 16 x/z, then 16 y/z. Lens distortion included.
class RayTable {
 public:
  RayTable(const CameraModel& model, int supersampling);

  [[nodiscard]] bool is_for(const CameraModel& model, int supersampling) const;
  [[nodiscard]] int columns() const { return columns_; }  ///< tiles
  [[nodiscard]] int rows() const { return rows_; }        ///< tiles
  [[nodiscard]] const float* tile(int column, int row) const {
    const int tile = row * columns_ + column;
    return slopes_.data() + static_cast<std::size_t>(tile) * 2 * kLanes;
  }

 private:
  CameraModel model_;
  int supersampling_;
  int columns_;
  int rows_;
  std::vector<float> slopes_;
};

/// Images of a scene. Keeps its buffers from image to image.
class Camera {
 public:
  /// `noise`: one key per stream, see NoiseStream.
  void render(const CameraParams& params, const Pose& world_T_optical, const Scene& scene,
              const LightSpec& light, std::uint64_t seed, double time_s, CameraImages& images);

 private:
  const RayTable& table(const CameraModel& model, int supersampling);
  void shade(const Scene& scene, const View& view, const RayTable& table, const CameraParams& params,
             CameraImages& images);
  void shade_tile(const Scene& scene, const View& view, const CameraParams& params, int x, int y);
  void trace_centres(const Scene& scene, const View& view, const RayTable& table, CameraImages& images);
  void store_geometry(int x, int y, CameraImages& images) const;
  void finish(const CameraParams& params, NoiseKey key, CameraImages& images);

  std::vector<RayTable> tables_;  ///< of the last few cameras
  ImagePlanes planes_;
  Plane scratch_;
  DepthNoise depth_noise_;
  std::vector<float> rows_;
  RayPacket packet_{};
  Rays shadow_{};
  RayPacket around_{};
  LaneMask mask_{};
  Tile tile_{};
};

}  // namespace extperfc::simulate
