#include "arm/perception/shape_mask.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

namespace extperfc::arm {
namespace {

/// Single precision: coordinates up to some metres are off by less than this.
constexpr double kRounding = 1e-5;  // [m]

}  // namespace

Result<std::vector<MaskPart>> mask_parts(const Bodies& bodies, const JointVector& positions,
                                         const CollisionWorld& known, const std::string& left_out,
                                         double robot_padding_m, double object_padding_m) {
  std::vector<Pose> poses;
  body_poses(bodies, positions.data(), poses);
  std::vector<MaskPart> parts;
  for (const auto& own : bodies.parts)
    parts.push_back({own.part, poses[own.body] * own.body_T_part, robot_padding_m, Owner::kRobot});
  for (const auto& [name, carried] : known.attached()) {
    const auto link = bodies.link(carried->object.link);
    if (!link)
      return fail(ErrorCode::kNotFound, "object " + name + " is attached to link " + carried->object.link +
                                            ", which the robot lacks");
    const Pose root_T_object =
        poses[bodies.body_of_link[*link]] * bodies.body_T_link[*link] * carried->object.link_T_object;
    for (const auto& part : carried->parts)
      parts.push_back({part, root_T_object * part->body_T_part, robot_padding_m, Owner::kRobot});
  }
  auto objects = object_parts(known, left_out, object_padding_m);
  parts.insert(parts.end(), std::make_move_iterator(objects.begin()), std::make_move_iterator(objects.end()));
  return parts;
}

std::vector<MaskPart> object_parts(const CollisionWorld& known, const std::string& left_out,
                                   double padding_m) {
  std::vector<MaskPart> parts;
  for (const auto& [name, placed] : known.objects()) {
    if (name == left_out) continue;
    for (const auto& part : placed->parts)
      parts.push_back({part, placed->object.root_T_object * part->body_T_part, padding_m, Owner::kObject});
  }
  return parts;
}

ShapeMask::ShapeMask(const VoxelGrid& grid) : grid_(grid), heads_(grid.size(), kFree) {}

void ShapeMask::set(std::vector<MaskPart> parts) {
  for (const int voxel : marked_) heads_[voxel] = kFree;
  marked_.clear();
  entries_.clear();
  shapes_.clear();
  parts_ = std::move(parts);
  for (const MaskPart& part : parts_) {
    const Pose part_T_root = part.root_T_part.inverse();
    shapes_.push_back({part.part.get(), part_T_root.linear().cast<float>(),
                       part_T_root.translation().cast<float>(), static_cast<float>(part.padding_m),
                       part.owner});
  }
  for (std::size_t i = 0; i < parts_.size(); ++i) mark(static_cast<int>(i));
}

void ShapeMask::mark(int index) {
  const MaskPart& own = parts_[index];
  const double far = own.padding_m + grid_.half_diagonal() + kRounding;
  const double deep = own.padding_m - grid_.half_diagonal() - kRounding;
  const Eigen::Vector3d half = (rotated_half(*own.part, own.root_T_part.linear()).array() + far).matrix();
  const Eigen::Array3d low = (own.root_T_part.translation() - half - grid_.low).array() / grid_.edge;
  const Eigen::Array3d high = (own.root_T_part.translation() + half - grid_.low).array() / grid_.edge;
  const Eigen::Array3d count = grid_.count.cast<double>().array();
  const Eigen::Array3i first = low.floor().max(0).min(count).cast<int>();
  const Eigen::Array3i last = high.floor().min(count - 1).max(-1).cast<int>();
  const Pose part_T_root = own.root_T_part.inverse();
  const Eigen::Vector3d step = grid_.edge * part_T_root.linear().col(0);
  for (int z = first.z(); z <= last.z(); ++z)
    for (int y = first.y(); y <= last.y(); ++y) {
      Eigen::Vector3d point = part_T_root * grid_.centre({first.x(), y, z});
      for (int x = first.x(); x <= last.x(); ++x, point += step) {
        const double bound = distance_bound(*own.part, point);
        if (bound > far) continue;
        int& head = heads_[grid_.index(x, y, z)];
        if (head == kInRobot || (head == kInObject && own.owner == Owner::kObject)) continue;
        if (head == kFree) marked_.push_back(grid_.index(x, y, z));
        if (bound <= deep && (own.owner == Owner::kRobot || head == kFree)) {
          head = own.owner == Owner::kRobot ? kInRobot : kInObject;
        } else if (head != kInObject) {
          entries_.push_back({index, head});
          head = static_cast<int>(entries_.size()) - 1;
        }
      }
    }
}

Owner ShapeMask::look(int head, const Eigen::Vector3f& point) const {
  Owner owner = Owner::kNone;
  for (int entry = head; entry >= 0; entry = entries_[entry].next) {
    const Shape& shape = shapes_[entries_[entry].part];
    const Eigen::Vector3f local = shape.rotation * point + shape.shift;
    if (distance_bound(*shape.part, local.cast<double>()) > shape.padding) continue;
    if (shape.owner == Owner::kRobot) return Owner::kRobot;
    owner = Owner::kObject;
  }
  return owner;
}

bool ShapeMask::touches_robot(int voxel) const {
  return is_near(voxel, [&](const MaskPart& own) {
    return own.owner == Owner::kRobot ? grid_.half_diagonal() : -std::numeric_limits<double>::infinity();
  });
}

bool ShapeMask::covers(int voxel) const {
  return heads_[voxel] == kInObject || is_near(voxel, [&](const MaskPart& own) {
           return own.owner == Owner::kRobot ? grid_.half_diagonal() : own.padding_m + grid_.edge / 2;
         });
}

/// Whether the voxel is within the robot, or its middle within reach_of(part) of a part that is known to be
/// near.
template <typename ReachOf>
bool ShapeMask::is_near(int voxel, ReachOf reach_of) const {
  const int head = heads_[voxel];
  if (head < 0) return head == kInRobot;
  const Eigen::Vector3d centre = grid_.centre(grid_.cell(voxel));
  for (int entry = head; entry >= 0; entry = entries_[entry].next) {
    const MaskPart& own = parts_[entries_[entry].part];
    if (distance_bound(*own.part, own.root_T_part.inverse() * centre) <= reach_of(own)) return true;
  }
  return false;
}

}  // namespace extperfc::arm
