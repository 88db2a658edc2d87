#include "navigate/local/path_shift.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace extperfc::navigate {

namespace {

constexpr std::size_t kStride = 2;    // stations per layer
constexpr int kMaxStep = 3;           // states from layer to layer: 37 degrees
constexpr float kEnough_m = 0.2F;     // clearance that is not worth a detour
constexpr float kDoubt_m = 0.13F;     // below it the grid is asked: the field is within a cell
constexpr float kShiftWeight = 1.0F;  // per m^2
constexpr float kClearanceWeight = 0.15F;
constexpr float kKeepWeight = 0.5F;    // per m^2: stays where it was
constexpr float kSlopeWeight = 0.25F;  // per (m/m)^2
constexpr float kEnd_m = 0.6F;         // of the path, where the goal's own position counts
constexpr float kEndWeight = 30;       // per m^2
constexpr float kBlocked = std::numeric_limits<float>::infinity();

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

float PathShift::node_cost(const Surroundings& around, const Station& at, float shift_m, double remaining_m) {
  const Normal normal = normal_of(at);
  const float x = at.x + shift_m * normal.x;
  const float y = at.y + shift_m * normal.y;
  const float clearance_m =
      around.field.clearance(around.outline, x, y, std::cos(at.yaw), std::sin(at.yaw), kEnough_m);
  if (clearance_m < 0) return kBlocked;
  if (clearance_m < kDoubt_m) {
    const Pose2 pose{around.robot.x + x, around.robot.y + y, at.yaw};
    if (contact(around.field.window(), around.footprint, pose) != Contact::kFree) return kBlocked;
  }
  const float lack = std::max(0.0F, kEnough_m - clearance_m) / kEnough_m;
  const float end = std::max(0.0F, 1 - static_cast<float>(remaining_m) / kEnd_m);
  return (kShiftWeight + kEndWeight * end) * shift_m * shift_m + kClearanceWeight * lack * lack;
}

float PathShift::last_shift(double remaining_m) const {
  if (last_.empty()) return 0;
  const double layer = (last_remaining_m_ - remaining_m) / (kStride * kStationStep_m);
  const auto i = static_cast<std::ptrdiff_t>(std::lround(layer));
  if (i < 0) return last_.front();
  return last_[std::min(static_cast<std::size_t>(i), last_.size() - 1)];
}

bool PathShift::all_clear(const Surroundings& around, const std::vector<Station>& stations) const {
  const auto shifted = [](float shift) { return std::abs(shift) > 1e-3F; };
  if (std::any_of(last_.begin(), last_.end(), shifted)) return false;
  for (std::size_t i = 0; i < stations.size(); i += kStride)
    if (node_cost(around, stations[i], 0, kEnd_m) > 0) return false;
  return node_cost(around, stations.back(), 0, kEnd_m) <= 0;
}

/// Number of layers that can be reached.
std::size_t PathShift::solve(const Surroundings& around, const std::vector<Station>& stations, int half,
                             double remaining_m) {
  const auto states = 2 * static_cast<std::size_t>(half) + 1;
  const std::size_t layers = (stations.size() + kStride - 1) / kStride;
  constexpr auto kStep_m = static_cast<float>(kShiftStep_m);
  constexpr float kLayer_m = kStride * static_cast<float>(kStationStep_m);
  costs_.assign(layers * states, kBlocked);
  from_.assign(layers * states, 0);
  for (std::size_t layer = 0; layer < layers; ++layer) {
    const Station& at = stations[layer * kStride];
    const float kept = last_shift(remaining_m - at.s);
    bool reached = false;
    for (int state = 0; state < static_cast<int>(states); ++state) {
      float best = layer == 0 ? 0 : kBlocked;
      int from = state;
      const int low = std::max(0, state - kMaxStep);
      const int high = std::min(static_cast<int>(states) - 1, state + kMaxStep);
      for (int before = low; layer > 0 && before <= high; ++before) {
        const float slope = static_cast<float>(state - before) * kStep_m / kLayer_m;
        const float cost =
            costs_[(layer - 1) * states + static_cast<std::size_t>(before)] + kSlopeWeight * slope * slope;
        if (cost < best) {
          best = cost;
          from = before;
        }
      }
      if (best == kBlocked) continue;
      const float shift_m = static_cast<float>(state - half) * kStep_m;
      const float change = shift_m - kept;
      const std::size_t node = layer * states + static_cast<std::size_t>(state);
      costs_[node] =
          best + node_cost(around, at, shift_m, remaining_m - at.s) + kKeepWeight * change * change;
      from_[node] = from;
      reached = reached || costs_[node] < kBlocked;
    }
    if (!reached) return layer;
  }
  return layers;
}

void PathShift::trace(std::size_t layers, int half) {
  const auto states = 2 * static_cast<std::size_t>(half) + 1;
  const auto begin = costs_.begin() + static_cast<std::ptrdiff_t>((layers - 1) * states);
  int state = static_cast<int>(std::min_element(begin, begin + static_cast<std::ptrdiff_t>(states)) - begin);
  shifts_.assign(layers, 0);
  for (std::size_t layer = layers; layer-- > 0;) {
    shifts_[layer] = static_cast<float>((state - half) * kShiftStep_m);
    state = from_[layer * states + static_cast<std::size_t>(state)];
  }
}

void PathShift::move(std::vector<Station>& stations, double remaining_m) {
  last_ = shifts_;
  last_remaining_m_ = remaining_m;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const std::size_t layer = std::min(i / kStride, shifts_.size() - 1);
    const std::size_t next = std::min(layer + 1, shifts_.size() - 1);
    const float part = static_cast<float>(i % kStride) / kStride;
    const float shift = (1 - part) * shifts_[layer] + part * shifts_[next];
    const Normal normal = normal_of(stations[i]);
    stations[i].x += shift * normal.x;
    stations[i].y += shift * normal.y;
  }
  differentiate(stations);
}

std::optional<float> PathShift::apply(const Surroundings& around, double max_shift_m, double remaining_m,
                                      std::vector<Station>& stations) {
  if (all_clear(around, stations)) {
    last_.clear();
    return std::nullopt;
  }
  const int half = static_cast<int>(max_shift_m / kShiftStep_m);
  const std::size_t all = (stations.size() + kStride - 1) / kStride;
  const std::size_t layers = solve(around, stations, half, remaining_m);
  const bool blocked = layers < all;
  if (layers == 0) {
    last_.clear();
    stations.resize(2);
    return 0.0F;
  }
  trace(layers, half);
  if (blocked) stations.resize(std::max<std::size_t>(2, (layers - 1) * kStride + 1));
  move(stations, remaining_m);
  return blocked ? std::optional<float>(stations.back().s) : std::nullopt;
}

}  // namespace extperfc::navigate
