#pragma once

#include <memory>
#include <vector>

#include "extperfc/arm/collision_world.hpp"
#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/base/error.hpp"

#include "arm/collision/bodies.hpp"
#include "arm/perception/voxel_grid.hpp"

namespace extperfc::arm {

enum class Owner { kNone, kRobot, kObject };

/// A shape about which points do not count.
struct MaskPart {
  std::shared_ptr<const ConvexPart> part;
  Pose root_T_part{Pose::Identity()};
  double padding_m{0};
  Owner owner{Owner::kRobot};
};

/// The robot at `positions` with what it carries, and the known objects but that named `left_out`. Errors:
/// something carried by a link that the robot lacks.
[[nodiscard]] Result<std::vector<MaskPart>> mask_parts(const Bodies& bodies, const JointVector& positions,
                                                       const CollisionWorld& known,
                                                       const std::string& left_out, double robot_padding_m,
                                                       double object_padding_m);

/// Only the known objects but that named `left_out`.
[[nodiscard]] std::vector<MaskPart> object_parts(const CollisionWorld& known, const std::string& left_out,
                                                 double padding_m);

/// Tells whose a point is. For every voxel it knows which shapes are near, so that most points cost one look.
class ShapeMask {
 public:
  explicit ShapeMask(const VoxelGrid& grid);

  /// O(voxels in the bounding boxes of the shapes).
  void set(std::vector<MaskPart> parts);

  /// Of a point in the voxel of that index: within the padding of a shape. The robot comes first.
  [[nodiscard]] Owner owner(int voxel, const Eigen::Vector3f& point) const {
    const int head = heads_[voxel];
    if (head == kFree) return Owner::kNone;
    return head < 0 ? (head == kInRobot ? Owner::kRobot : Owner::kObject) : look(head, point);
  }
  /// Whether the voxel may touch the robot's shape itself.
  [[nodiscard]] bool touches_robot(int voxel) const;
  /// Whether it touches_robot(), or its middle is within the padding of an object and half an edge: then its
  /// points may have been that object's. Those that were not come again with the next image.
  [[nodiscard]] bool covers(int voxel) const;

 private:
  static constexpr int kFree = -1, kInRobot = -2, kInObject = -3;
  struct Entry {
    int part;
    int next;  ///< kFree: the last one
  };
  struct Shape {
    const ConvexPart* part;
    Eigen::Matrix3f rotation;  ///< part_R_root
    Eigen::Vector3f shift;     ///< of part_T_root
    float padding;
    Owner owner;
  };

  template <typename ReachOf>
  [[nodiscard]] bool is_near(int voxel, ReachOf reach_of) const;
  void mark(int index);
  [[nodiscard]] Owner look(int head, const Eigen::Vector3f& point) const;

  const VoxelGrid grid_;
  std::vector<MaskPart> parts_;
  std::vector<Shape> shapes_;
  std::vector<int> heads_;   ///< per voxel
  std::vector<int> marked_;  ///< voxels that are not kFree
  std::vector<Entry> entries_;
};

}  // namespace extperfc::arm
