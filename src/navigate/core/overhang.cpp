#include "extperfc/navigate/overhang.hpp"

#include <algorithm>
#include <limits>
#include <variant>

#include "navigate/costs/polygon.hpp"

namespace extperfc::navigate {

namespace {

/// Half of the edges of the box about a shape; a mesh that is not in memory is the box that its scale spans.
Eigen::AlignedBox3d box_of(const Geometry& geometry) {
  const auto around = [](double x, double y, double z) {
    return Eigen::AlignedBox3d(Eigen::Vector3d(-x, -y, -z), Eigen::Vector3d(x, y, z));
  };
  if (const auto* box = std::get_if<Box>(&geometry))
    return around(box->size_m.x() / 2, box->size_m.y() / 2, box->size_m.z() / 2);
  if (const auto* cylinder = std::get_if<Cylinder>(&geometry))
    return around(cylinder->radius_m, cylinder->radius_m, cylinder->length_m / 2);
  if (const auto* sphere = std::get_if<Sphere>(&geometry))
    return around(sphere->radius_m, sphere->radius_m, sphere->radius_m);
  if (const auto* cone = std::get_if<Cone>(&geometry))
    return around(cone->radius_m, cone->radius_m, cone->height_m / 2);
  const auto& mesh = std::get<TriangleMesh>(geometry);
  if (!mesh.triangles) return around(mesh.scale.x(), mesh.scale.y(), mesh.scale.z());
  Eigen::AlignedBox3d all;
  for (const auto& triangle : *mesh.triangles)
    for (const auto& corner : triangle) all.extend(corner.cast<double>().cwiseProduct(mesh.scale).eval());
  return all;
}

bool holds(const Footprint& footprint, const Eigen::Vector2d& point_m) {
  constexpr double kOnEdgeM = 1e-6;
  return contains(footprint.corners_m(), point_m) ||
         distance_to_edges_m(footprint.corners_m(), point_m) < kOnEdgeM;
}

double position_of(const Joint& joint, const std::map<std::string, double>& positions) {
  const auto given = positions.find(joint.name);
  if (given != positions.end()) return given->second;
  return std::clamp(0.0, std::min(joint.lower, joint.upper), std::max(joint.lower, joint.upper));
}

}  // namespace

Result<Overhang> Overhang::make(const RobotModel& robot, const std::string& base_link, double max_height_m) {
  const auto link = robot.link(base_link);
  if (!link)
    return fail(ErrorCode::kNotFound,
                "the robot " + robot.name() + " has no link " + base_link + ", the frame of the footprint");
  return Overhang(robot, *link, max_height_m);
}

std::vector<Eigen::Vector2d> Overhang::points(const std::map<std::string, double>& positions,
                                              const Footprint& footprint) const {
  std::vector<double> values;
  values.reserve(robot_.joints().size());
  for (const auto& joint : robot_.joints()) values.push_back(position_of(joint, positions));
  const auto poses = robot_.link_poses(values);
  const Pose base_T_root = poses[static_cast<std::size_t>(base_link_)].inverse();
  std::vector<Eigen::Vector2d> outside;
  for (std::size_t i = 0; i < robot_.links().size(); ++i)
    for (const auto& shape : robot_.links()[i].collisions) {
      const Pose base_T_shape = base_T_root * poses[i] * shape.body_T_shape;
      const auto box = box_of(shape.geometry);
      if (box.isEmpty()) continue;
      std::vector<Eigen::Vector3d> corners;
      corners.reserve(8);
      for (int corner = 0; corner < 8; ++corner)
        corners.push_back(base_T_shape * box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
      const bool low = std::any_of(corners.begin(), corners.end(), [&](const Eigen::Vector3d& corner) {
        return corner.z() <= max_height_m_;
      });
      for (const auto& corner : corners)
        if (low && !holds(footprint, corner.head<2>())) outside.emplace_back(corner.head<2>());
    }
  return outside;
}

}  // namespace extperfc::navigate
