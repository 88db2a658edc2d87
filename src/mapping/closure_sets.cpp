#include "mapping/closure_sets.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include <Eigen/Cholesky>

#include "mapping/rotation_by.hpp"

namespace extperfc::mapping {

namespace {

constexpr double kConsistent = 11.3;  // chi-square of three degrees of freedom: one in a hundred
constexpr double kMaxReachM = 40.0;
constexpr double kWeightPerLogReach = 0.6;
constexpr double kAlternativeRatio = 1.4;
constexpr double kPlaceM = 3.0;  // queries nearer to each other show the same

/// How a rotation about the origin moves a pose.
Eigen::Matrix3d moved_by_rotation(const Pose2& pose) {
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Identity();
  jacobian(0, 2) = -pose.y;
  jacobian(1, 2) = pose.x;
  return jacobian;
}

bool holds(const ClosureSets::Members& members, std::size_t closure) {
  return std::find(members.begin(), members.end(), closure) != members.end();
}

}  // namespace

bool is_explained(const Pose2& residual, Eigen::Matrix3d covariance, double systematic_m) {
  covariance(0, 0) += systematic_m * systematic_m / 4 + 1e-4;
  covariance(1, 1) += systematic_m * systematic_m / 4 + 1e-4;
  covariance(2, 2) += 1e-5;
  const Eigen::Vector3d e(residual.x, residual.y, residual.yaw);
  return e.dot(covariance.ldlt().solve(e)) < kConsistent;
}

ClosureSets::ClosureSets(const std::vector<SubmapClosure>& closures, const std::vector<KeyFrame>& frames,
                         const std::vector<Pose2>& poses, const RelativeUncertainties& known)
    : closures_(closures), frames_(frames), poses_(poses), known_(known), by_weight_(closures.size()) {
  std::iota(by_weight_.begin(), by_weight_.end(), std::size_t{0});
  std::stable_sort(by_weight_.begin(), by_weight_.end(), [&](std::size_t a, std::size_t b) {
    return closures[a].distinctness * closures[a].support > closures[b].distinctness * closures[b].support;
  });
  ends_.reserve(2 * closures.size());
  for (const SubmapClosure& closure : closures) {
    ends_.push_back(closure.constraint.from);
    ends_.push_back(closure.constraint.to);
  }
  std::sort(ends_.begin(), ends_.end());
  ends_.erase(std::unique(ends_.begin(), ends_.end()), ends_.end());
}

const RelativeUncertainty& ClosureSets::uncertainty(std::size_t from, std::size_t to) {
  auto& row = known_ends_[from];
  if (row.empty()) {
    const auto all = known_.from(from);
    row.reserve(ends_.size());
    for (const std::size_t end : ends_) row.push_back(all[end]);
  }
  const auto place = std::lower_bound(ends_.begin(), ends_.end(), to) - ends_.begin();
  return row[static_cast<std::size_t>(place)];
}

bool ClosureSets::is_consistent(const SubmapClosure& a, const SubmapClosure& b) {
  const Pose2 from_step = between(poses_[a.constraint.from], poses_[b.constraint.from]);
  const Pose2 to_step = between(poses_[b.constraint.to], poses_[a.constraint.to]);
  const Pose2 lever = compose(b.constraint.from_T_to, to_step);
  const Pose2 residual = between(a.constraint.from_T_to, compose(from_step, lever));
  const auto& from_known = uncertainty(a.constraint.from, b.constraint.from);
  const auto& to_known = uncertainty(a.constraint.to, b.constraint.to);
  if (from_known.is_unknown() || to_known.is_unknown()) return false;
  const Eigen::Matrix3d to_a = rotation_by(-a.constraint.from_T_to.yaw);
  const Eigen::Matrix3d j = moved_by_rotation(lever);
  const Eigen::Matrix3d k = moved_by_rotation(to_step);
  Eigen::Matrix3d covariance = to_a * j * from_known.covariance * j.transpose() * to_a.transpose();
  covariance += to_known.covariance;
  covariance += to_a * a.constraint.covariance() * to_a.transpose();
  covariance += k * b.constraint.covariance() * k.transpose();
  return is_explained(residual, covariance, from_known.systematic_m + to_known.systematic_m);
}

bool ClosureSets::agree(std::size_t a, std::size_t b) {
  const auto key = std::minmax(a, b);
  const auto known = agreed_.find(key);
  if (known != agreed_.end()) return known->second;
  return agreed_[key] = is_consistent(closures_[key.first], closures_[key.second]);
}

bool ClosureSets::agrees_with_all(std::size_t closure, const Members& members) {
  return std::all_of(members.begin(), members.end(),
                     [&](std::size_t member) { return agree(member, closure); });
}

/// Greedily, the most distinct ones first.
ClosureSets::Members ClosureSets::grow(std::size_t seed) {
  Members members{seed};
  for (const std::size_t i : by_weight_)
    if (i != seed && agrees_with_all(i, members)) members.push_back(i);
  return members;
}

/// A number that closures of one place have in common.
double ClosureSets::place_of(const SubmapClosure& closure) const {
  const std::size_t query = closure.constraint.to;
  return closure.is_joining ? std::floor(frames_[query].travelled_m / kPlaceM) : static_cast<double>(query);
}

double ClosureSets::weight_without(const Members& members, const Members& others) const {
  std::map<double, double> per_place;
  for (const std::size_t i : members) {
    if (holds(others, i)) continue;
    double& weight = per_place[place_of(closures_[i])];
    weight = std::max(weight, closures_[i].distinctness);
  }
  double sum = 0;
  for (const auto& [place, weight] : per_place) sum += weight;
  return sum;
}

/// The farther away a query may stand, the more places look like it by chance.
double ClosureSets::wanted(const Members& members, double min_weight) const {
  double reach_m = kMaxReachM;
  for (const std::size_t i : members) reach_m = std::min(reach_m, closures_[i].reach_m);
  return min_weight + kWeightPerLogReach * std::log(std::max(1.0, reach_m / kUsualReachM));
}

ClosureSets::Members ClosureSets::best(std::size_t first_new, double min_weight) {
  if (weight(by_weight_) < min_weight) return {};  // no set of them weighs more
  Members best;
  for (std::size_t i = first_new; i < closures_.size(); ++i) {
    if (holds(best, i)) continue;
    Members members = grow(i);
    if (weight(members) > weight(best)) best = std::move(members);
  }
  if (best.empty() || weight(best) < wanted(best, min_weight)) return {};
  for (std::size_t i = 0; i < closures_.size(); ++i) {
    if (agrees_with_all(i, best)) continue;
    const Members other = grow(i);
    if (weight_without(best, other) >= kAlternativeRatio * weight_without(other, best)) continue;
    Members common;
    std::copy_if(best.begin(), best.end(), std::back_inserter(common),
                 [&](std::size_t member) { return holds(other, member); });
    best = std::move(common);
    if (best.empty() || weight(best) < wanted(best, min_weight)) return {};
  }
  return best;
}

}  // namespace extperfc::mapping
