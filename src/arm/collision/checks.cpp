#include "arm/collision/checks.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "extperfc/base/math.hpp"

#include "arm/collision/motion_proof.hpp"

namespace extperfc::arm {
Checks::Checks(const CollisionModel& model_in, const CollisionWorld& world_in,
               const CollisionCheckerParams& params_in, Scene scene)
    : model(model_in),
      world(world_in),
      params(params_in),
      scene_(std::move(scene)),
      tables_(model.bodies(), scene_),
      kernel_scene_(tables_.view()),
      kernel_(sphere_kernel()),
      memory_(kernel_scene_),
      exact_(scene_),
      wraps_(model.joint_count(), true) {
  const std::size_t count = model.bodies().bodies.size();
  farthest_.assign(count, std::vector<double>(count, 0.0));
  for (const MovingPart& part : scene_.moving)
    for (std::size_t i = 0; i < count; ++i)
      farthest_[part.body][i] = std::max(farthest_[part.body][i], part.reach.from_axis[i]);
  for (std::size_t body = 1; body < count; ++body) {
    // The centre of the ball about a body need not lie in any of its parts.
    const Ball centre{body_ball(scene_, static_cast<int>(body)).centre, 0};
    const AxisReach reach = reach_of(model.bodies(), static_cast<int>(body), centre);
    for (std::size_t i = 0; i < count; ++i)
      farthest_[body][i] = std::max(farthest_[body][i], reach.from_axis[i]);
  }
  for (const Body& body : model.bodies().bodies)
    if (body.joint >= 0 && (body.prismatic || std::abs(body.multiplier) != 1)) wraps_[body.joint] = false;
}

bool Checks::usable(const JointVector& positions) const {
  if (positions.size() != model.joint_count())
    throw std::invalid_argument("a state has " + std::to_string(positions.size()) + " values instead of " +
                                std::to_string(model.joint_count()));
  return positions.allFinite();
}

/// Large angles are brought near zero first, where single precision is fine enough.
void Checks::pack(int lane, const JointVector& positions) {
  constexpr double kLargeAngle = 8;
  float* const out = memory_.positions() + lane;
  for (Eigen::Index joint = 0; joint < positions.size(); ++joint) {
    double value = positions[joint];
    if (wraps_[joint] && std::abs(value) > kLargeAngle) value = std::remainder(value, 2 * kPi);
    out[joint * kLanes] = static_cast<float>(value);
  }
}

int Checks::run_kernel(const KernelMotion* motion) {
  ++counters.sphere_batches;
  return kernel_(kernel_scene_, memory_.positions(), motion, memory_.scratch());
}

bool Checks::pair_apart(int pair, const BodyPlacement& placement, double beyond_padding_m) {
  const double gap = scene_.pairs[pair].padding_m + beyond_padding_m;
  if (exact_.rough_bound(pair, placement) > gap) return true;
  if (const auto known = exact_.remembered(pair, placement); known && known->gap_m > gap) return true;
  return exact_.separation(pair, placement).gap_m > gap;
}

bool Checks::all_apart(const JointVector& positions) {
  placement_.set(bodies(), scene_, positions.data());
  for (std::size_t pair = 0; pair < scene_.pairs.size(); ++pair)
    if (!pair_apart(static_cast<int>(pair), placement_, kMinGap_m)) return false;
  return true;
}

bool Checks::lane_apart(const JointVector& positions, int flags, unsigned lane_bit) {
  bool placed = false;
  for (int i = 0; i < flags; ++i) {
    const KernelFlag& flag = memory_.scratch().flags[i];
    if ((flag.lanes & lane_bit) == 0) continue;
    if (!placed) placement_.set(bodies(), scene_, positions.data());
    placed = true;
    if (!pair_apart(flag.pair, placement_, kMinGap_m)) return false;
  }
  return true;
}

unsigned Checks::free_lanes(const JointVector* states, int count, bool exact) {
  unsigned finite = 0;
  for (int lane = 0; lane < count; ++lane)
    if (usable(states[lane])) finite |= 1U << lane;
  int good = 0;
  while (good < count && (finite >> good & 1U) == 0) ++good;
  if (good == count) return 0;
  for (int lane = 0; lane < kLanes; ++lane)
    pack(lane, states[lane < count && (finite >> lane & 1U) != 0 ? lane : good]);
  const int flags = run_kernel(nullptr);
  unsigned doubtful = 0;
  for (int i = 0; i < flags; ++i) doubtful |= memory_.scratch().flags[i].lanes;
  unsigned free = finite & ~doubtful;
  for (int lane = 0; exact && lane < count; ++lane) {
    const unsigned bit = 1U << lane;
    if ((finite & doubtful & bit) != 0 && lane_apart(states[lane], flags, bit)) free |= bit;
  }
  return free;
}

std::vector<bool> Checks::states_free(const JointVector* states, int count, bool exact) {
  counters.states += count;
  std::vector<bool> result(count);
  for (int first = 0; first < count; first += kLanes) {
    const int lanes = std::min(kLanes, count - first);
    if (exact && !params.spheres) {
      for (int i = first; i < first + lanes; ++i) result[i] = usable(states[i]) && all_apart(states[i]);
      continue;
    }
    const unsigned free = free_lanes(states + first, lanes, exact);
    for (int lane = 0; lane < lanes; ++lane) result[first + lane] = (free >> lane & 1U) != 0;
  }
  counters.exact_pairs = exact_.queries();
  return result;
}

Contact Checks::named(int index, double distance_m) const {
  const PartPair& pair = scene_.pairs[index];
  const std::string& second = pair.self ? scene_.moving[pair.other].name : scene_.obstacles[pair.other].name;
  return {scene_.moving[pair.part].name, second, distance_m - pair.padding_m};
}

std::optional<Contact> Checks::contact(const JointVector& positions) {
  if (!usable(positions)) throw std::invalid_argument("a state is not finite");
  placement_.set(bodies(), scene_, positions.data());
  for (int pair = 0; pair < static_cast<int>(scene_.pairs.size()); ++pair)
    if (!pair_apart(pair, placement_, 0))
      return named(pair, std::min(exact_.signed_distance(pair, placement_), scene_.pairs[pair].padding_m));
  return std::nullopt;
}

std::optional<Contact> Checks::nearest(const JointVector& positions) {
  if (!usable(positions)) throw std::invalid_argument("a state is not finite");
  placement_.set(bodies(), scene_, positions.data());
  // Pairs whose boxes are near each other first: few others are left to be looked at then.
  std::vector<std::pair<double, int>> bounds;
  bounds.reserve(scene_.pairs.size());
  for (int pair = 0; pair < static_cast<int>(scene_.pairs.size()); ++pair)
    bounds.emplace_back(exact_.rough_bound(pair, placement_) - scene_.pairs[pair].padding_m, pair);
  const auto farther = std::greater<>();
  std::make_heap(bounds.begin(), bounds.end(), farther);
  double smallest = std::numeric_limits<double>::infinity();
  std::optional<Contact> result;
  for (; !bounds.empty() && bounds.front().first < smallest; bounds.pop_back()) {
    std::pop_heap(bounds.begin(), bounds.end(), farther);
    const int pair = bounds.back().second;
    const double padding = scene_.pairs[pair].padding_m;
    const double distance = exact_.signed_distance(pair, placement_) - padding;
    if (distance >= smallest) continue;
    smallest = distance;
    result = named(pair, distance + padding);
  }
  return result;
}

double Checks::free_fraction(const JointVector& from, const JointVector& to, bool whole_only,
                             double deviation_rad) {
  if (!(deviation_rad >= 0) || !std::isfinite(deviation_rad))
    throw std::invalid_argument("the deviation of a motion must be 0 rad or more");
  ++counters.motions;
  if (!usable(from)) return -1;
  if (!usable(to)) return states_free(&from, 1, true)[0] ? 0 : -1;
  const double fraction = MotionProof(*this, from, to, deviation_rad).fraction(whole_only);
  counters.exact_pairs = exact_.queries();
  return fraction;
}

}  // namespace extperfc::arm
