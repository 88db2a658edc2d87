#include "extperfc/depth/box_depth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "depth/box_error.hpp"
#include "depth/nearest_layer.hpp"
#include "depth/samples.hpp"
#include "depth/surface_fit.hpp"

namespace extperfc::depth {

namespace {

/// A location estimate before its uncertainty is known.
struct Estimate {
  double depth_m{0};
  double variance_m2{0};  ///< of one sample around it
  double effective{0};    ///< number of samples that a plain mean of the same certainty would need
  double by_box_m{0};     ///< error through a box that is a little off on a slanted surface
};

using Values = std::array<float, Samples::kCapacity>;

Estimate mean_of(const float* begin, const float* end) {
  const auto n = static_cast<double>(end - begin);
  double sum = 0.0;
  for (const float* z = begin; z != end; ++z) sum += *z;
  const double mean = sum / n;
  double squares = 0.0;
  for (const float* z = begin; z != end; ++z) squares += (*z - mean) * (*z - mean);
  return {mean, n > 1.0 ? squares / (n - 1.0) : 0.0, n};
}

Estimate mean(Values& values, int n) {
  return mean_of(values.data(), values.data() + n);
}

Estimate median(Values& values, int n) {
  constexpr double kEfficiency = 0.6366;  // 2 / pi: of the median against the mean under normal noise
  float* const middle = values.data() + n / 2;
  std::nth_element(values.data(), middle, values.data() + n);
  const double upper = *middle;
  const double value = n % 2 == 1 ? upper : 0.5 * (upper + *std::max_element(values.data(), middle));
  return {value, mean_of(values.data(), values.data() + n).variance_m2, kEfficiency * n};
}

Estimate trimmed_mean(Values& values, int n) {
  const int cut = n / 5;
  float* const first = values.data() + cut;
  float* const last = values.data() + n - cut;
  std::nth_element(values.data(), first, values.data() + n);
  std::nth_element(first, last - 1, values.data() + n);
  Estimate result =
      mean_of(values.data(), values.data() + n);  // variance and count of all: its efficiency is 0.95
  result.depth_m = mean_of(first, last).depth_m;
  return result;
}

Estimate window_estimate(const Samples& samples, Estimator estimator) {
  Values values;
  std::transform(samples.begin(), samples.end(), values.begin(), [](const Sample& s) { return s.depth_m; });
  switch (estimator) {
    case Estimator::kMedian:
      return median(values, samples.size);
    case Estimator::kTrimmedMean:
      return trimmed_mean(values, samples.size);
    default:
      return mean(values, samples.size);
  }
}

Estimate nearest_mode(const Samples& samples, const Box2& box, const BoxDepthParams& params) {
  const SurfaceFit fit = fit_surface(samples, nearest_layer(samples, params.noise), params);
  const double by_box =
      std::hypot(fit.slope_x * center_sigma_px(box.width()), fit.slope_y * center_sigma_px(box.height()));
  return {fit.depth_m, fit.variance_m2, fit.effective, by_box};
}

/// The spread inside a patch smaller than the noise's correlation says nothing about the noise, so the model
/// is the lower bound; where background or shape spread the samples more than noise can, the spread counts.
double sigma(const Estimate& e, const Samples& samples, const StereoNoiseModel& noise) {
  const double model = noise.sigma(e.depth_m);
  const double variance = std::max(model * model, e.variance_m2);
  return std::hypot(std::sqrt(variance * noise.variance_left(samples.pixels(e.effective))), e.by_box_m);
}

bool readable(const ImageView& depth) {
  return !depth.empty() && is_depth(depth.format) &&
         depth.row_bytes >= static_cast<std::size_t>(depth.width) * bytes_per_pixel(depth.format);
}

/// The middle of the box, or all of it where the middle has too few valid pixels (holes, the occlusion
/// shadow).
void collect_box(const ImageView& depth, const Box2& box, const BoxDepthParams& params, Samples& out) {
  const Region middle = central_part(box, params.central_fraction, depth.width, depth.height);
  collect(depth, middle, box, params, out);
  if (out.size < params.min_valid_px)
    collect(depth, central_part(box, 1.0, depth.width, depth.height), box, params, out);
}

}  // namespace

std::optional<BoxDepth> estimate_depth(const ImageView& depth, const Box2& box,
                                       const BoxDepthParams& params) {
  if (!readable(depth)) return std::nullopt;
  const auto inside = clip_box(box, depth.width, depth.height);
  if (!inside) return std::nullopt;
  const bool by_mode = params.estimator == Estimator::kNearestMode;
  Samples samples;
  if (by_mode)
    collect_box(depth, *inside, params, samples);
  else
    collect(depth, center_window(*inside, params.window_px, depth.width, depth.height), *inside, params,
            samples);
  if (samples.size < params.min_valid_px) return std::nullopt;
  const Estimate e =
      by_mode ? nearest_mode(samples, *inside, params) : window_estimate(samples, params.estimator);
  return BoxDepth{e.depth_m, sigma(e, samples, params.noise), samples.size,
                  static_cast<double>(samples.size) / samples.looked_at};
}

}  // namespace extperfc::depth
