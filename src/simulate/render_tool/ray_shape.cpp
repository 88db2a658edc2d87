#include "simulate/render_tool/ray_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace extperfc::simulate {

namespace {

/// Part of a ray, by its parameter.
struct RaySpan {
  double from{0};
  double to{std::numeric_limits<double>::infinity()};

  [[nodiscard]] bool empty() const { return !(from <= to); }
  void cut(double low, double high) {
    from = std::max(from, low);
    to = std::min(to, high);
  }
};

/// Where |origin + t direction| <= half along one axis.
void cut_slab(RaySpan& span, double origin, double direction, double half) {
  if (direction == 0) {
    if (std::abs(origin) > half) span.to = -1;
    return;
  }
  const double a = (-half - origin) / direction;
  const double b = (half - origin) / direction;
  span.cut(std::min(a, b), std::max(a, b));
}

/// Where a t^2 + 2 b t + c <= 0, for a > 0.
void cut_quadric(RaySpan& span, double a, double b, double c) {
  const double root = b * b - a * c;
  if (a <= 0) {  // along a cylinder's axis
    if (c > 0) span.to = -1;
  } else if (root < 0) {
    span.to = -1;
  } else {
    span.cut((-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a);
  }
}

bool meets_cone(const Ray& ray, const Cone& cone) {
  RaySpan span;
  cut_slab(span, ray.origin.z(), ray.direction.z(), cone.height_m / 2);
  if (span.empty()) return false;
  // x^2 + y^2 <= (k (tip - z))^2 within the slab. Not convex in t in general: the ends and the least value
  // of the quadratic within the span decide.
  const double k = cone.radius_m / cone.height_m;
  const double below_tip = cone.height_m / 2 - ray.origin.z();
  const double a = ray.direction.head<2>().squaredNorm() - k * k * ray.direction.z() * ray.direction.z();
  const double b = ray.origin.head<2>().dot(ray.direction.head<2>()) + k * k * below_tip * ray.direction.z();
  const double c = ray.origin.head<2>().squaredNorm() - k * k * below_tip * below_tip;
  const auto value = [&](double t) { return (a * t + 2 * b) * t + c; };
  const double far = std::isfinite(span.to) ? span.to : 1e6;
  const double lowest = a > 0 ? std::clamp(-b / a, span.from, far) : span.from;
  return value(span.from) <= 0 || value(far) <= 0 || value(lowest) <= 0;
}

bool meets_box(const Ray& ray, const Eigen::Vector3d& half) {
  RaySpan span;
  for (int axis = 0; axis < 3; ++axis) cut_slab(span, ray.origin[axis], ray.direction[axis], half[axis]);
  return !span.empty();
}

bool meets_cylinder(const Ray& ray, const Cylinder& cylinder) {
  RaySpan span;
  cut_slab(span, ray.origin.z(), ray.direction.z(), cylinder.length_m / 2);
  cut_quadric(span, ray.direction.head<2>().squaredNorm(), ray.origin.head<2>().dot(ray.direction.head<2>()),
              ray.origin.head<2>().squaredNorm() - cylinder.radius_m * cylinder.radius_m);
  return !span.empty();
}

bool meets_sphere(const Ray& ray, double radius) {
  RaySpan span;
  cut_quadric(span, ray.direction.squaredNorm(), ray.origin.dot(ray.direction),
              ray.origin.squaredNorm() - radius * radius);
  return !span.empty();
}

}  // namespace

bool meets(const Ray& ray, const Geometry& geometry) {
  if (const auto* box = std::get_if<Box>(&geometry)) return meets_box(ray, box->size_m / 2);
  if (const auto* cylinder = std::get_if<Cylinder>(&geometry)) return meets_cylinder(ray, *cylinder);
  if (const auto* sphere = std::get_if<Sphere>(&geometry)) return meets_sphere(ray, sphere->radius_m);
  if (const auto* cone = std::get_if<Cone>(&geometry)) return meets_cone(ray, *cone);
  return false;
}

double bounding_radius_m(const Geometry& geometry) {
  if (const auto* box = std::get_if<Box>(&geometry)) return box->size_m.norm() / 2;
  if (const auto* cylinder = std::get_if<Cylinder>(&geometry))
    return std::hypot(cylinder->radius_m, cylinder->length_m / 2);
  if (const auto* sphere = std::get_if<Sphere>(&geometry)) return sphere->radius_m;
  if (const auto* cone = std::get_if<Cone>(&geometry)) return std::hypot(cone->radius_m, cone->height_m / 2);
  return 0;
}

}  // namespace extperfc::simulate
