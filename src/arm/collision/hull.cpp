#include "arm/collision/hull.hpp"

#include <algorithm>
#include <limits>

#include <LinearMath/btConvexHullComputer.h>

namespace extperfc::arm {
namespace {

constexpr double kThinnest = 1e-4;  // [m]

Eigen::Vector3d from_bullet(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}

/// Normal of a face of the computer's polyhedron, of either sense; zero when its corners lie on one line.
Eigen::Vector3d face_normal(const btConvexHullComputer& hull, int face) {
  const auto* first = &hull.edges[hull.faces[face]];
  const Eigen::Vector3d base = from_bullet(hull.vertices[first->getSourceVertex()]);
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (const auto* edge = first->getNextEdgeOfFace(); edge != first; edge = edge->getNextEdgeOfFace())
    normal += (from_bullet(hull.vertices[edge->getSourceVertex()]) - base)
                  .cross(from_bullet(hull.vertices[edge->getTargetVertex()]) - base);
  return normal.norm() > 1e-14 ? Eigen::Vector3d(normal.normalized()) : Eigen::Vector3d::Zero();
}

Plane outer_plane(const Eigen::Vector3d& normal, const std::vector<Eigen::Vector3d>& points) {
  Plane plane{normal, -std::numeric_limits<double>::infinity()};
  for (const auto& point : points) plane.offset = std::max(plane.offset, normal.dot(point));
  return plane;
}

}  // namespace

Result<ConvexPart> convex_hull(const std::vector<Eigen::Vector3d>& points) {
  if (points.size() < 4) return fail(ErrorCode::kInvalidArgument, "a hull needs four corners or more");
  Eigen::Vector3d low = points.front(), high = low;
  for (const auto& point : points) {
    if (!point.allFinite()) return fail(ErrorCode::kInvalidArgument, "a corner is not finite");
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  ConvexPart part;
  part.kind = PartKind::kHull;
  part.half = (high - low) / 2;
  part.body_T_part.translation() = (high + low) / 2;
  if (part.half.minCoeff() < kThinnest / 2)
    return fail(ErrorCode::kInvalidArgument, "its hull is thinner than 0.1 mm");
  std::vector<Eigen::Vector3d> centred;
  centred.reserve(points.size());
  for (const auto& point : points) centred.emplace_back(point - part.body_T_part.translation());
  btConvexHullComputer computer;
  computer.compute(centred.front().data(), sizeof(Eigen::Vector3d), static_cast<int>(centred.size()), 0, 0);
  for (int i = 0; i < computer.vertices.size(); ++i)
    part.vertices.push_back(from_bullet(computer.vertices[i]));
  if (part.vertices.size() < 4) return fail(ErrorCode::kInvalidArgument, "its corners span no volume");
  for (int face = 0; face < computer.faces.size(); ++face) {
    const Eigen::Vector3d normal = face_normal(computer, face);
    if (normal.isZero()) continue;
    const Plane front = outer_plane(normal, centred), back = outer_plane(-normal, centred);
    if (front.offset + back.offset < kThinnest)
      return fail(ErrorCode::kInvalidArgument, "its hull is thinner than 0.1 mm");
    const auto* edge = &computer.edges[computer.faces[face]];
    const double height = normal.dot(from_bullet(computer.vertices[edge->getSourceVertex()]));
    part.planes.push_back(front.offset - height < back.offset + height ? front : back);
  }
  return part;
}

}  // namespace extperfc::arm
