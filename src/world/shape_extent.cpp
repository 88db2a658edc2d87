#include "extperfc/world/shape_extent.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace extperfc {

namespace {

constexpr VerticalExtent kEmpty{std::numeric_limits<double>::infinity(),
                                -std::numeric_limits<double>::infinity()};

VerticalExtent both(const VerticalExtent& a, const VerticalExtent& b) {
  return {std::min(a.low_m, b.low_m), std::max(a.high_m, b.high_m)};
}

VerticalExtent around(double z_m, double half_m) {
  return {z_m - half_m, z_m + half_m};
}

/// Extents about the origin of a shape; `up` is the target's z axis in the shape's frame.
struct About {
  Eigen::Vector3d up;

  /// Half the height of a level disc about z that was tilted with the shape.
  [[nodiscard]] double disc_m(double radius_m) const { return radius_m * std::hypot(up.x(), up.y()); }

  VerticalExtent operator()(const Box& box) const { return around(0, up.cwiseAbs().dot(box.size_m) / 2); }
  VerticalExtent operator()(const Sphere& sphere) const { return around(0, sphere.radius_m); }
  VerticalExtent operator()(const Cylinder& cylinder) const {
    return around(0, std::abs(up.z()) * cylinder.length_m / 2 + disc_m(cylinder.radius_m));
  }
  VerticalExtent operator()(const Cone& cone) const {
    const double tip_m = up.z() * cone.height_m / 2;
    return both(around(tip_m, 0), around(-tip_m, disc_m(cone.radius_m)));
  }
  VerticalExtent operator()(const TriangleMesh& mesh) const {
    if (!mesh.triangles) return around(0, up.cwiseAbs().dot(mesh.scale.cwiseAbs()) / 2);
    VerticalExtent all = kEmpty;
    for (const Triangle& triangle : *mesh.triangles)
      for (const auto& corner : triangle)
        all = both(all, around(up.dot(corner.cast<double>().cwiseProduct(mesh.scale)), 0));
    return all;
  }
};

}  // namespace

VerticalExtent vertical_extent(const Geometry& geometry, const Pose& target_T_shape) {
  const double z_m = target_T_shape.translation().z();
  const VerticalExtent about = std::visit(About{target_T_shape.linear().row(2).transpose()}, geometry);
  return {z_m + about.low_m, z_m + about.high_m};
}

VerticalExtent vertical_extent(const std::vector<Shape>& shapes, const Pose& target_T_body) {
  VerticalExtent all = kEmpty;
  for (const Shape& shape : shapes)
    all = both(all, vertical_extent(shape.geometry, target_T_body * shape.body_T_shape));
  return all;
}

}  // namespace extperfc
