#include "simulate/worlds/solid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "extperfc/base/math.hpp"

namespace extperfc::simulate {

namespace {
constexpr int kCorners = 32;         // of the polygon that stands for a circle
constexpr double kSamePoint = 1e-9;  // [m]

template <typename... F>
struct Overload : F... {
  using F::operator()...;
};
template <typename... F>
Overload(F...) -> Overload<F...>;

Eigen::Vector3d mesh_half(const TriangleMesh& mesh) {
  return mesh.scale.cwiseAbs() / 2;
}

/// Centre of mass along z in the shape's own frame.
double centroid_z(const Geometry& geometry) {
  const auto* cone = std::get_if<Cone>(&geometry);
  return cone != nullptr ? -cone->height_m / 4 : 0;
}

/// Points and edges whose convex hull is the shape (slightly more for round ones).
struct Wire {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::pair<int, int>> edges;
};

Wire box_wire(const Eigen::Vector3d& half) {
  Wire wire;
  for (int i = 0; i < 8; ++i)
    wire.points.emplace_back((i & 1) != 0 ? half.x() : -half.x(), (i & 2) != 0 ? half.y() : -half.y(),
                             (i & 4) != 0 ? half.z() : -half.z());
  for (int i = 0; i < 8; ++i)
    for (int bit = 1; bit < 8; bit *= 2)
      if ((i & bit) == 0) wire.edges.emplace_back(i, i | bit);
  return wire;
}

/// Rings of corners around circles at given heights, joined by straight lines.
Wire ring_wire(const std::vector<std::pair<double, double>>& radius_and_z) {
  Wire wire;
  const double around = 1 / std::cos(kPi / kCorners);  // the polygon goes around the circle
  for (std::size_t ring = 0; ring < radius_and_z.size(); ++ring)
    for (int i = 0; i < kCorners; ++i) {
      const double angle = 2 * kPi * i / kCorners;
      const auto [radius, z] = radius_and_z[ring];
      const int index = static_cast<int>(wire.points.size());
      wire.points.emplace_back(radius * around * std::cos(angle), radius * around * std::sin(angle), z);
      wire.edges.emplace_back(index, static_cast<int>(ring) * kCorners + (i + 1) % kCorners);
      if (ring > 0) wire.edges.emplace_back(index - kCorners, index);
    }
  return wire;
}

Wire wire_of(const Geometry& geometry) {
  return std::visit(
      Overload{[](const Box& box) { return box_wire(box.size_m / 2); },
               [](const Cylinder& c) {
                 return ring_wire({{c.radius_m, -c.length_m / 2}, {c.radius_m, c.length_m / 2}});
               },
               [](const Cone& c) {
                 return ring_wire({{c.radius_m, -c.height_m / 2}, {0, c.height_m / 2}});
               },
               [](const Sphere&) { return Wire{}; },
               [](const TriangleMesh& mesh) { return box_wire(mesh_half(mesh)); }},
      geometry);
}

/// Points of the part of the wire between two heights, seen from above.
Polygon points_between(const Wire& wire, const Pose& pose, double low, double high) {
  std::vector<Eigen::Vector3d> points;
  points.reserve(wire.points.size());
  for (const auto& point : wire.points) points.emplace_back(pose * point);
  Polygon result;
  for (const auto& point : points)
    if (point.z() >= low && point.z() <= high) result.emplace_back(point.head<2>());
  for (const auto& [from, to] : wire.edges)
    for (const double z : {low, high}) {
      const auto& a = points[static_cast<std::size_t>(from)];
      const auto& b = points[static_cast<std::size_t>(to)];
      if ((a.z() < z) == (b.z() < z)) continue;
      result.emplace_back((a + (b - a) * ((z - a.z()) / (b.z() - a.z()))).head<2>());
    }
  return result;
}

double cross(const Eigen::Vector2d& o, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
}

/// Convex hull by Andrew's monotone chain, counter-clockwise.
Polygon convex_hull(Polygon points) {
  if (points.size() < 3) return {};
  std::sort(points.begin(), points.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  Polygon hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t start = hull.size();
    for (const auto& point : points) {
      while (hull.size() >= start + 2 &&
             cross(hull[hull.size() - 2], hull.back(), point) <= kSamePoint * kSamePoint)
        hull.pop_back();
      hull.push_back(point);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

Polygon circle(const Eigen::Vector2d& centre, double radius) {
  Polygon polygon;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * kPi * i / kCorners;
    polygon.emplace_back(centre + radius / std::cos(kPi / kCorners) *
                                      Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return polygon;
}

std::optional<Polygon> sphere_outline(double radius, const Eigen::Vector3d& centre, double low, double high) {
  const double off = std::max({0.0, low - centre.z(), centre.z() - high});
  if (off >= radius) return std::nullopt;
  return circle(centre.head<2>(), std::sqrt(radius * radius - off * off));
}

/// Whether an edge of `a` has all of `b` on its outer side.
bool edge_separates(const Polygon& a, const Polygon& b, double slack) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Eigen::Vector2d along = a[(i + 1) % a.size()] - a[i];
    if (along.norm() < kSamePoint) continue;
    const Eigen::Vector2d outward = Eigen::Vector2d(along.y(), -along.x()).normalized();
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& point : b) nearest = std::min(nearest, outward.dot(point - a[i]));
    if (nearest >= -slack) return true;
  }
  return false;
}

double half_along(const ShapeBox& box, const Pose& pose, const Eigen::Vector3d& axis) {
  return (pose.linear().transpose() * axis).cwiseAbs().dot(box.half_m);
}

}  // namespace

double volume_m3(const Geometry& geometry) {
  return std::visit(Overload{[](const Box& box) { return box.size_m.prod(); },
                             [](const Cylinder& c) { return kPi * c.radius_m * c.radius_m * c.length_m; },
                             [](const Cone& c) { return kPi * c.radius_m * c.radius_m * c.height_m / 3; },
                             [](const Sphere& s) { return 4.0 / 3 * kPi * std::pow(s.radius_m, 3); },
                             [](const TriangleMesh& mesh) { return mesh.scale.cwiseAbs().prod(); }},
                    geometry);
}

Eigen::Vector3d centre_of_mass(const std::vector<Shape>& shapes) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double total = 0;
  for (const Shape& shape : shapes) {
    const double volume = volume_m3(shape.geometry);
    sum += volume * (shape.body_T_shape * Eigen::Vector3d(0, 0, centroid_z(shape.geometry)));
    total += volume;
  }
  return sum / total;
}

std::optional<Polygon> outline(const Geometry& geometry, const Pose& target_T_shape, double z_low_m,
                               double z_high_m) {
  if (const auto* sphere = std::get_if<Sphere>(&geometry))
    return sphere_outline(sphere->radius_m, target_T_shape.translation(), z_low_m, z_high_m);
  Polygon hull = convex_hull(points_between(wire_of(geometry), target_T_shape, z_low_m, z_high_m));
  if (hull.size() < 3) return std::nullopt;
  return hull;
}

bool overlap(const Polygon& a, const Polygon& b, double slack_m) {
  return !edge_separates(a, b, slack_m) && !edge_separates(b, a, slack_m);
}

double distance_m(const Polygon& polygon, const Eigen::Vector2d& point) {
  bool inside = true;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& from = polygon[i];
    const Eigen::Vector2d along = polygon[(i + 1) % polygon.size()] - from;
    if (cross(from, from + along, point) < 0) inside = false;
    const double fraction = std::clamp(along.dot(point - from) / along.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (point - from - fraction * along).norm());
  }
  return inside ? 0 : nearest;
}

ShapeBox inner_box(const Geometry& geometry) {
  const double root = std::sqrt(0.5);
  return std::visit(
      Overload{
          [](const Box& box) {
            return ShapeBox{box.size_m / 2, Eigen::Vector3d::Zero()};
          },
          [&](const Cylinder& c) {
            return ShapeBox{{c.radius_m * root, c.radius_m * root, c.length_m / 2}, Eigen::Vector3d::Zero()};
          },
          [&](const Cone& c) {  // the lower half, as wide as the cone is in the middle
            const double half = c.radius_m * root / 2;
            return ShapeBox{{half, half, c.height_m / 4}, {0, 0, -c.height_m / 4}};
          },
          [](const Sphere& s) {
            const double half = s.radius_m / std::sqrt(3.0);
            return ShapeBox{{half, half, half}, Eigen::Vector3d::Zero()};
          },
          [](const TriangleMesh& mesh) {
            return ShapeBox{mesh_half(mesh) / 2, Eigen::Vector3d::Zero()};
          }},
      geometry);
}

ShapeBox outer_box(const Geometry& geometry) {
  const Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  return std::visit(Overload{[&](const Box& box) {
                               return ShapeBox{box.size_m / 2, origin};
                             },
                             [&](const Cylinder& c) {
                               return ShapeBox{{c.radius_m, c.radius_m, c.length_m / 2}, origin};
                             },
                             [&](const Cone& c) {
                               return ShapeBox{{c.radius_m, c.radius_m, c.height_m / 2}, origin};
                             },
                             [&](const Sphere& s) {
                               return ShapeBox{Eigen::Vector3d::Constant(s.radius_m), origin};
                             },
                             [&](const TriangleMesh& mesh) {
                               return ShapeBox{mesh_half(mesh), origin};
                             }},
                    geometry);
}

double box_overlap_m(const ShapeBox& a, const Pose& world_T_a, const ShapeBox& b, const Pose& world_T_b) {
  const Eigen::Vector3d apart = world_T_b * b.centre_m - world_T_a * a.centre_m;
  std::vector<Eigen::Vector3d> axes;
  for (int i = 0; i < 3; ++i) {
    axes.emplace_back(world_T_a.linear().col(i));
    axes.emplace_back(world_T_b.linear().col(i));
    for (int j = 0; j < 3; ++j) axes.emplace_back(world_T_a.linear().col(i).cross(world_T_b.linear().col(j)));
  }
  double overlap_m = std::numeric_limits<double>::infinity();
  for (const auto& raw : axes) {
    if (raw.norm() < 1e-6) continue;  // parallel edges: their other axes decide
    const Eigen::Vector3d axis = raw.normalized();
    overlap_m = std::min(overlap_m, half_along(a, world_T_a, axis) + half_along(b, world_T_b, axis) -
                                        std::abs(axis.dot(apart)));
  }
  return overlap_m;
}

}  // namespace extperfc::simulate
