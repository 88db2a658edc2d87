#include "extperfc/depth/object_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "depth/depth_pixel.hpp"
#include "depth/nearest_layer.hpp"
#include "depth/object_fit/points.hpp"
#include "depth/object_fit/support_plane.hpp"
#include "depth/samples.hpp"

namespace extperfc::depth {

namespace {

constexpr double kNoiseSteps = 5.0;   // standard deviations between two neighbours
constexpr double kMaxSlant = 5.7;     // tangent of the angle between ray and normal, 80 degrees
constexpr double kDepthStep = 0.001;  // of depth in whole millimetres, between two neighbours [m]

/// Pixels of a box that were reached from its middle.
class Growth {
 public:
  Growth(const ImageView& depth, const CameraModel& camera, const Region& region,
         const BoxDepthParams& params)
      : depth_(depth),
        region_(region),
        params_(params),
        footprint_(1.0 / std::min(camera.fx, camera.fy)),
        reached_(static_cast<std::size_t>(region.width()) * static_cast<std::size_t>(region.height()),
                 false) {}

  [[nodiscard]] double valid_depth(int x, int y) const {
    const double z = depth_at(depth_, x, y);
    return z >= params_.min_depth_m && z <= params_.max_depth_m ? z : 0.0;  // NaN compares false
  }

  void seed(const Region& middle, const Layer& layer) {
    const double extent = std::max(region_.width(), region_.height()) * footprint_ * layer.far_m;
    deepest_ = layer.far_m + extent;
    for (int y = middle.y0; y < middle.y1; ++y)
      for (int x = middle.x0; x < middle.x1; ++x)
        if (const double z = valid_depth(x, y); z >= layer.near_m && z <= layer.far_m) reach(x, y);
  }

  void grow() {
    while (!border_.empty()) {
      const auto [x, y] = border_.back();
      border_.pop_back();
      const double z = valid_depth(x, y);
      for (const auto& [dx, dy] : {std::pair(-1, 0), {1, 0}, {0, -1}, {0, 1}}) {
        const bool hole = inside(x + dx, y + dy) && valid_depth(x + dx, y + dy) == 0.0;
        const int step = hole ? 2 : 1;  // a hole of one pixel does not divide a surface
        const int next_x = x + step * dx;
        const int next_y = y + step * dy;
        if (inside(next_x, next_y) && !is_reached(next_x, next_y) &&
            joins(z, valid_depth(next_x, next_y), step))
          reach(next_x, next_y);
      }
    }
  }

  [[nodiscard]] bool is_reached(int x, int y) const { return reached_[index(x, y)]; }

 private:
  [[nodiscard]] bool inside(int x, int y) const {
    return x >= region_.x0 && x < region_.x1 && y >= region_.y0 && y < region_.y1;
  }
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - region_.y0) * static_cast<std::size_t>(region_.width()) +
           static_cast<std::size_t>(x - region_.x0);
  }
  [[nodiscard]] bool joins(double z, double next, int step) const {
    if (!(next > 0.0 && next <= deepest_)) return false;
    return std::abs(next - z) <=
           kNoiseSteps * params_.noise.sigma(z) + step * kMaxSlant * footprint_ * z + kDepthStep;
  }
  void reach(int x, int y) {
    reached_[index(x, y)] = true;
    border_.emplace_back(x, y);
  }

  const ImageView& depth_;
  Region region_;
  const BoxDepthParams& params_;
  double footprint_;  // of a pixel at 1 m [m]
  double deepest_{0};
  std::vector<bool> reached_;
  std::vector<std::pair<int, int>> border_;
};

/// The middle of the box, or all of it where the middle has too few valid pixels; and its nearest layer.
std::optional<std::pair<Region, Layer>> find_seeds(const ImageView& depth, const Box2& box,
                                                   const BoxDepthParams& params) {
  for (const double fraction : {params.central_fraction, 1.0}) {
    const Region region = central_part(box, fraction, depth.width, depth.height);
    Samples samples;
    collect(depth, region, box, params, samples);
    if (samples.size >= params.min_valid_px) return std::pair(region, nearest_layer(samples, params.noise));
  }
  return std::nullopt;
}

std::optional<SupportPlane> support_of(const ImageView& depth, const CameraModel& camera, const Box2& box,
                                       const BoxDepthParams& params,
                                       const std::optional<Eigen::Vector3d>& up) {
  if (!up) return std::nullopt;
  const auto estimate = estimate_depth(depth, box, params);
  if (!estimate) return std::nullopt;
  ObjectFitParams fit;
  fit.min_depth_m = std::max(params.min_depth_m, 1e-3);
  fit.max_depth_m = params.max_depth_m;
  fit.noise = params.noise;
  const Eigen::Vector3d anchor = locate(camera, box, *estimate).surface;
  return find_support(gather(depth, camera, box, anchor, fit), *up, anchor, fit);
}

}  // namespace

Result<ObjectCloud> object_cloud(const ImageView& depth, const CameraModel& camera, const Box2& box,
                                 const BoxDepthParams& params, const std::optional<Eigen::Vector3d>& up) {
  if (depth.empty() || !is_depth(depth.format))
    return fail(ErrorCode::kInvalidArgument, "object cloud: give a depth image, 16UC1 or 32FC1");
  const auto inside = clip_box(box, depth.width, depth.height);
  if (!inside) return fail(ErrorCode::kInvalidArgument, "object cloud: the box has no area inside the image");
  const auto seeds = find_seeds(depth, *inside, params);
  if (!seeds) return fail(ErrorCode::kNotFound, "object cloud: no depth measurements in the box");

  const Region region = central_part(*inside, 1.0, depth.width, depth.height);
  Growth growth(depth, camera, region, params);
  growth.seed(seeds->first, seeds->second);
  growth.grow();
  const auto support = support_of(depth, camera, *inside, params, up);
  ObjectCloud cloud;
  for (int y = region.y0; y < region.y1; ++y)
    for (int x = region.x0; x < region.x1; ++x) {
      const double z = growth.valid_depth(x, y);
      if (z == 0.0) continue;
      const Point point = point_at(camera, x, y, z, params.noise);
      const bool on_support = support && !rises(*support, point);
      if (growth.is_reached(x, y) && !on_support)
        cloud.points.push_back(point.position.cast<float>());
      else
        ++cloud.background_px;
      if (on_support) ++cloud.support_px;
    }
  if (cloud.points.size() < static_cast<std::size_t>(params.min_valid_px))
    return fail(ErrorCode::kNotFound, "object cloud: only " + std::to_string(cloud.points.size()) +
                                          " pixels of the box belong to an object");
  return cloud;
}

}  // namespace extperfc::depth
