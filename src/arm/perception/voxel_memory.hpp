#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "extperfc/arm/depth_obstacles.hpp"

#include "arm/perception/depth_rays.hpp"
#include "arm/perception/shape_mask.hpp"
#include "arm/perception/voxel_grid.hpp"

namespace extperfc::arm {

/// A depth image and where it was taken.
struct DepthView {
  const ImageView& depth;
  const CameraModel& camera;
  const Pose& root_T_camera;
};

/// What DepthObstacles holds.
class VoxelMemory {
 public:
  VoxelMemory(const CollisionModel& model, const DepthObstaclesParams& params, const VoxelGrid& grid);

  [[nodiscard]] DepthUpdate update(const DepthView& view, std::vector<MaskPart> parts, double time_s);
  /// Drops the voxels that the parts cover; true when there were any.
  [[nodiscard]] bool forget(std::vector<MaskPart> parts);
  void clear();

  const CollisionModel model;
  const DepthObstaclesParams params;
  const VoxelGrid grid;
  std::optional<WorldObject> object;
  struct Voxel {
    int index;
    double seen_s;
  };
  std::vector<Voxel> voxels;  ///< remembered, by index

 private:
  template <PixelFormat kFormat>
  void count_points(const DepthView& view, DepthUpdate& update);
  /// Whether the point that a pixel saw is a known object's.
  [[nodiscard]] bool ends_on_object(const DepthView& view, double u, double v, double depth_m) const;
  /// Whether all of the image's rays about the voxel end behind it: by a margin, but for those that end on
  /// a known object, which can be nothing that is left of the voxel's object.
  [[nodiscard]] bool seen_empty(const DepthView& view, const Pose& camera_T_root, int voxel) const;
  void merge(const DepthView& view, double time_s, DepthUpdate& update);
  void make_object(DepthUpdate& update);

  DepthRays rays_;
  ShapeMask mask_;
  std::vector<std::uint16_t> counts_;  ///< points per voxel of this image; 0 between images
  std::vector<int> touched_;           ///< voxels with points
  std::vector<unsigned char> scratch_;
};

}  // namespace extperfc::arm
