#include "extperfc/simulate/joint_spline.hpp"

#include <algorithm>

namespace extperfc::simulate {

namespace {

using Coefficients = Eigen::Matrix<double, Eigen::Dynamic, 6>;

Coefficients linear(const JointKnot& from, const JointKnot& to) {
  Coefficients c = Coefficients::Zero(from.position.size(), 6);
  c.col(0) = from.position;
  c.col(1) = (to.position - from.position) / (to.time_s - from.time_s);
  return c;
}

Coefficients cubic(const JointKnot& from, const JointKnot& to) {
  const double t = to.time_s - from.time_s;
  const Eigen::VectorXd& v0 = *from.velocity;
  const Eigen::VectorXd& v1 = *to.velocity;
  const Eigen::VectorXd delta = to.position - from.position;
  Coefficients c = Coefficients::Zero(from.position.size(), 6);
  c.col(0) = from.position;
  c.col(1) = v0;
  c.col(2) = (3 * delta - (2 * v0 + v1) * t) / (t * t);
  c.col(3) = (-2 * delta + (v0 + v1) * t) / (t * t * t);
  return c;
}

/// What is left of position, velocity and acceleration at the end, after the start's own Taylor polynomial,
/// is made up by the three highest powers.
Coefficients quintic(const JointKnot& from, const JointKnot& to) {
  const double t = to.time_s - from.time_s;
  const Eigen::VectorXd& a0 = *from.acceleration;
  const Eigen::VectorXd delta = to.position - from.position - *from.velocity * t - 0.5 * a0 * t * t;
  const Eigen::VectorXd speed = (*to.velocity - *from.velocity - a0 * t) * t;
  const Eigen::VectorXd bend = (*to.acceleration - a0) * t * t;
  Coefficients c(from.position.size(), 6);
  c.col(0) = from.position;
  c.col(1) = *from.velocity;
  c.col(2) = 0.5 * a0;
  c.col(3) = (10 * delta - 4 * speed + 0.5 * bend) / (t * t * t);
  c.col(4) = (-15 * delta + 7 * speed - bend) / (t * t * t * t);
  c.col(5) = (6 * delta - 3 * speed + 0.5 * bend) / (t * t * t * t * t);
  return c;
}

Coefficients part(const JointKnot& from, const JointKnot& to) {
  if (!from.velocity || !to.velocity) return linear(from, to);
  if (!from.acceleration || !to.acceleration) return cubic(from, to);
  return quintic(from, to);
}

JointMotion at_rest(const Eigen::VectorXd& position) {
  return {position, Eigen::VectorXd::Zero(position.size()), Eigen::VectorXd::Zero(position.size())};
}

}  // namespace

JointSpline::JointSpline(const std::vector<JointKnot>& knots)
    : first_(knots.front().position), last_(knots.back().position) {
  for (const auto& knot : knots) knot_times_.push_back(knot.time_s);
  for (std::size_t i = 1; i < knots.size(); ++i) parts_.push_back(part(knots[i - 1], knots[i]));
}

JointMotion JointSpline::sample(double time_s) const {
  if (time_s < start_s()) return at_rest(first_);
  if (time_s >= end_s()) return at_rest(last_);
  const auto after = std::upper_bound(knot_times_.begin(), knot_times_.end(), time_s);
  const auto index = static_cast<std::size_t>(after - knot_times_.begin()) - 1;
  const double t = time_s - knot_times_[index];
  const auto& c = parts_[index];
  Eigen::Matrix<double, 6, 1> position;
  Eigen::Matrix<double, 6, 1> velocity;
  Eigen::Matrix<double, 6, 1> acceleration;
  position << 1, t, t * t, t * t * t, t * t * t * t, t * t * t * t * t;
  velocity << 0, 1, 2 * t, 3 * t * t, 4 * t * t * t, 5 * t * t * t * t;
  acceleration << 0, 0, 2, 6 * t, 12 * t * t, 20 * t * t * t;
  return {c * position, c * velocity, c * acceleration};
}

}  // namespace extperfc::simulate
