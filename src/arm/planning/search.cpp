#include "arm/planning/search.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "arm/collision/bodies.hpp"
#include "arm/planning/states.hpp"

namespace extperfc::arm {

namespace {

constexpr int kMaxSamples = 1'000'000;

}  // namespace

std::vector<JointSet> branches(const CollisionModel& model) {
  const auto& bodies = model.bodies().bodies;
  std::vector<int> branch(bodies.size(), 0);
  std::map<int, JointSet> joints;  // by the branch's first body
  for (std::size_t b = 1; b < bodies.size(); ++b) {
    branch[b] = bodies[b].parent == 0 ? static_cast<int>(b) : branch[bodies[b].parent];
    auto& set = joints[branch[b]];
    if (std::find(set.begin(), set.end(), bodies[b].joint) == set.end()) set.push_back(bodies[b].joint);
  }
  std::vector<JointSet> result;
  for (auto& [first, set] : joints) {
    std::sort(set.begin(), set.end());
    result.push_back(set);
  }
  std::sort(result.begin(), result.end());
  return result;
}

Search::Search(CollisionChecker& checker, const JointLimits& limits, const PlannerParams& params,
               int first_samples)
    : checker_(checker),
      limits_(limits),
      params_(params),
      branches_(branches(checker.model())),
      rng_(params.seed),
      samples_(first_samples) {}

std::optional<Found> Search::straight(const JointVector& start, const std::vector<JointVector>& goals) {
  for (const int goal : by_distance(start, goals))
    if (checker_.motion_free(start, goals[goal])) return Found{{start, goals[goal]}, goal};
  return std::nullopt;
}

std::optional<Found> Search::branch_after_branch(const JointVector& start, const JointVector& goal,
                                                 const std::vector<JointSet>& order, int samples,
                                                 const std::function<bool()>& stop) {
  Found found{{start}, -1};
  for (const auto& branch : order) {
    const JointVector from = found.waypoints.back();
    JointVector to = from;
    for (const int j : branch) to[j] = goal[j];
    if (to == from) continue;
    if (!checker_.is_free(to)) return std::nullopt;
    if (checker_.motion_free(from, to)) {
      found.waypoints.push_back(to);
      continue;
    }
    RrtConnect trees(checker_, limits_, params_, branch, from, {to});
    const auto part = trees.grow(samples, rng_, stop);
    states_ += trees.states();
    if (!part) return std::nullopt;
    found.waypoints.insert(found.waypoints.end(), part->waypoints.begin() + 1, part->waypoints.end());
  }
  return found;
}

void Search::begin(const JointVector& start, const std::vector<JointVector>& goals) {
  JointSet all(start.size());
  std::iota(all.begin(), all.end(), 0);
  whole_.emplace(checker_, limits_, params_, all, start, goals);
  start_ = start;
  nearest_ = nearest(goals, start);
  nearest_goal_ = goals[nearest_];
}

std::optional<Found> Search::run_round(const std::function<bool()>& stop) {
  const int samples = samples_;
  samples_ = std::min(2 * samples_, kMaxSamples);
  auto order = branches_;
  for (int i = 0; i < 2 && order.size() > 1; ++i, std::reverse(order.begin(), order.end())) {
    auto found = branch_after_branch(start_, nearest_goal_, order, samples, stop);
    if (!found) continue;
    found->goal = nearest_;
    return found;
  }
  return whole_->grow(samples, rng_, stop);
}

std::optional<Found> Search::run(const JointVector& start, const std::vector<JointVector>& goals,
                                 const std::function<bool()>& stop) {
  if (auto found = straight(start, goals)) return found;
  begin(start, goals);
  std::optional<Found> found;
  while (!found && !exhausted() && !stop()) found = run_round(stop);
  return found;
}

}  // namespace extperfc::arm
