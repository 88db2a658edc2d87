#include "extperfc/navigate/overhang.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "extperfc/base/math.hpp"

#include "navigate/costs/polygon.hpp"

namespace extperfc::navigate {

namespace {

constexpr int kCirclePoints = 12;

/// Corners of a polygon around a circle about the z axis.
void add_circle(double radius_m, double z_m, std::vector<Eigen::Vector3d>& points) {
  const double outer_m = radius_m / std::cos(kPi / kCirclePoints);
  for (int i = 0; i < kCirclePoints; ++i) {
    const double angle = kTwoPi * i / kCirclePoints;
    points.emplace_back(outer_m * std::cos(angle), outer_m * std::sin(angle), z_m);
  }
}

void add_box(const Eigen::AlignedBox3d& box, std::vector<Eigen::Vector3d>& points) {
  for (int corner = 0; corner < 8; ++corner)
    points.push_back(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
}

/// Points whose convex hull holds a shape: those of a round one lie up to 4 % of its radius outside. A mesh
/// is the box around it; one that is not in memory the box that its scale spans.
std::vector<Eigen::Vector3d> points_around(const Geometry& geometry) {
  std::vector<Eigen::Vector3d> points;
  if (const auto* box = std::get_if<Box>(&geometry)) {
    add_box({-box->size_m / 2, box->size_m / 2}, points);
  } else if (const auto* cylinder = std::get_if<Cylinder>(&geometry)) {
    for (const double z_m : {-cylinder->length_m / 2, cylinder->length_m / 2})
      add_circle(cylinder->radius_m, z_m, points);
  } else if (const auto* sphere = std::get_if<Sphere>(&geometry)) {
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(sphere->radius_m);
    add_box({-half, half}, points);
  } else if (const auto* cone = std::get_if<Cone>(&geometry)) {
    add_circle(cone->radius_m, -cone->height_m / 2, points);
    points.emplace_back(0, 0, cone->height_m / 2);
  } else {
    const auto& mesh = std::get<TriangleMesh>(geometry);
    Eigen::AlignedBox3d all;
    if (!mesh.triangles)
      all = Eigen::AlignedBox3d(-mesh.scale, mesh.scale);
    else
      for (const auto& triangle : *mesh.triangles)
        for (const auto& corner : triangle) all.extend(corner.cast<double>().cwiseProduct(mesh.scale).eval());
    if (!all.isEmpty()) add_box(all, points);
  }
  return points;
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
      auto corners = points_around(shape.geometry);
      for (auto& corner : corners) corner = base_T_shape * corner;
      const bool low = std::any_of(corners.begin(), corners.end(), [&](const Eigen::Vector3d& corner) {
        return corner.z() <= max_height_m_;
      });
      for (const auto& corner : corners)
        if (low && !holds(footprint, corner.head<2>())) outside.emplace_back(corner.head<2>());
    }
  return outside;
}

}  // namespace extperfc::navigate
