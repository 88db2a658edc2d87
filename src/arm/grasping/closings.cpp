#include "arm/grasping/closings.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "extperfc/base/math.hpp"

namespace extperfc::arm {
namespace {

constexpr double kLong = 1.5;  // times the next edge: then there are grasps beside the middle too

/// Unit vectors square to `axis`, half a revolution of them. The first is square to the line from the root's
/// axis to the object too: the hand then comes straight from the robot.
std::vector<Eigen::Vector3d> across(const Eigen::Vector3d& axis, const Eigen::Vector3d& position,
                                    double step_rad) {
  Eigen::Vector3d first = axis.cross(Eigen::Vector3d(position.x(), position.y(), 0));
  if (first.norm() < 1e-6) first = axis.unitOrthogonal();
  first.normalize();
  const int count = std::max(1, static_cast<int>(std::lround(kPi / step_rad)));
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(count);
  for (int i = 0; i < count; ++i) directions.push_back(Eigen::AngleAxisd(i * kPi / count, axis) * first);
  return directions;
}

/// The middle, and places on either side of it along `axis`.
std::vector<Eigen::Vector3d> along_axis(const Eigen::Vector3d& middle, const Eigen::Vector3d& axis,
                                        double half) {
  return {middle, middle + half / 2 * axis, middle - half / 2 * axis};
}

std::vector<Closing> of_box(const ConvexPart& part, const Pose& pose) {
  const Eigen::Vector3d middle = pose.translation();
  std::vector<Closing> closings;
  for (int axis = 0; axis < 3; ++axis) {
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    const int longest = part.half[a] >= part.half[b] ? a : b, other = longest == a ? b : a;
    std::vector<Eigen::Vector3d> centres{middle};
    if (part.half[longest] > kLong * part.half[other])
      centres = along_axis(middle, pose.linear().col(longest), part.half[longest]);
    closings.push_back({pose.linear().col(axis), centres});
  }
  return closings;
}

std::vector<Closing> of_cylinder(const ConvexPart& part, const Pose& pose, const GraspParams& params) {
  const Eigen::Vector3d middle = pose.translation(), axis = pose.linear().col(2);
  std::vector<Eigen::Vector3d> centres{middle};
  if (part.half.z() > kLong * part.half.x()) centres = along_axis(middle, axis, part.half.z());
  std::vector<Closing> closings;
  for (const auto& direction : across(axis, middle, params.yaw_step_rad))
    closings.push_back({direction, centres});
  closings.push_back({axis, {middle}});
  return closings;
}

/// From low to high: the surface leans by the same angle everywhere, but only at the rim is the lean 0, and
/// the centre of mass is at a quarter of the height.
std::vector<Closing> of_cone(const ConvexPart& part, const Pose& pose, const GraspParams& params) {
  const Eigen::Vector3d axis = pose.linear().col(2), base = pose.translation() - part.half.z() * axis;
  std::vector<Closing> closings;
  for (const auto& direction : across(axis, pose.translation(), params.yaw_step_rad)) {
    Closing closing{direction, {}};
    for (const double fraction : {0.0, 0.25, 0.5})
      closing.centres.push_back(base + fraction * 2 * part.half.z() * axis);
    closings.push_back(closing);
  }
  return closings;
}

}  // namespace

std::vector<Closing> closings_of(const ConvexPart& part, const Pose& root_T_part, const GraspParams& params) {
  switch (part.kind) {
    case PartKind::kBox:
      return of_box(part, root_T_part);
    case PartKind::kCylinder:
      return of_cylinder(part, root_T_part, params);
    case PartKind::kCone:
      return of_cone(part, root_T_part, params);
    case PartKind::kSphere:
    case PartKind::kHull:
      break;
  }
  std::vector<Closing> closings;
  for (const auto& direction :
       across(Eigen::Vector3d::UnitZ(), root_T_part.translation(), params.yaw_step_rad))
    closings.push_back({direction, {root_T_part.translation()}});
  return closings;
}

std::vector<Eigen::Vector3d> approaches_of(const Eigen::Vector3d& along, const GraspParams& params) {
  Eigen::Vector3d down = -Eigen::Vector3d::UnitZ() + along.z() * along;
  if (down.norm() < 1e-3) down = along.unitOrthogonal();
  down.normalize();
  const Eigen::Vector3d side = along.cross(down);
  std::vector<Eigen::Vector3d> approaches{down};
  for (int i = 1; i * params.tilt_step_rad <= params.max_tilt_rad + 1e-3; ++i)
    for (const double sign : {1.0, -1.0}) {
      const double angle = sign * i * params.tilt_step_rad;
      if (angle <= -kPi + 1e-3) continue;
      approaches.emplace_back(std::cos(angle) * down + std::sin(angle) * side);
    }
  return approaches;
}

}  // namespace extperfc::arm
