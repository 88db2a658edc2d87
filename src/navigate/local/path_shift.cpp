#include "navigate/local/path_shift.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace extperfc::navigate {

namespace {

constexpr std::size_t kStride = 2;    // stations per layer
constexpr int kMaxStep = 3;           // shifts from layer to layer: 37 degrees
constexpr float kEnough_m = 0.2F;     // clearance that is not worth a detour
constexpr float kShiftWeight = 1.0F;  // per m^2
constexpr float kYawWeight = 0.5F;    // per rad^2
constexpr float kClearanceWeight = 0.15F;
constexpr float kKeepWeight = 0.5F;       // per m^2: stays where it was
constexpr float kKeepYawWeight = 0.2F;    // per rad^2
constexpr float kSlopeWeight = 0.25F;     // per (m/m)^2
constexpr float kRotationWeight = 0.03F;  // per (rad/m)^2
constexpr float kEnd_m = 0.6F;            // of the path, where the goal's own pose counts
constexpr float kEndWeight = 30;          // per m^2
constexpr float kBlocked = std::numeric_limits<float>::infinity();
constexpr float kLayer_m = kStride * static_cast<float>(kStationStep_m);

struct Normal {
  float x{0};
  float y{0};
};

/// To the left of the motion; of the heading where the path rotates on the spot.
Normal normal_of(const Station& at) {
  const float length = std::hypot(at.dx, at.dy);
  if (length < 0.2F) return {-std::sin(at.yaw), std::cos(at.yaw)};
  return {-at.dy / length, at.dx / length};
}

}  // namespace

PathShift::Offset PathShift::States::offset(int state) const {
  const int shift = state / yaws() - half_shifts;
  const int yaw = state % yaws() - half_yaws;
  return {static_cast<float>(shift * kShiftStep_m), static_cast<float>(yaw * kYawStep_rad)};
}

float PathShift::node_cost(const Surroundings& around, const Station& at, const Offset& offset,
                           double remaining_m) {
  const Normal normal = normal_of(at);
  const float x = at.x + offset.shift_m * normal.x;
  const float y = at.y + offset.shift_m * normal.y;
  const float yaw = at.yaw + offset.yaw_rad;
  const float clearance_m =
      around.field.clearance(around.outline, x, y, std::cos(yaw), std::sin(yaw), kEnough_m);
  if (clearance_m < 0) return kBlocked;
  if (clearance_m < ClearanceField::kCheckBelow_m) {
    const Pose2 pose{around.robot.x + x, around.robot.y + y, yaw};
    if (contact(around.field.window(), around.footprint, pose) != Contact::kFree) return kBlocked;
  }
  const float lack = std::max(0.0F, kEnough_m - clearance_m) / kEnough_m;
  const float end = kEndWeight * std::max(0.0F, 1 - static_cast<float>(remaining_m) / kEnd_m);
  return (kShiftWeight + end) * offset.shift_m * offset.shift_m +
         (kYawWeight + end) * offset.yaw_rad * offset.yaw_rad + kClearanceWeight * lack * lack;
}

PathShift::Offset PathShift::last_offset(double remaining_m) const {
  if (last_.empty()) return {};
  const double layer = (last_remaining_m_ - remaining_m) / (kStride * kStationStep_m);
  const auto i = static_cast<std::ptrdiff_t>(std::lround(layer));
  if (i < 0) return last_.front();
  return last_[std::min(static_cast<std::size_t>(i), last_.size() - 1)];
}

bool PathShift::all_clear(const Surroundings& around, const std::vector<Station>& stations) const {
  const auto moved = [](const Offset& offset) {
    return std::abs(offset.shift_m) > 1e-3F || std::abs(offset.yaw_rad) > 1e-3F;
  };
  if (std::any_of(last_.begin(), last_.end(), moved)) return false;
  for (std::size_t i = 0; i < stations.size(); i += kStride)
    if (node_cost(around, stations[i], {}, kEnd_m) > 0) return false;
  return node_cost(around, stations.back(), {}, kEnd_m) <= 0;
}

/// The cheapest step to a state from the layer before it.
PathShift::Step PathShift::best_step(const States& states, std::size_t layer, int state) const {
  if (layer == 0) return {0, state};
  constexpr auto kStep_m = static_cast<float>(kShiftStep_m);
  constexpr auto kStep_rad = static_cast<float>(kYawStep_rad);
  const float* before = costs_.data() + (layer - 1) * static_cast<std::size_t>(states.count());
  const int shift = state / states.yaws();
  const int yaw = state % states.yaws();
  Step best{kBlocked, state};
  for (int s = std::max(0, shift - kMaxStep); s <= std::min(states.shifts() - 1, shift + kMaxStep); ++s) {
    const float slope = static_cast<float>(shift - s) * kStep_m / kLayer_m;
    for (int y = std::max(0, yaw - 1); y <= std::min(states.yaws() - 1, yaw + 1); ++y) {
      const float rotation = static_cast<float>(yaw - y) * kStep_rad / kLayer_m;
      const int from = s * states.yaws() + y;
      const float cost = before[from] + kSlopeWeight * slope * slope + kRotationWeight * rotation * rotation;
      if (cost < best.cost) best = {cost, from};
    }
  }
  return best;
}

/// Number of layers that can be reached.
std::size_t PathShift::solve(const Surroundings& around, const std::vector<Station>& stations,
                             const States& states, double remaining_m) {
  const auto count = static_cast<std::size_t>(states.count());
  const std::size_t layers = (stations.size() + kStride - 1) / kStride;
  costs_.assign(layers * count, kBlocked);
  from_.assign(layers * count, 0);
  for (std::size_t layer = 0; layer < layers; ++layer) {
    const Station& at = stations[layer * kStride];
    const Offset kept = last_offset(remaining_m - at.s);
    bool reached = false;
    for (int state = 0; state < states.count(); ++state) {
      const Step step = best_step(states, layer, state);
      if (step.cost == kBlocked) continue;
      const Offset offset = states.offset(state);
      const float shifted = offset.shift_m - kept.shift_m;
      const float rotated = offset.yaw_rad - kept.yaw_rad;
      const std::size_t node = layer * count + static_cast<std::size_t>(state);
      costs_[node] = step.cost + node_cost(around, at, offset, remaining_m - at.s) +
                     kKeepWeight * shifted * shifted + kKeepYawWeight * rotated * rotated;
      from_[node] = step.from;
      reached = reached || costs_[node] < kBlocked;
    }
    if (!reached) return layer;
  }
  return layers;
}

void PathShift::trace(const States& states, std::size_t layers) {
  const auto count = static_cast<std::size_t>(states.count());
  const auto begin = costs_.begin() + static_cast<std::ptrdiff_t>((layers - 1) * count);
  int state = static_cast<int>(std::min_element(begin, begin + states.count()) - begin);
  offsets_.assign(layers, {});
  for (std::size_t layer = layers; layer-- > 0;) {
    offsets_[layer] = states.offset(state);
    state = from_[layer * count + static_cast<std::size_t>(state)];
  }
}

void PathShift::move(std::vector<Station>& stations, double remaining_m) {
  last_ = offsets_;
  last_remaining_m_ = remaining_m;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const std::size_t layer = std::min(i / kStride, offsets_.size() - 1);
    const std::size_t next = std::min(layer + 1, offsets_.size() - 1);
    const float part = static_cast<float>(i % kStride) / kStride;
    const Offset& a = offsets_[layer];
    const Offset& b = offsets_[next];
    const float shift = (1 - part) * a.shift_m + part * b.shift_m;
    const Normal normal = normal_of(stations[i]);
    stations[i].x += shift * normal.x;
    stations[i].y += shift * normal.y;
    stations[i].yaw += (1 - part) * a.yaw_rad + part * b.yaw_rad;
  }
  differentiate(stations);
}

std::optional<float> PathShift::apply(const Surroundings& around, const Limits& limits, double remaining_m,
                                      std::vector<Station>& stations) {
  if (all_clear(around, stations)) {
    last_.clear();
    return std::nullopt;
  }
  const States states{static_cast<int>(limits.max_shift_m / kShiftStep_m), limits.rotates ? kYawSteps : 0};
  const std::size_t all = (stations.size() + kStride - 1) / kStride;
  const std::size_t layers = solve(around, stations, states, remaining_m);
  const bool blocked = layers < all;
  if (layers == 0) {
    last_.clear();
    stations.resize(2);
    return 0.0F;
  }
  trace(states, layers);
  if (blocked) stations.resize(std::max<std::size_t>(2, (layers - 1) * kStride + 1));
  move(stations, remaining_m);
  return blocked ? std::optional<float>(stations.back().s) : std::nullopt;
}

}  // namespace extperfc::navigate
