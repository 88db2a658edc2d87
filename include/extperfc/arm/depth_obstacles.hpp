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

namespace perception {
class VoxelMemory;
}

struct DepthObstaclesParams {
  /// Corners of the box that is watched, in the frame of the robot's root [m]; at most 8 million voxels.
  Eigen::Vector3d low_m{0.0, -1.3, 0.3};
  Eigen::Vector3d high_m{1.6, 1.3, 1.9};
  double voxel_m{0.02};           ///< edge; 0.005 to 0.2
  int pixel_step{2};              ///< every so many pixels of a row, and rows, are looked at; 1 to 16
  double min_depth_m{0.2};        ///< nearer measurements do not count; 0.01 to 10
  double max_depth_m{4.0};        ///< farther ones do not count; above min_depth_m, at most 20
  int min_points{3};              ///< of one picture in a voxel that count as a thing; 1 to 1000
  double robot_padding_m{0.03};   ///< nearer to the robot's shapes a point is the robot; 0 to 0.3
  double object_padding_m{0.02};  ///< nearer to a known object a point is that object; 0 to 0.3
  /// A ray must end so far behind a voxel to show it empty, or on a known object behind it; 0 to 0.5
  double clear_margin_m{0.02};
  double max_age_s{10};       ///< what was not seen again for so long is forgotten; 0.05 to 3600
  int max_boxes{400};         ///< 8 to 5000; with more, neighbouring voxels are taken together
  std::string name{"depth"};  ///< of the object in the collision world

  /// An error that names the first value out of its range.
  [[nodiscard]] Result<void> validate() const;
};

/// What became of one picture.
struct DepthUpdate {
  int points{0};         ///< in the watched box
  int robot_points{0};   ///< of them on the robot or what it carries
  int object_points{0};  ///< of them on known objects
  int seen{0};           ///< voxels with a thing in this picture
  int cleared{0};        ///< voxels seen empty, or with the robot in them
  int forgotten{0};      ///< voxels too old
  int voxels{0};         ///< remembered now
  int boxes{0};          ///< made of them
  double box_grid_m{0};  ///< edge of the grid that the boxes lie on: voxel_m times 1, 2, 4, ...
};

/// What a depth camera sees, as boxes for collision checks, in the frame of the robot's root.
///
/// Pixels become points; those within the padding of the robot's collision shapes, of what it carries and of
/// known objects are taken out; a voxel with enough others that the robot itself does not touch is occupied,
/// so that what is beyond the padding is never in collision with the robot as it stands. It stays so until a
/// later picture sees through it, until a link of the robot is where it is, or until it is too old. Voxels
/// that are hidden or out of view stay. No ray is followed through the grid: each remembered voxel is looked
/// up in the picture instead, so that the cost is that of the pixels and of the voxels in memory.
///
/// A thing nearer to the robot than the padding is not seen as long as it is so near, but what was seen there
/// before is kept. Memory is bounded by the number of voxels. Not thread-safe; deterministic.
class DepthObstacles {
 public:
  /// Errors: a parameter out of its range, too many voxels.
  [[nodiscard]] static Result<DepthObstacles> make(const CollisionModel& model,
                                                   const DepthObstaclesParams& params = {});
  DepthObstacles(DepthObstacles&&) noexcept;
  DepthObstacles& operator=(DepthObstacles&&) noexcept;
  ~DepthObstacles();

  /// One picture, taken at `time_s` (any clock that does not go back) when the joints of the model were at
  /// `positions`. `known`: objects that are no obstacles of this kind, and what the robot carries; an object
  /// named params.name is passed over. Errors, with the memory as it was: a picture that is no depth picture
  /// or of another size than the camera, a camera or pose that cannot be, a wrong number of positions or not
  /// finite, something carried by a link that the robot lacks. O(pixels + voxels near the robot and known
  /// objects + voxels in memory).
  [[nodiscard]] Result<DepthUpdate> update(const ImageView& depth, const CameraModel& camera,
                                           const Pose& root_T_camera, const JointVector& positions,
                                           const CollisionWorld& known, double time_s);

  /// Forgets the voxels that lie on known objects, for objects that came after the latest picture: the next
  /// one would do the same. True when there were any. What the robot carries is passed over.
  [[nodiscard]] bool forget(const CollisionWorld& known);

  /// Boxes that hold every remembered voxel and do not overlap, as one object; nothing when there is none.
  [[nodiscard]] const std::optional<WorldObject>& object() const;
  /// Middles of the remembered voxels, in the order of the grid.
  [[nodiscard]] std::vector<Eigen::Vector3d> voxels() const;
  void clear();

 private:
  explicit DepthObstacles(std::unique_ptr<perception::VoxelMemory> memory);
  std::unique_ptr<perception::VoxelMemory> memory_;
};

}  // namespace extperfc::arm
