#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/arm/collision_model.hpp"
#include "extperfc/arm/collision_world.hpp"
#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/base/error.hpp"
#include "extperfc/world/camera_model.hpp"
#include "extperfc/world/image_view.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::arm {

class VoxelMemory;

struct DepthObstaclesParams {
  /// Corners of the observed box, in the frame of the robot's root [m]; at most 8 million voxels.
  Eigen::Vector3d low_m{0.0, -1.3, 0.3};
  Eigen::Vector3d high_m{1.6, 1.3, 1.9};
  double voxel_m{0.02};           ///< edge; 0.005 to 0.2
  int pixel_step{2};              ///< use every n-th pixel of every n-th row; 1 to 16
  double min_depth_m{0.2};        ///< nearer measurements are ignored; 0.01 to 10
  double max_depth_m{4.0};        ///< farther measurements are ignored; above min_depth_m, at most 20
  int min_points{3};              ///< points of one image in a voxel that make it occupied; 1 to 1000
  double robot_padding_m{0.03};   ///< points nearer to the robot's shapes belong to the robot; 0 to 0.3
  double object_padding_m{0.02};  ///< points nearer to a known object belong to that object; 0 to 0.3
  /// A ray that ends farther behind a voxel, or on a known object behind it, clears the voxel; 0 to 0.5
  double clear_margin_m{0.02};
  double max_age_s{10};       ///< voxels not seen for longer are cleared; 0.05 to 3600
  int max_boxes{400};         ///< 8 to 5000; with more, neighbouring voxels are merged
  std::string name{"depth"};  ///< of the object in the collision world

  /// An error that names the first value out of its range.
  [[nodiscard]] Result<void> validate() const;
};

/// Result of one image.
struct DepthUpdate {
  int points{0};         ///< in the observed box
  int robot_points{0};   ///< of them on the robot or what it carries
  int object_points{0};  ///< of them on known objects
  int seen{0};           ///< voxels occupied in this image
  int cleared{0};        ///< voxels seen empty, or with the robot in them
  int forgotten{0};      ///< voxels too old
  int voxels{0};         ///< remembered now
  int boxes{0};          ///< made of them
  double box_grid_m{0};  ///< edge of the grid that the boxes lie on: voxel_m times 1, 2, 4, ...
};

/// What a depth camera sees, as boxes for collision checks, in the frame of the robot's root.
///
/// Pixels become points; points within the padding of the robot's collision shapes, of objects that it
/// carries and of known objects are removed; a voxel with at least min_points others that does not touch the
/// robot is occupied, so outside of the padding the robot is never in collision where it stands. A voxel
/// stays occupied until a later image sees through it, a link of the robot occupies it, or it is older than
/// max_age_s. Hidden voxels and voxels out of view stay. No ray is traced through the grid: every occupied
/// voxel is looked up in the image, so the cost is that of the pixels and of the voxels in memory.
///
/// An object nearer to the robot than the padding is not seen while it is so near, but voxels seen there
/// before stay. The number of voxels bounds the memory. Not thread-safe; deterministic.
class DepthObstacles {
 public:
  /// Errors: a parameter out of its range, too many voxels.
  [[nodiscard]] static Result<DepthObstacles> make(const CollisionModel& model,
                                                   const DepthObstaclesParams& params = {});
  DepthObstacles(DepthObstacles&&) noexcept;
  DepthObstacles& operator=(DepthObstacles&&) noexcept;
  ~DepthObstacles();

  /// Processes one image taken at `time_s` (any clock that does not go back) with the joints of the model at
  /// `positions`. `known`: objects that are not obstacles of this kind, and what the robot carries; an object
  /// named params.name is ignored. Errors, with unchanged memory: not a depth image, an image of another size
  /// than the camera's, an invalid camera or pose, a wrong number of positions or not finite, an object
  /// carried by a link that the robot lacks. O(pixels + voxels near the robot and known objects + voxels in
  /// memory).
  [[nodiscard]] Result<DepthUpdate> update(const ImageView& depth, const CameraModel& camera,
                                           const Pose& root_T_camera, const JointVector& positions,
                                           const CollisionWorld& known, double time_s);

  /// Forgets the voxels that lie on known objects, for objects that came after the latest image: the next
  /// one would do the same. True when there were any. What the robot carries is passed over.
  [[nodiscard]] bool forget(const CollisionWorld& known);

  /// Boxes that contain every occupied voxel and do not overlap, as one object; std::nullopt without voxels.
  [[nodiscard]] const std::optional<WorldObject>& object() const;
  /// Centres of the occupied voxels, in the order of the grid.
  [[nodiscard]] std::vector<Eigen::Vector3d> voxels() const;
  void clear();

 private:
  explicit DepthObstacles(std::unique_ptr<VoxelMemory> memory);
  std::unique_ptr<VoxelMemory> memory_;
};

}  // namespace extperfc::arm
