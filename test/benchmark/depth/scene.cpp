#include "test/benchmark/depth/scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

namespace extperfc::benchmark {

namespace {

constexpr int kMarginPx =
    70;  // rendered around the object: room for windows, bad boxes and the occlusion shadow

/// A ray in the object's frame: z up, origin where the object stands.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
  [[nodiscard]] Eigen::Vector3d at(double t) const { return origin + t * direction; }
};

using Hit = std::optional<double>;  // ray parameter

/// Smallest positive root of a t^2 + 2 b t + c = 0 that `accept` takes.
template <typename Accept>
Hit first_root(double a, double b, double c, Accept accept) {
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0 || a == 0.0) return std::nullopt;
  const double root = std::sqrt(discriminant);
  const auto [near, far] = std::minmax({(-b - root) / a, (-b + root) / a});
  if (near > 0.0 && accept(near)) return near;
  if (far > 0.0 && accept(far)) return far;
  return std::nullopt;
}

Hit hit_sphere(const Ray& ray, double radius) {
  const Eigen::Vector3d o = ray.origin - Eigen::Vector3d(0, 0, radius);
  return first_root(ray.direction.squaredNorm(), o.dot(ray.direction), o.squaredNorm() - radius * radius,
                    [](double) { return true; });
}

/// x^2 + y^2 = slope^2 (height - z)^2 between floor and apex.
Hit hit_cone(const Ray& ray, double height, double radius) {
  const double k = radius * radius / (height * height);
  const Eigen::Vector3d weight(1, 1, -k);
  const Eigen::Vector3d o = ray.origin - Eigen::Vector3d(0, 0, height);
  const Eigen::Vector3d& d = ray.direction;
  return first_root(d.dot(weight.cwiseProduct(d)), o.dot(weight.cwiseProduct(d)),
                    o.dot(weight.cwiseProduct(o)), [&](double t) {
                      const double z = ray.at(t).z();
                      return z >= 0.0 && z <= height;
                    });
}

Hit hit_cube(const Ray& ray, double side) {
  const Eigen::Vector3d low(-0.5 * side, -0.5 * side, 0.0);
  const Eigen::Vector3d high(0.5 * side, 0.5 * side, side);
  double enter = 0.0;
  double leave = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (low[axis] - ray.origin[axis]) / ray.direction[axis];
    const double b = (high[axis] - ray.origin[axis]) / ray.direction[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter > 0.0 && enter <= leave ? Hit(enter) : std::nullopt;
}

Hit hit_object(const Scene& scene, const Ray& ray) {
  switch (scene.shape) {
    case Shape::kCone:
      return hit_cone(ray, scene.size_m, scene.cone_radius_m);
    case Shape::kCube:
      return hit_cube(ray, scene.size_m);
    default:
      return hit_sphere(ray, 0.5 * scene.size_m);
  }
}

/// Rows are the object's axes in the optical frame.
Eigen::Matrix3d object_R_camera(const Scene& scene) {
  const Eigen::Vector3d side = scene.up.unitOrthogonal();
  const Eigen::Vector3d x = Eigen::AngleAxisd(scene.yaw_rad, scene.up) * side;
  Eigen::Matrix3d r;
  r << x.transpose(), scene.up.cross(x).transpose(), scene.up.transpose();
  return r;
}

double hit_plane(const Eigen::Vector3d& normal, const Eigen::Vector3d& point,
                 const Eigen::Vector3d& direction) {
  const double t = normal.dot(point) / normal.dot(direction);
  return t > 0.0 ? t : std::numeric_limits<double>::infinity();
}

/// Generous bounds of the object in the image, with the margin.
cv::Rect surroundings(const Scene& scene, const CameraModel& camera) {
  const Eigen::Vector3d middle = scene.base + 0.5 * scene.size_m * scene.up;
  const Eigen::Vector2d center = camera.project(middle);
  const double reach = kMarginPx + camera.fx * scene.size_m / std::max(0.05, middle.z() - scene.size_m);
  const cv::Rect around(
      cv::Point(static_cast<int>(center.x() - reach), static_cast<int>(center.y() - reach)),
      cv::Point(static_cast<int>(center.x() + reach), static_cast<int>(center.y() + reach)));
  return around & cv::Rect(0, 0, camera.width, camera.height);
}

void measure_object(Rendering& r) {
  const cv::Rect tight = cv::boundingRect(r.object);
  r.box = {static_cast<float>(tight.x), static_cast<float>(tight.y),
           static_cast<float>(tight.x + tight.width), static_cast<float>(tight.y + tight.height)};
  double nearest = std::numeric_limits<double>::infinity();
  for (int v = tight.y; v < tight.y + tight.height; ++v) {
    for (int u = tight.x; u < tight.x + tight.width; ++u) {
      const double distance = std::hypot(u + 0.5 - r.box.center_x(), v + 0.5 - r.box.center_y());
      if (r.object.at<std::uint8_t>(v, u) == 0 || distance >= nearest) continue;
      nearest = distance;
      r.truth_m = r.depth.at<float>(v, u);
    }
  }
}

}  // namespace

Rendering render(const Scene& scene, const CameraModel& camera) {
  Rendering out{cv::Mat::zeros(camera.height, camera.width, CV_32FC1),
                cv::Mat::zeros(camera.height, camera.width, CV_8UC1),
                surroundings(scene, camera),
                {},
                0.0};
  const Eigen::Matrix3d rotation = object_R_camera(scene);
  const Eigen::Vector3d wall_point = scene.base - scene.wall_distance_m * scene.wall;
  for (int v = out.part.y; v < out.part.y + out.part.height; ++v) {
    for (int u = out.part.x; u < out.part.x + out.part.width; ++u) {
      const Eigen::Vector3d direction = camera.back_project(u, v, 1.0);  // the ray parameter is the depth
      const double behind =
          std::min(hit_plane(scene.up, scene.base, direction), hit_plane(scene.wall, wall_point, direction));
      const Hit hit = hit_object(scene, {-(rotation * scene.base), rotation * direction});
      const bool seen = hit && *hit < behind;
      if (seen) out.object.at<std::uint8_t>(v, u) = 255;
      const double depth = seen ? *hit : behind;
      out.depth.at<float>(v, u) = std::isfinite(depth) ? static_cast<float>(depth) : 0.0F;
    }
  }
  measure_object(out);
  return out;
}

}  // namespace extperfc::benchmark
