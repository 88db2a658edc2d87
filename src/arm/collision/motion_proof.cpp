#include "arm/collision/motion_proof.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::arm {
namespace {

constexpr double kMaxBend = 0.002;  // [m]
constexpr int kMaxIntervals = 1 << 16;
constexpr double kSafety = 1 + 1e-6;  // over the kernel's single precision
constexpr double kSafety_m = 1e-7;

KernelDrift drift_over(const MotionBound& bound, double half) {
  const double margin = bound.displacement * kSafety + kSafety_m;
  return {static_cast<float>(bound.speed * half * kSafety + margin),
          static_cast<float>(bound.acceleration * half * half / 2 * kSafety + margin)};
}

MotionBound sum(const MotionBound& a, const MotionBound& b) {
  return {a.speed + b.speed, a.acceleration + b.acceleration, a.displacement + b.displacement};
}

}  // namespace

MotionProof::MotionProof(Checks& checks, const JointVector& from, const JointVector& to, double deviation_rad)
    : checks_(checks), from_(from), delta_(to - from), length_(delta_.norm()), deviation_rad_(deviation_rad) {
  for (const Body& body : checks.bodies().bodies)
    rates_.push_back(body.joint < 0 ? 0 : body.multiplier * delta_[body.joint]);
  bound_drifts();
  count_intervals();
}

void MotionProof::bound_drifts() {
  const auto& farthest = checks_.farthest_;
  for (std::size_t i = 0; i < farthest.size(); ++i)
    world_bounds_.push_back(part_bound(0, static_cast<int>(i), farthest[i]));
  for (const PairGroup& group : checks_.scene_.groups) {
    if (!group.self) continue;
    const int ancestor = checks_.scene_.pairs[group.first_pair].ancestor;
    const auto bound = [&](int body) {
      return ancestor == 0 ? world_bounds_[body] : part_bound(ancestor, body, farthest[body]);
    };
    self_bounds_.push_back(sum(bound(group.body), bound(group.other)));
  }
}

void MotionProof::count_intervals() {
  double bend = 0;
  for (const auto& bound : world_bounds_) bend = std::max(bend, bound.acceleration);
  const double needed = std::ceil(std::sqrt(bend / (8 * kMaxBend)));
  const int min_intervals = needed < kMaxIntervals ? static_cast<int>(needed) : kMaxIntervals;
  intervals_ = kLanes * std::max(1, (min_intervals + kLanes - 1) / kLanes);
  half_ = 0.5 / intervals_;
  for (const double rate : rates_) kernel_rates_.push_back(static_cast<float>(rate));
  for (const auto& bound : world_bounds_) world_drift_.push_back(drift_over(bound, half_));
  for (const auto& bound : self_bounds_) self_drift_.push_back(drift_over(bound, half_));
}

double MotionProof::fraction(bool whole_only) {
  if (length_ == 0 && deviation_rad_ == 0) return checks_.states_free(&from_, 1, true)[0] ? 1 : -1;
  const int batches = intervals_ / kLanes;
  constexpr unsigned kAll = (1U << kLanes) - 1;
  for (int batch = 0; batch < batches; ++batch) {
    // A whole motion is sampled all over first: most collisions are found by the first batch.
    const unsigned proven = whole_only ? proven_lanes(batch, batches) : proven_lanes(batch * kLanes, 1);
    if (proven == kAll) continue;
    int lane = 0;
    while ((proven >> lane & 1U) != 0) ++lane;
    const int interval = whole_only ? 0 : batch * kLanes + lane;
    if (interval > 0) return static_cast<double>(interval) / intervals_;
    return !whole_only && checks_.states_free(&from_, 1, true)[0] ? 0 : -1;
  }
  return 1;
}

unsigned MotionProof::proven_lanes(int first, int stride) {
  const auto middle = [&](int lane) { return (first + lane * stride + 0.5) / intervals_; };
  unsigned proven = 0;
  if (!checks_.params.spheres) {
    for (int lane = 0; lane < kLanes; ++lane)
      if (all_pairs_proven(middle(lane))) proven |= 1U << lane;
    return proven;
  }
  for (int lane = 0; lane < kLanes; ++lane) checks_.pack(lane, at(middle(lane)));
  const KernelMotion motion{kernel_rates_.data(), static_cast<float>(half_ * kSafety), world_drift_.data(),
                            self_drift_.data()};
  const int flags = checks_.run_kernel(&motion);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (!lane_proven(middle(lane), flags, 1U << lane)) return proven;
    proven |= 1U << lane;
  }
  return proven;
}

bool MotionProof::lane_proven(double middle, int flags, unsigned lane_bit) {
  bool placed = false;
  for (int i = 0; i < flags; ++i) {
    const KernelFlag& flag = checks_.memory_.scratch().flags[i];
    if ((flag.lanes & lane_bit) == 0) continue;
    if (!placed) set_moment(moments_[0], middle);
    placed = true;
    if (!pair_proven(flag.pair, pair_bound(flag.pair), middle, half_, 0)) return false;
  }
  return true;
}

bool MotionProof::all_pairs_proven(double middle) {
  set_moment(moments_[0], middle);
  for (int pair = 0; pair < static_cast<int>(checks_.scene_.pairs.size()); ++pair)
    if (!pair_proven(pair, pair_bound(pair), middle, half_, 0)) return false;
  return true;
}

void MotionProof::set_moment(Moment& moment, double parameter) const {
  const JointVector positions = at(parameter);
  moment.placement.set(checks_.bodies(), checks_.scene_, positions.data());
  set_velocities(checks_.bodies(), rates_, moment);
}

MotionBound MotionProof::part_bound(int ancestor, int body, const std::vector<double>& from_axis) const {
  MotionBound bound = motion_bound(checks_.bodies(), ancestor, body, from_axis, rates_);
  if (deviation_rad_ > 0)
    bound.displacement = deviation_rad_ * displacement_per_rad(checks_.bodies(), ancestor, body, from_axis);
  return bound;
}

MotionBound MotionProof::pair_bound(int index) const {
  const PartPair& pair = checks_.scene_.pairs[index];
  const auto bound = [&](int part) {
    const MovingPart& moving = checks_.scene_.moving[part];
    return part_bound(pair.ancestor, moving.body, moving.reach.from_axis);
  };
  return pair.self ? sum(bound(pair.part), bound(pair.other)) : bound(pair.part);
}

bool MotionProof::pair_proven(int pair, const MotionBound& bound, double middle, double half, int depth) {
  const Moment& moment = moments_[depth];
  const double padding = checks_.scene_.pairs[pair].padding_m + kMinGap_m;
  const double bend = bound.acceleration * half * half / 2 + bound.displacement;
  if (checks_.exact_.rough_bound(pair, moment.placement) > padding + bound.speed * half + bound.displacement)
    return true;
  if (const auto known = checks_.exact_.remembered(pair, moment.placement);
      known && checks_.exact_.stays_apart(pair, moment, *known, half, bend))
    return true;
  const Separation found = checks_.exact_.separation(pair, moment.placement);
  if (!(found.gap_m > padding)) return false;
  if (checks_.exact_.stays_apart(pair, moment, found, half, bend)) return true;
  if (2 * half * length_ <= checks_.params.min_step_rad || depth + 1 == kMaxDepth) return false;
  return halves_proven(pair, bound, middle, half, depth + 1);
}

bool MotionProof::halves_proven(int pair, const MotionBound& bound, double middle, double half, int depth) {
  for (const double side : {-0.5, 0.5}) {
    set_moment(moments_[depth], middle + side * half);
    if (!pair_proven(pair, bound, middle + side * half, half / 2, depth)) return false;
  }
  return true;
}

}  // namespace extperfc::arm
