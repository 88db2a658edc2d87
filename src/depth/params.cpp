#include <array>
#include <cmath>

#include "extperfc/depth/box_depth.hpp"

namespace extperfc::depth {

namespace {

struct Name {
  Estimator estimator;
  const char* text;
};

constexpr std::array<Name, 4> kNames{{{Estimator::kMean, "mean"},
                                      {Estimator::kMedian, "median"},
                                      {Estimator::kTrimmedMean, "trimmed_mean"},
                                      {Estimator::kNearestMode, "nearest_mode"}}};

/// A value that must hold, with its name and range for the message.
struct Check {
  bool ok;
  const char* what;
  double value;
};

bool positive(double value) {
  return std::isfinite(value) && value > 0.0;
}

}  // namespace

Result<Estimator> estimator_from_name(const std::string& name) {
  for (const auto& entry : kNames)
    if (name == entry.text) return entry.estimator;
  return fail(ErrorCode::kInvalidArgument,
              "unknown depth estimator '" + name + "'; use mean, median, trimmed_mean or nearest_mode");
}

const char* to_string(Estimator estimator) {
  for (const auto& entry : kNames)
    if (estimator == entry.estimator) return entry.text;
  return "unknown";
}

Result<void> validate(const BoxDepthParams& p) {
  const StereoNoiseModel& noise = p.noise;
  const std::array<Check, 10> checks{{
      {p.window_px >= 1 && p.window_px <= 1000, "window_px must be in [1, 1000]",
       static_cast<double>(p.window_px)},
      {p.central_fraction > 0.0 && p.central_fraction <= 1.0, "central_fraction must be in (0, 1]",
       p.central_fraction},
      {positive(p.min_depth_m), "min_depth_m must be positive and finite", p.min_depth_m},
      {std::isfinite(p.max_depth_m) && p.max_depth_m > p.min_depth_m,
       "max_depth_m must be finite and above min_depth_m", p.max_depth_m},
      {p.min_valid_px >= 1, "min_valid_px must be at least 1", static_cast<double>(p.min_valid_px)},
      {positive(noise.focal_px), "noise.focal_px must be positive and finite", noise.focal_px},
      {positive(noise.baseline_m), "noise.baseline_m must be positive and finite", noise.baseline_m},
      {positive(noise.subpixel_px), "noise.subpixel_px must be positive and finite", noise.subpixel_px},
      {std::isfinite(noise.correlation_px) && noise.correlation_px >= 1.0,
       "noise.correlation_px must be finite and at least 1", noise.correlation_px},
      {noise.common_fraction >= 0.0 && noise.common_fraction <= 1.0,
       "noise.common_fraction must be in [0, 1]", noise.common_fraction},
  }};
  for (const auto& check : checks)
    if (!check.ok)
      return fail(ErrorCode::kInvalidArgument,
                  std::string("box depth: ") + check.what + ", not " + std::to_string(check.value));
  return {};
}

}  // namespace extperfc::depth
