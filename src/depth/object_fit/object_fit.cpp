#include "extperfc/depth/object_fit.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "extperfc/depth/box_depth.hpp"

#include "depth/object_fit/points.hpp"
#include "depth/object_fit/solid_fit.hpp"
#include "depth/object_fit/support_plane.hpp"

namespace extperfc::depth {
namespace {

constexpr double kRoughness = 0.0005;  // of an object's surface against the ideal shape [m]

const char* name_of(FitShape shape) {
  return shape == FitShape::kCube ? "cube" : shape == FitShape::kSphere ? "sphere" : "cone";
}

Result<void> check_input(const ImageView& depth, const CameraModel& camera, const Box2& box,
                         const Eigen::Vector3d& up) {
  if (depth.empty() || !is_depth(depth.format))
    return fail(ErrorCode::kInvalidArgument, "object fit: give a depth image, 16UC1 or 32FC1");
  if (auto valid = camera.validate(); !valid) return valid;
  if (!(box.area() > 0) || !std::isfinite(box.area()))
    return fail(ErrorCode::kInvalidArgument, "object fit: the box has no area");
  if (!(std::abs(up.norm() - 1) < 1e-3))
    return fail(ErrorCode::kInvalidArgument, "object fit: `up` must be a unit vector");
  return {};
}

/// A point of the object's visible surface.
Result<Eigen::Vector3d> surface_point(const ImageView& depth, const CameraModel& camera, const Box2& box,
                                      const ObjectFitParams& params) {
  BoxDepthParams box_params;
  box_params.min_depth_m = params.min_depth_m;
  box_params.max_depth_m = params.max_depth_m;
  box_params.noise = params.noise;
  const auto found = estimate_depth(depth, box, box_params);
  if (!found) return fail(ErrorCode::kNotFound, "no depth measurements in the box");
  return locate(camera, box, *found).surface;
}

/// Pixels of the box that rise above the support, in the support's frame.
std::vector<SurfaceSample> standing_out(const Points& points, const SupportPlane& support,
                                        const ObjectFitParams& params) {
  const Pose plane_T_camera = support.camera_T_plane.inverse();
  std::vector<SurfaceSample> samples;
  for (const Point& point : points.items) {
    if (!point.in_box || !rises(support, point)) continue;
    const Eigen::Vector3d position = plane_T_camera * point.position;
    if (position.z() > params.max_size_m) continue;
    samples.push_back({position, std::hypot(point.sigma_m, kRoughness)});
  }
  return samples;
}

Result<void> check_fit(FitShape shape, const SolidFit& found, const ObjectFitParams& params) {
  const Eigen::Vector3d size = size_of(shape, found.numbers);
  if (!size.allFinite() || size.minCoeff() < params.min_size_m || size.maxCoeff() > params.max_size_m)
    return fail(ErrorCode::kNotFound, std::string("as a ") + name_of(shape) + " it would be " +
                                          std::to_string(size.maxCoeff()) + " m large");
  if (found.fitting < params.min_fitting || found.rms > params.max_rms)
    return fail(ErrorCode::kNotFound, std::string("the object does not match a ") + name_of(shape) + ": " +
                                          std::to_string(static_cast<int>(100 * found.fitting)) +
                                          " % of its pixels fit");
  return {};
}

/// The numbers of a solid, placed into the optical frame.
ObjectFit place(FitShape shape, const SolidFit& found, const SupportPlane& support, double shared_sigma_m) {
  ObjectFit object;
  object.size_m = size_of(shape, found.numbers);
  Pose plane_T_object = Pose::Identity();
  plane_T_object.translation() << found.numbers[0], found.numbers[1], 0.5 * object.size_m.z();
  if (shape == FitShape::kCube)
    plane_T_object.linear() =
        Eigen::AngleAxisd(found.numbers[3], Eigen::Vector3d::UnitZ()).toRotationMatrix();
  object.camera_T_object = support.camera_T_plane * plane_T_object;
  object.support = support.camera_T_plane * Eigen::Vector3d(found.numbers[0], found.numbers[1], 0);

  // d origin / d numbers; the height is half of the size along z.
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxNumbers> by =
      Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxNumbers>::Zero(3, found.numbers.size());
  by(0, 0) = by(1, 1) = 1;
  by(2, shape == FitShape::kCone ? 3 : 2) = shape == FitShape::kSphere ? 1 : 0.5;
  Eigen::Matrix3d in_plane = by * found.covariance * by.transpose();
  in_plane(2, 2) += support.height_sigma_m * support.height_sigma_m;
  const Eigen::Matrix3d rotation = support.camera_T_plane.linear();
  const Eigen::Vector3d ray = shared_sigma_m * object.camera_T_object.translation().normalized();
  object.covariance = rotation * in_plane * rotation.transpose() + ray * ray.transpose();
  object.size_sigma_m = std::sqrt(found.covariance(2, 2)) * (shape == FitShape::kCube ? 1 : 2);
  object.rms_m = found.rms_m;
  object.support_px = support.pixels;
  return object;
}

}  // namespace

Result<void> validate(const ObjectFitParams& p) {
  const auto need = [](bool good, const char* what) -> Result<void> {
    if (good) return {};
    return fail(ErrorCode::kInvalidArgument, std::string("object fit: ") + what);
  };
  if (auto r = need(p.min_depth_m > 0 && p.max_depth_m > p.min_depth_m, "0 < min_depth_m < max_depth_m"); !r)
    return r;
  if (auto r = need(p.surround >= 0.1 && p.surround <= 3, "surround must be in [0.1, 3]"); !r) return r;
  if (auto r =
          need(p.tilt_sigma_rad >= 1e-4 && p.tilt_sigma_rad <= 0.3, "tilt_sigma_rad must be in [1e-4, 0.3]");
      !r)
    return r;
  if (auto r = need(p.min_size_m > 0 && p.max_size_m > p.min_size_m, "0 < min_size_m < max_size_m"); !r)
    return r;
  if (auto r = need(p.min_object_px >= 10 && p.min_support_px >= 10,
                    "min_object_px and min_support_px must be 10 or more");
      !r)
    return r;
  return need(p.max_rms > 1 && p.min_fitting > 0 && p.min_fitting <= 1,
              "max_rms must be above 1, min_fitting in (0, 1]");
}

Result<ObjectFit> fit_object(const ImageView& depth, const CameraModel& camera, const Box2& box,
                             FitShape shape, const Eigen::Vector3d& up, const ObjectFitParams& params) {
  if (auto valid = validate(params); !valid) return tl::unexpected<Error>(valid.error());
  if (auto valid = check_input(depth, camera, box, up); !valid) return tl::unexpected<Error>(valid.error());
  const auto anchor = surface_point(depth, camera, box, params);
  if (!anchor) return tl::unexpected<Error>(anchor.error());
  const Points points = gather(depth, camera, box, *anchor, params);
  const auto support = find_support(points, up, *anchor, params);
  if (!support) return fail(ErrorCode::kNotFound, "no level support found around the box");
  const auto samples = standing_out(points, *support, params);
  if (static_cast<int>(samples.size()) < params.min_object_px)
    return fail(ErrorCode::kNotFound,
                "only " + std::to_string(samples.size()) + " pixels rise above the support");
  const SolidFit found = fit_solid(shape, samples, points.independent);
  if (auto good = check_fit(shape, found, params); !good) return tl::unexpected<Error>(good.error());
  const double shared = std::sqrt(params.noise.common_fraction) * params.noise.sigma(anchor->z());
  ObjectFit object = place(shape, found, *support, shared);
  object.object_px = static_cast<int>(samples.size());
  return object;
}

}  // namespace extperfc::depth
