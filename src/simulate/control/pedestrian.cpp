#include "simulate/control/pedestrian.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::simulate {
namespace {

constexpr double kPersonalSpaceM = 1.0;
constexpr double kYawRateRadS = 4.0;
constexpr double kPatienceS = 3.0;

}  // namespace

Pedestrian::Pedestrian(const PersonSpec& person) : corners_(person.path_m), speed_m_s_(person.speed_m_s) {
  if (!person.closed)
    for (std::size_t i = person.path_m.size() - 1; i-- > 0;) corners_.push_back(person.path_m[i]);
  else
    corners_.push_back(person.path_m.front());
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    if (i > 0) length_m_ += (corners_[i] - corners_[i - 1]).norm();
    if (i < person.stands_s.size() && person.stands_s[i] > 0)
      stands_.push_back({length_m_, person.stands_s[i]});
  }
  pose_ = at(0);
}

Pose2 Pedestrian::at(double along_m) const {
  for (std::size_t i = 1; i < corners_.size(); ++i) {
    const Eigen::Vector2d segment = corners_[i] - corners_[i - 1];
    const double length = segment.norm();
    if (along_m <= length && length > 0) {
      const Eigen::Vector2d here = corners_[i - 1] + segment * (along_m / length);
      return {here.x(), here.y(), std::atan2(segment.y(), segment.x())};
    }
    along_m -= length;
  }
  return {corners_.back().x(), corners_.back().y(), 0};
}

Pose2 Pedestrian::heading_along() const {
  Pose2 pose = at(along_m_);
  if (direction_ < 0) pose.yaw = wrap_angle(pose.yaw + M_PI);
  return pose;
}

bool Pedestrian::path_is_clear(const Pose2& robot) const {
  const Eigen::Vector2d to_robot(robot.x - pose_.x, robot.y - pose_.y);
  const Pose2 next = heading_along();
  const Eigen::Vector2d ahead(std::cos(next.yaw), std::sin(next.yaw));
  return to_robot.norm() > kPersonalSpaceM || ahead.dot(to_robot) < 0;
}

void Pedestrian::rotate_towards(double heading, double step_s) {
  const double yaw = wrap_angle(heading - pose_.yaw);
  const double max_step = kYawRateRadS * step_s;
  pose_.yaw = wrap_angle(pose_.yaw + std::clamp(yaw, -max_step, max_step));
}

bool Pedestrian::stands(double step_s) {
  if (direction_ < 0 || stands_.empty() || along_m_ < stands_.front().along_m) return false;
  if ((stands_.front().seconds -= step_s) <= 0) stands_.pop_front();
  return true;
}

void Pedestrian::step(double step_s, const Pose2& robot) {
  if (length_m_ <= 0) return;
  if (stands(step_s)) return;
  if (path_is_clear(robot)) {
    along_m_ = std::fmod(along_m_ + direction_ * speed_m_s_ * step_s + length_m_, length_m_);
    if (direction_ > 0 && !stands_.empty())  // looks where it came to
      along_m_ = std::min(along_m_, stands_.front().along_m);
    waited_s_ = std::max(0.0, waited_s_ - step_s);  // a step on does not make up for a long wait
  } else if ((waited_s_ += step_s) > kPatienceS) {
    direction_ = -direction_;
    waited_s_ = 0;
  }
  const Pose2 next = heading_along();
  pose_.x = next.x;
  pose_.y = next.y;
  rotate_towards(next.yaw, step_s);
}

}  // namespace extperfc::simulate
