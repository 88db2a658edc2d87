#include <array>
#include <cmath>
#include <string>

#include "extperfc/localize/localizer.hpp"

#include "localize/wrong.hpp"

namespace extperfc::localize {

namespace {

struct RealRange {
  const char* name;
  double LocalizerParams::*value;
  double low;
  double high;
  bool low_is_in;
};

constexpr double kAny = 1e9;  // finite, so that infinity is refused

constexpr std::array kRealRanges{
    RealRange{"kld_err", &LocalizerParams::kld_err, 0, 1, false},
    RealRange{"kld_z", &LocalizerParams::kld_z, 0.5, 1, false},
    RealRange{"update_min_d", &LocalizerParams::update_min_d, 0, kAny, true},
    RealRange{"update_min_a", &LocalizerParams::update_min_a, 0, kAny, true},
    RealRange{"recovery_alpha_slow", &LocalizerParams::recovery_alpha_slow, 0, 1, true},
    RealRange{"recovery_alpha_fast", &LocalizerParams::recovery_alpha_fast, 0, 1, true},
    RealRange{"laser_min_range", &LocalizerParams::laser_min_range, -1, kAny, true},
    RealRange{"laser_max_range", &LocalizerParams::laser_max_range, -1, kAny, true},
    RealRange{"laser_z_hit", &LocalizerParams::laser_z_hit, 0, kAny, true},
    RealRange{"laser_z_short", &LocalizerParams::laser_z_short, 0, kAny, true},
    RealRange{"laser_z_max", &LocalizerParams::laser_z_max, 0, kAny, true},
    RealRange{"laser_z_rand", &LocalizerParams::laser_z_rand, 0, kAny, true},
    RealRange{"laser_sigma_hit", &LocalizerParams::laser_sigma_hit, 0, kAny, false},
    RealRange{"laser_lambda_short", &LocalizerParams::laser_lambda_short, 0, kAny, false},
    RealRange{"laser_likelihood_max_dist", &LocalizerParams::laser_likelihood_max_dist, 0, kAny, false},
    RealRange{"odom_alpha1", &LocalizerParams::odom_alpha1, 0, kAny, true},
    RealRange{"odom_alpha2", &LocalizerParams::odom_alpha2, 0, kAny, true},
    RealRange{"odom_alpha3", &LocalizerParams::odom_alpha3, 0, kAny, true},
    RealRange{"odom_alpha4", &LocalizerParams::odom_alpha4, 0, kAny, true},
    RealRange{"odom_alpha5", &LocalizerParams::odom_alpha5, 0, kAny, true}};

Result<void> check_integers(const LocalizerParams& p) {
  constexpr int kMaxParticles = 1'000'000;
  constexpr int kMaxBeams = 10'000;
  if (p.max_particles < 1 || p.max_particles > kMaxParticles)
    return wrong("max_particles is " + std::to_string(p.max_particles) + ", must lie in [1, 1000000]");
  if (p.min_particles < 1 || p.min_particles > p.max_particles)
    return wrong("min_particles is " + std::to_string(p.min_particles) +
                 ", must lie in [1, max_particles = " + std::to_string(p.max_particles) + "]");
  if (p.resample_interval < 1)
    return wrong("resample_interval is " + std::to_string(p.resample_interval) + ", must be 1 or more");
  if (p.laser_max_beams < 2 || p.laser_max_beams > kMaxBeams)
    return wrong("laser_max_beams is " + std::to_string(p.laser_max_beams) + ", must lie in [2, 10000]");
  return {};
}

Result<void> check_combinations(const LocalizerParams& p) {
  // Without a minimum likelihood a single outlier would exclude a pose.
  if (p.laser_z_hit <= 0) return wrong("laser_z_hit is 0: all poses would be equally likely; set e.g. 0.95");
  if (p.laser_z_rand <= 0)
    return wrong("laser_z_rand is 0: a single outlier would exclude a pose; set e.g. 0.05");
  if (p.laser_min_range >= 0 && p.laser_max_range >= 0 && p.laser_max_range <= p.laser_min_range)
    return wrong("laser_max_range " + std::to_string(p.laser_max_range) + " is not above laser_min_range " +
                 std::to_string(p.laser_min_range));
  return {};
}

}  // namespace

Result<void> validate(const LocalizerParams& params) {
  if (auto checked = check_integers(params); !checked) return checked;
  for (const RealRange& range : kRealRanges) {
    const double value = params.*range.value;
    const bool inside = (range.low_is_in ? value >= range.low : value > range.low) &&
                        (range.high == 1 ? value < range.high : value <= range.high);
    if (!inside)  // NaN too
      return wrong(std::string(range.name) + " is " + std::to_string(value) + ", must be " +
                   (range.low_is_in ? "at least " : "above ") + std::to_string(range.low) +
                   (range.high == 1 ? " and below 1" : " and finite"));
  }
  return check_combinations(params);
}

}  // namespace extperfc::localize
