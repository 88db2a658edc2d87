#include "arm/cartesian/follower.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "extperfc/arm/inverse_kinematics.hpp"

#include "arm/cartesian/newton.hpp"

namespace extperfc::arm {

namespace {

constexpr double kShortestM = 1e-5;         // a step that is lost below this is a jump
constexpr double kShortestBlockedM = 5e-4;  // how near an obstacle is approached
constexpr double kGrowth = 1.5;             // of the step after one that was taken
constexpr double kElbowStepRad = 0.1;
constexpr double kMinElbowRad = 1e-3;
constexpr double kSpare = 0.9;    // fraction of the tolerance at the places that are looked at
constexpr double kAheadM = 2e-3;  // where the reason of an end is looked for

}  // namespace

Follower::Follower(CollisionChecker& checker, const ArmInGroup& arm, const CartesianParams& params,
                   const ToolPath& path, const JointVector& others)
    : checker_(checker), arm_(arm), params_(params), path_(path), others_(others) {}

// The gradient of sum of x^2 / 2 + x^6 / 6 with x the distance from mid-range in half ranges.
JointVector Follower::urge(const Course& course, const JointVector& joints) {
  const ArmChain& chain = arm_.chain();
  JointVector result = JointVector::Zero(joints.size());
  if (course.centring > 0)
    result = from_mid_range(chain.limits(), joints).unaryExpr([&](double x) {
      return -course.centring * (x + std::pow(x, 5));
    });
  if (course.swing_rad_per_m != 0) {
    side_ = self_motion(chain, joints, side_);
    result += course.swing_rad_per_m * side_;
  }
  return result;
}

Follower::Step Follower::try_step(const Course& course, const Station& from, double length, Station& to) {
  const double end = path_.line_end(from.place);
  to.place = from.place + length >= end - 1e-12 ? end : from.place + length;
  const double taken = to.place - from.place;
  to.joints = from.joints + step_towards(arm_.chain(), from.joints, taken * path_.tangent(from.place),
                                         taken * urge(course, from.joints));
  return settle(from, to);
}

// Brings the tip of `to` to its place and judges the segment.
Follower::Step Follower::settle(const Station& from, Station& to) {
  if (!converge(arm_.chain(), path_.at(to.place), true, to.joints)) return Step::kLost;
  if ((to.joints - from.joints).cwiseAbs().maxCoeff() > params_.max_joint_step_rad) return Step::kLost;
  if (!keeps_tolerance(from, to)) return Step::kBent;
  if (!checker_.motion_free(arm_.put(from.joints, others_), arm_.put(to.joints, others_)))
    return Step::kBlocked;
  return Step::kTaken;
}

// At the quarters. What a segment deviates by vanishes at its ends and is nearly a cubic of the place on it;
// the greatest deviation of a cubic that keeps t at the quarters is below t / 0.97.
bool Follower::keeps_tolerance(const Station& from, const Station& to) const {
  for (const double fraction : {0.25, 0.5, 0.75}) {
    const Pose tip = arm_.chain().forward(from.joints + fraction * (to.joints - from.joints));
    if (!near_line(tip, from.place + fraction * (to.place - from.place))) return false;
  }
  return true;
}

// The nearest place of the line counts, position and angle measured in tolerances.
bool Follower::near_line(const Pose& root_T_tip, double place) const {
  Vector6 weight;
  weight << Eigen::Vector3d::Constant(1 / params_.position_tolerance_m),
      Eigen::Vector3d::Constant(1 / params_.orientation_tolerance_rad);
  const Vector6 tangent = weight.cwiseProduct(path_.tangent(place));
  const Vector6 error = weight.cwiseProduct(pose_difference(root_T_tip, path_.at(place)));
  const Vector6 aside = error - tangent * (tangent.dot(error) / tangent.squaredNorm());
  return aside.head<3>().norm() <= kSpare && aside.tail<3>().norm() <= kSpare;
}

// As far as it goes: what stops it does not matter.
CartesianEnd Follower::move_elbow(double angle_rad, const std::function<CartesianEnd()>& interrupted,
                                  std::vector<Station>& route) {
  double length = kElbowStepRad;
  for (double left = std::abs(angle_rad); left > kMinElbowRad && length > kMinElbowRad;) {
    if (const auto end = interrupted(); end != CartesianEnd::kComplete) return end;
    const Station from = route.back();
    side_ = self_motion(arm_.chain(), from.joints, side_);
    const double step = std::copysign(std::min(length, left), angle_rad);
    const JointVector aim = step * side_;
    Station to{from.joints + step_towards(arm_.chain(), from.joints, Vector6::Zero(), aim), from.place};
    if (settle(from, to) != Step::kTaken || (to.joints - from.joints).dot(aim) < 0.5 * aim.squaredNorm()) {
      length *= 0.5;
      continue;
    }
    route.push_back(to);
    left -= std::abs(step);
    length = std::min(kGrowth * length, kElbowStepRad);
  }
  return CartesianEnd::kComplete;
}

FollowStop Follower::follow(const Course& course, const std::function<CartesianEnd()>& interrupted,
                            std::vector<Station>& route) {
  side_ = JointVector::Constant(arm_.joint_count(), 1.0);
  if (course.elbow_rad != 0 && route.back().place < path_.length())
    if (const auto end = move_elbow(course.elbow_rad, interrupted, route); end != CartesianEnd::kComplete)
      return {end, {}, -1};
  double length = params_.max_step_m;
  while (route.back().place < path_.length()) {
    if (const auto end = interrupted(); end != CartesianEnd::kComplete) return {end, {}, -1};
    const Station from = route.back();
    Station to;
    const Step step = try_step(course, from, length, to);
    if (step == Step::kTaken) {
      route.push_back(to);
      length = std::min(kGrowth * length, params_.max_step_m);
      continue;
    }
    length = 0.5 * std::min(length, path_.line_end(from.place) - from.place);
    if (step == Step::kBlocked && length < kShortestBlockedM) return why_blocked(from, to);
    if (length < kShortestM) return step == Step::kBlocked ? why_blocked(from, to) : why_lost(from);
  }
  return {};
}

FollowStop Follower::why_blocked(const Station& from, const Station& to) {
  FollowStop stop{CartesianEnd::kCollision, {}, -1};
  const JointVector next = arm_.put(to.joints, others_);
  stop.contact = checker_.contact(next);
  if (!stop.contact) stop.contact = checker_.nearest(next);
  if (!stop.contact) stop.contact = checker_.nearest(arm_.put(from.joints, others_));
  return stop;
}

FollowStop Follower::why_lost(const Station& at) const {
  const ArmChain& chain = arm_.chain();
  const Pose ahead = path_.at(std::min(at.place + kAheadM, path_.line_end(at.place)));
  JointVector beyond = at.joints;
  if (converge(chain, ahead, false, beyond) &&
      (beyond - at.joints).cwiseAbs().maxCoeff() <= params_.max_joint_step_rad) {
    int joint = 0;
    const double excess =
        (beyond - chain.limits().upper).cwiseMax(chain.limits().lower - beyond).maxCoeff(&joint);
    if (excess > 0) return {CartesianEnd::kLimit, {}, joint};
  }
  IkOptions options;
  options.timeout_s = std::numeric_limits<double>::infinity();
  options.max_restarts = 20;
  const auto found = InverseKinematics(chain).solve(ahead, at.joints, options);
  if (found) return {CartesianEnd::kSingularity, {}, -1};
  if (found.error().reason == IkReason::kOutOfReach) return {CartesianEnd::kOutOfReach, {}, -1};
  int joint = 0;
  (chain.limits().upper - at.joints).cwiseMin(at.joints - chain.limits().lower).minCoeff(&joint);
  return {CartesianEnd::kLimit, {}, joint};
}

}  // namespace extperfc::arm
