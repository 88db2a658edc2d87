#include "test/benchmark/localize/halves.hpp"

#include <algorithm>

#include "extperfc/base/rng.hpp"

#include "test/benchmark/localize/subject.hpp"
#include "test/support/planar_world.hpp"

namespace extperfc::benchmark {
namespace {

PlanarOdometry wheels(Rng& rng) {
  PlanarOdometry odometry;
  odometry.scale = rng.normal(0, 0.03);
  odometry.veer_rad_per_m = rng.normal(0, 0.02);
  odometry.sigma_m_per_m = 0.1;
  odometry.sigma_rad_per_m = 0.05;
  odometry.sigma_rad_per_rad = 0.05;
  return odometry;
}

bool is_known(const Pose2& pose, const std::vector<Pose2>& mapped) {
  constexpr double kKnown_m = 1;
  return std::any_of(mapped.begin(), mapped.end(),
                     [&](const Pose2& other) { return distance_m(pose, other) <= kKnown_m; });
}

}  // namespace

HalfCase make_half_case(const Recording& recording, Half mapped) {
  HalfCase half;
  half.recording = &recording;
  half.mapped = mapped;
  const std::size_t middle = recording.scans.size() / 2;
  half.first = mapped == Half::kFirst ? middle : 0;
  half.end = mapped == Half::kFirst ? recording.scans.size() : middle;
  std::vector<std::size_t> drawn;
  std::vector<Pose2> poses;
  for (const std::size_t frame : key_frames(recording)) {
    if ((frame < middle) != (mapped == Half::kFirst)) continue;
    drawn.push_back(frame);
    poses.push_back(recording.truth[frame]);
  }
  half.map = draw_map(recording, drawn);
  for (std::size_t i = half.first; i < half.end; ++i)
    half.known.push_back(is_known(recording.truth[i], poses));
  return half;
}

std::vector<Step> steps_of(const HalfCase& half, std::uint64_t seed) {
  Rng rng(seed);
  PlanarOdometry odometry = wheels(rng);
  const auto& log = half.recording->odom;
  std::vector<Step> steps;
  for (std::size_t i = half.first; i < half.end; ++i) {
    if (i > half.first) odometry.move(between(log[i - 1], log[i]), rng);
    if (steps.empty() || moved(steps.back().odom, odometry.pose))
      steps.push_back({i, odometry.pose, half.known[i - half.first]});
  }
  return steps;
}

std::vector<std::size_t> known_starts(const std::vector<Step>& steps, std::size_t length,
                                      std::size_t max_count) {
  std::vector<std::size_t> all;
  std::size_t run = 0;  // known steps from here on
  for (std::size_t i = steps.size(); i-- > 0;) {
    run = steps[i].known ? run + 1 : 0;
    if (run >= length) all.push_back(i);
  }
  std::reverse(all.begin(), all.end());
  if (all.size() <= max_count) return all;
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < max_count; ++k)
    chosen.push_back(all[(2 * k + 1) * all.size() / (2 * max_count)]);
  return chosen;
}

}  // namespace extperfc::benchmark
