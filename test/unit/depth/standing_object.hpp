#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "extperfc/base/rng.hpp"
#include "extperfc/depth/object_fit.hpp"

#include "test/unit/depth/depth_image.hpp"

/// Images of an object on a table, by closed-form rays.
namespace extperfc::depth {

/// What stands where. The world's z is up, the table's top is z = 0.
struct Standing {
  FitShape shape{FitShape::kCube};
  double width_m{0.05};   // edge, diameter
  double height_m{0.05};  // of a cone
  double yaw_rad{0};
  [[nodiscard]] double height() const { return shape == FitShape::kCone ? height_m : width_m; }
};

inline void keep_nearest(double t, double& nearest) {
  if (t > 0.01) nearest = std::min(nearest, t);
}

/// Smaller root of a t^2 + 2 b t + c; infinity when there is none.
inline double first_root(double a, double b, double c) {
  const double d = b * b - a * c;
  return d < 0 ? std::numeric_limits<double>::infinity() : (-b - std::sqrt(d)) / a;
}

inline double ray_sphere(const Standing& o, const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d away = from - Eigen::Vector3d(0, 0, o.width_m / 2);
  return first_root(ray.squaredNorm(), away.dot(ray), away.squaredNorm() - std::pow(o.width_m / 2, 2));
}

inline double ray_cone(const Standing& o, const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
  const double slope = o.width_m / 2 / o.height_m;  // x^2 + y^2 = slope^2 (height - z)^2
  const double s2 = slope * slope;
  const double up = o.height_m - from.z();
  const double a = ray.head<2>().squaredNorm() - s2 * ray.z() * ray.z();
  const double b = from.head<2>().dot(ray.head<2>()) + s2 * up * ray.z();
  const double c = from.head<2>().squaredNorm() - s2 * up * up;
  const double root = std::sqrt(b * b - a * c);
  double nearest = std::numeric_limits<double>::infinity();
  for (const double t : {(-b - root) / a, (-b + root) / a}) {
    const double z = from.z() + t * ray.z();
    if (z >= 0 && z <= o.height_m) keep_nearest(t, nearest);
  }
  return nearest;
}

inline double ray_cube(const Standing& o, const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
  const Eigen::AngleAxisd rotation(-o.yaw_rad, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d start = rotation * from - Eigen::Vector3d(0, 0, o.width_m / 2);
  const Eigen::Vector3d direction = rotation * ray;
  double in = 0;
  double out = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double a = (-o.width_m / 2 - start[i]) / direction[i];
    const double b = (o.width_m / 2 - start[i]) / direction[i];
    in = std::max(in, std::min(a, b));
    out = std::min(out, std::max(a, b));
  }
  return in <= out ? in : std::numeric_limits<double>::infinity();
}

inline double ray_object(const Standing& o, const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
  const double t = o.shape == FitShape::kSphere ? ray_sphere(o, from, ray)
                   : o.shape == FitShape::kCone ? ray_cone(o, from, ray)
                                                : ray_cube(o, from, ray);
  return std::isfinite(t) && t > 0 ? t : std::numeric_limits<double>::infinity();
}

inline CameraModel fit_camera() {
  return {640, 480, 615.0, 615.0, 319.5, 239.5, {}};
}

/// An image, the object's tight box, and where it is.
struct View {
  DepthImage depth{640, 480};
  Box2 box;
  Pose camera_T_world{Pose::Identity()};  // the object stands at the world's origin
  [[nodiscard]] Eigen::Vector3d up() const { return camera_T_world.linear().col(2); }
  [[nodiscard]] Eigen::Vector3d middle(const Standing& object) const {
    return camera_T_world * Eigen::Vector3d(0, 0, object.height() / 2);
  }
};

/// The D435i's noise (StereoNoiseModel): disparity errors of patches, of single pixels none, of the whole
/// image a little; beside edges of depth every third pixel is lost.
class PatchNoise {
 public:
  PatchNoise(const StereoNoiseModel& model, Rng& rng) : patch_(static_cast<int>(model.correlation_px)) {
    const double own = std::sqrt(1 - model.common_fraction);
    common_ = rng.normal(0, std::sqrt(model.common_fraction) * model.sigma_inverse_depth());
    for (auto& value : patches_) value = rng.normal(0, own * model.sigma_inverse_depth());
  }
  [[nodiscard]] double measured(int x, int y, double z) const {
    return 1 / (1 / z + common_ + patches_[(y / patch_) * kColumns + x / patch_]);
  }

 private:
  static constexpr int kColumns = 100;
  int patch_;
  double common_{0};
  std::vector<double> patches_ = std::vector<double>(kColumns * kColumns);
};

/// Seen from `distance_m` (of the object's middle), `down_rad` below the horizon, at a random place of the
/// image. `table_m`: half of the table's width; beyond is a floor 0.8 m below. `noise`: none without.
/// `surround`: how far around the object's middle is rendered, in its sizes.
inline View view_of(const Standing& object, double distance_m, double down_rad, Rng& rng,
                    const std::optional<StereoNoiseModel>& noise, double table_m = 10,
                    double surround = 1.8) {
  View view;
  const double rotation = rng.uniform(-3.1, 3.1);
  Eigen::Matrix3d world_R_camera;
  const Eigen::Vector3d forward(std::cos(down_rad) * std::cos(rotation),
                                std::cos(down_rad) * std::sin(rotation), -std::sin(down_rad));
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  world_R_camera << right, forward.cross(right), forward;
  const CameraModel camera = fit_camera();
  const Eigen::Vector3d ray_to =
      camera.back_project(rng.uniform(200, 440), rng.uniform(160, 320), 1).normalized();
  Pose world_T_camera = Pose::Identity();
  world_T_camera.linear() = world_R_camera;
  world_T_camera.translation() =
      Eigen::Vector3d(0, 0, object.height() / 2) - world_R_camera * (distance_m * ray_to);
  view.camera_T_world = world_T_camera.inverse();

  const Eigen::Vector3d from = world_T_camera.translation();
  std::vector<double> true_z(640 * 480);
  std::vector<bool> is_object(640 * 480);
  Box2 box{1e6F, 1e6F, -1, -1};
  // Only the object's surroundings are rendered: the rest has no measurement.
  const Eigen::Vector2d at = camera.project(view.middle(object));
  const double reach = surround * std::max(object.width_m, object.height()) * camera.fx / distance_m + 20;
  const auto near = [reach](double middle, int upper, double sign) {
    return static_cast<int>(std::clamp(middle + sign * reach, 0.0, static_cast<double>(upper)));
  };
  for (int y = near(at.y(), 480, -1); y < near(at.y(), 480, 1); ++y)
    for (int x = near(at.x(), 640, -1); x < near(at.x(), 640, 1); ++x) {
      const Eigen::Vector3d ray = world_R_camera * camera.back_project(x, y, 1);
      const double on_object = ray_object(object, from, ray);
      double background = ray.z() < 0 ? -from.z() / ray.z() : 20;
      if ((from + background * ray).head<2>().cwiseAbs().maxCoeff() > table_m)
        background = ray.z() < 0 ? -(from.z() + 0.8) / ray.z() : 20;
      const std::size_t i = static_cast<std::size_t>(y) * 640 + static_cast<std::size_t>(x);
      is_object[i] = on_object < background;
      true_z[i] = std::min(on_object, background);
      if (!is_object[i]) continue;
      box = {std::min(box.x_min, static_cast<float>(x)), std::min(box.y_min, static_cast<float>(y)),
             std::max(box.x_max, static_cast<float>(x + 1)), std::max(box.y_max, static_cast<float>(y + 1))};
    }
  view.box = box;
  const PatchNoise errors(noise.value_or(StereoNoiseModel{}), rng);
  view.depth.fill([&](int x, int y) {
    const std::size_t i = static_cast<std::size_t>(y) * 640 + static_cast<std::size_t>(x);
    const double z = true_z[i];
    if (z == 0 || z > 10) return 0.0;
    if (!noise) return z;
    const bool at_edge = x > 0 && std::abs(true_z[i - 1] - z) > 0.02 * z;
    if ((at_edge && rng.chance(0.35)) || rng.chance(0.002)) return 0.0;
    return errors.measured(x, y, z);
  });
  return view;
}

/// A detection's box: off by 3 % (middle) and 5 % (size) of its sides.
inline Box2 jittered(const Box2& box, Rng& rng) {
  const double w = box.width() * (1 + rng.normal(0, 0.05));
  const double h = box.height() * (1 + rng.normal(0, 0.05));
  const double x = box.center_x() + rng.normal(0, 0.03) * box.width();
  const double y = box.center_y() + rng.normal(0, 0.03) * box.height();
  return {static_cast<float>(x - w / 2), static_cast<float>(y - h / 2), static_cast<float>(x + w / 2),
          static_cast<float>(y + h / 2)};
}

}  // namespace extperfc::depth
