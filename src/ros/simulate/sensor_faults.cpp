#include "ros/simulate/sensor_faults.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <cstddef>
#include <string>

namespace extperfc::ros_simulate {

using simulate::Fault;
using simulate::FaultKind;

namespace {

constexpr std::size_t kRings = 16;

/// Well mixed 64 bits of a number (the finaliser of SplitMix64): a generator that starts anew for every
/// pixel would cost more than the image.
std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// Uniform in [0, 1).
double fraction(std::uint64_t bits) {
  return static_cast<double>(bits >> 11) * 0x1.0p-53;
}

std::uint64_t draw(std::uint64_t seed, FaultKind kind, double time_s) {
  const auto microseconds = static_cast<std::uint64_t>(std::llround(1e6 * time_s));
  return mix(mix(seed + static_cast<std::uint64_t>(kind)) ^ microseconds);
}

const Fault* find(const std::vector<Fault>& active, FaultKind kind) {
  const auto found =
      std::find_if(active.begin(), active.end(), [&](const Fault& fault) { return fault.kind == kind; });
  return found == active.end() ? nullptr : &*found;
}

bool is_lost(const Fault* drop, std::uint64_t seed, double time_s) {
  return drop && fraction(draw(seed, drop->kind, time_s)) < drop->value;
}

void lose_depth(const Fault& fault, std::uint64_t seed, double time_s, std::vector<std::uint16_t>& depth_mm) {
  const std::uint64_t image = draw(seed, fault.kind, time_s);
  for (std::size_t i = 0; i < depth_mm.size(); ++i)
    if (fraction(mix(image + i)) < fault.value) depth_mm[i] = 0;
}

/// What is no ring was refused when the fault was set.
std::bitset<kRings> rings_of(const std::string& target) {
  std::bitset<kRings> rings;
  if (const auto numbers = simulate::ring_numbers(target))
    for (const int ring : *numbers) rings.set(static_cast<std::size_t>(ring));
  return rings;
}

}  // namespace

bool CameraFaults::frozen(const std::vector<Fault>& active) const {
  return kept_ && find(active, FaultKind::kCameraFreeze);
}

Fate CameraFaults::apply(const std::vector<Fault>& active, double time_s, simulate::CameraImages& images) {
  if (!find(active, FaultKind::kCameraFreeze)) {
    kept_ = false;
  } else if (kept_) {
    images = frozen_;
  } else {
    frozen_ = images;
    kept_ = true;
  }
  if (is_lost(find(active, FaultKind::kCameraDrop), seed_, time_s)) return Fate::kLost;
  if (const Fault* nan = find(active, FaultKind::kCameraNan))
    lose_depth(*nan, seed_, time_s, images.depth_mm);
  return Fate::kDelivered;
}

Fate LidarFaults::apply(const std::vector<Fault>& active, double time_s,
                        std::vector<simulate::LidarPoint>& points) const {
  if (is_lost(find(active, FaultKind::kLidarDrop), seed_, time_s)) return Fate::kLost;
  std::bitset<kRings> missing;
  for (const Fault& fault : active)
    if (fault.kind == FaultKind::kLidarRings) missing |= rings_of(fault.target);
  if (missing.any())
    points.erase(std::remove_if(points.begin(), points.end(),
                                [&](const auto& point) { return missing.test(point.ring % kRings); }),
                 points.end());
  return Fate::kDelivered;
}

}  // namespace extperfc::ros_simulate
