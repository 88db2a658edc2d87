#include "localize/scan_search.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/base/math.hpp"

#include "localize/weights.hpp"

namespace extperfc::localize {

namespace {

constexpr std::size_t kFirstBeams = 30;  // for the first choice
constexpr std::size_t kSecondRays = 30;  // whole ones
constexpr std::size_t kKeptOf = 5;       // the first choice keeps one of so many
constexpr double kJitter_m = 0.1;        // about the distance of neighbours among the kept
constexpr double kJitter_rad = 0.06;

/// As many as `count` of the particles, chosen by how well they fit.
ParticleSet choose(const ParticleSet& particles, const std::vector<float>& logs, std::size_t beams,
                   std::size_t count, Rng& rng) {
  std::vector<float> weights = particles.weight;
  const double min_effective = static_cast<double>(std::min(count, particles.size())) / 4;
  reweight(weights, logs, tempered_exponent(weights, logs, static_cast<double>(beams), min_effective));
  return pick(particles, sample_systematic(weights, count, rng));
}

}  // namespace

ParticleSet draw_uniform(const FreeSpace& free_space, std::size_t count, Rng& rng) {
  ParticleSet particles;
  particles.resize(count);
  particles.make_weights_equal();
  for (std::size_t i = 0; i < count; ++i) {
    const auto point = free_space.draw(rng);
    particles.set(i, point.x_m, point.y_m, static_cast<float>(rng.uniform(-kPi, kPi)));
  }
  return particles;
}

ParticleSet pick(const ParticleSet& from, const std::vector<std::uint32_t>& numbers) {
  ParticleSet picked;
  picked.resize(numbers.size());
  picked.make_weights_equal();
  for (std::size_t i = 0; i < numbers.size(); ++i)
    picked.set(i, from.x[numbers[i]], from.y[numbers[i]], from.yaw[numbers[i]]);
  return picked;
}

void append(ParticleSet& particles, const ParticleSet& more) {
  particles.x.insert(particles.x.end(), more.x.begin(), more.x.end());
  particles.y.insert(particles.y.end(), more.y.begin(), more.y.end());
  particles.yaw.insert(particles.yaw.end(), more.yaw.begin(), more.yaw.end());
}

void add_jitter(ParticleSet& particles, double sigma_m, double sigma_rad, Rng& rng) {
  for (std::size_t i = 0; i < particles.size(); ++i)
    particles.set(i, static_cast<float>(particles.x[i] + rng.normal(0, 1) * sigma_m),
                  static_cast<float>(particles.y[i] + rng.normal(0, 1) * sigma_m),
                  static_cast<float>(wrap_angle(particles.yaw[i] + rng.normal(0, 1) * sigma_rad)));
}

ParticleSet search_scan(const MapModel& map_model, const Beams& beams, std::size_t tries, std::size_t count,
                        Rng& rng) {
  if (beams.ends() == 0) return draw_uniform(map_model.free_space, count, rng);
  ParticleSet poses = draw_uniform(map_model.free_space, tries, rng);
  std::vector<float> logs;
  const std::size_t every = std::max<std::size_t>(1, beams.ends() / kFirstBeams);
  map_model.wide.mean_logs(map_model.field, beams, poses, logs, every);
  poses = choose(poses, logs, std::min(beams.ends(), kFirstBeams), std::max(count, tries / kKeptOf), rng);
  add_jitter(poses, kJitter_m, kJitter_rad, rng);
  map_model.exact.mean_logs(map_model.field, beams, poses, logs);
  ParticleSet chosen = choose(poses, logs, beams.ends(), count - count / 2, rng);
  for (std::size_t i = 0; i < poses.size(); ++i)
    logs[i] = static_cast<float>(map_model.place_log(beams, poses.pose(i), kSecondRays));
  append(chosen, choose(poses, logs, beams.ends(), count / 2, rng));
  chosen.make_weights_equal();
  return chosen;
}

}  // namespace extperfc::localize
