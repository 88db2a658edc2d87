#include "extperfc/navigate/escape_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "extperfc/base/math.hpp"

namespace extperfc::navigate {

namespace {

constexpr std::array<double, 6> kDepths_m{0.015, 0.03, 0.045, 0.06, 0.09, 0.12};
constexpr double kStep_m = 0.025;
constexpr double kStep_rad = 0.05;
constexpr int kSteps = 16;  // up to 0.4 m, 0.8 rad
constexpr int kMotionDirections = 16;

bool free_at(const CostGrid& costs, const Footprint& footprint, const Pose2& pose) {
  return contact(costs, footprint, pose) == Contact::kFree;
}

/// The largest smaller footprint that is free.
std::optional<Footprint> free_part(const CostGrid& costs, const Footprint& footprint, const Pose2& pose) {
  for (const double depth_m : kDepths_m) {
    Footprint smaller = footprint.padded(-depth_m);
    if (free_at(costs, smaller, pose)) return smaller;
  }
  return std::nullopt;
}

/// Steps of the base, in its own frame.
std::vector<Pose2> motions(BaseKind base) {
  std::vector<Pose2> all{{kStep_m, 0, 0}, {-kStep_m, 0, 0}, {0, 0, kStep_rad}, {0, 0, -kStep_rad}};
  if (base == BaseKind::kDifferential) return all;
  for (int i = 0; i < kMotionDirections; ++i) {
    const double angle = kTwoPi * i / kMotionDirections;
    for (const double yaw : {0.0, kStep_rad, -kStep_rad})
      all.push_back({kStep_m * std::cos(angle), kStep_m * std::sin(angle), yaw});
  }
  return all;
}

Pose2 moved(const Pose2& start, const Pose2& step, int count) {
  const Pose2 to = compose(start, {count * step.x, count * step.y, 0});
  return {to.x, to.y, wrap_angle(start.yaw + count * step.yaw)};
}

}  // namespace

std::optional<Path> escape_path(const CostGrid& costs, const Footprint& footprint, const Pose2& start,
                                BaseKind base) {
  const auto part = free_part(costs, footprint, start);
  if (!part) return std::nullopt;
  std::vector<Pose2> steps = motions(base);
  for (int count = 1; count <= kSteps; ++count) {
    steps.erase(
        std::remove_if(steps.begin(), steps.end(),
                       [&](const Pose2& step) { return !free_at(costs, *part, moved(start, step, count)); }),
        steps.end());
    for (const Pose2& step : steps) {
      if (!free_at(costs, footprint, moved(start, step, count))) continue;
      Path path;
      for (int i = 0; i <= count; ++i) path.poses.push_back(moved(start, step, i));
      path.cost = length_m(path);
      return path;
    }
  }
  return std::nullopt;
}

}  // namespace extperfc::navigate
