#include "test/benchmark/arm/judge.hpp"

#include <cmath>
#include <limits>

namespace extperfc::benchmark {

namespace {

/// Longer than any of the robot's arms is from its first joint to its finger tips [m]: Baxter's are 1.3 m.
constexpr double kReach_m = 2.0;

}  // namespace

std::optional<int> Judge::first_contact(const State& state, int count) {
  for (int i = 0; i < count;) {
    const arm::JointVector here = state(i);
    ++states_;
    if (const auto contact = exact_.contact(here)) {
      contact_ = *contact;
      return i;
    }
    const auto nearest = exact_.nearest(here);
    const double free_m = nearest ? nearest->distance_m : std::numeric_limits<double>::infinity();
    // Of two objects that approach, each joint moves one against the other, or both alike.
    double moved_rad = 0;
    for (arm::JointVector last = here; ++i < count;) {
      const arm::JointVector next = state(i);
      moved_rad += (next - last).lpNorm<1>();
      if (kReach_m * moved_rad >= free_m) break;
      last = next;
    }
  }
  return std::nullopt;
}

std::optional<HiddenCollision> Judge::find(const std::vector<arm::JointVector>& waypoints, double step_rad) {
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    const arm::JointVector& from = waypoints[i - 1];
    const arm::JointVector motion = waypoints[i] - from;
    const int steps = 1 + static_cast<int>(motion.norm() / step_rad);
    const auto fraction = [&](int s) { return static_cast<double>(s) / steps; };
    const auto found =
        first_contact([&](int s) { return arm::JointVector(from + fraction(s) * motion); }, steps + 1);
    if (found) return HiddenCollision{static_cast<double>(i - 1) + fraction(*found), contact_};
  }
  return std::nullopt;
}

std::optional<HiddenCollision> Judge::find(const std::function<arm::JointVector(double)>& position,
                                           double duration_s, double step_s) {
  const int steps = static_cast<int>(std::ceil(duration_s / step_s));
  const auto time = [&](int s) { return std::min(s * step_s, duration_s); };
  const auto found = first_contact([&](int s) { return position(time(s)); }, steps + 1);
  if (!found) return std::nullopt;
  return HiddenCollision{time(*found), contact_};
}

}  // namespace extperfc::benchmark
