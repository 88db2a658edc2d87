#include "ros/navigate/outline_monitor.hpp"

#include <cmath>

#include <ros/console.h>

namespace extperfc::ros_navigate {

namespace {

constexpr double kPeriodS = 0.2;  // of wall time, between two outlines
constexpr double kMinChangeRad = 0.01;

}  // namespace

OutlineMonitor::OutlineMonitor(ros::NodeHandle handle, const ros::NodeHandle& private_handle,
                               const ros_params::NavigatorNodeParams& params)
    : base_(params.footprint.outline()),
      padding_m_(params.footprint.padding_m),
      footprint_(std::make_shared<const navigate::Footprint>(base_.padded(padding_m_))),
      bare_(std::make_shared<const navigate::Footprint>(base_)) {
  if (!params.arms.enabled) return;
  auto overhang = ros_params::load_overhang(private_handle, params);
  if (!overhang) {
    problem_ = overhang.error().message;
    return;
  }
  overhang_ = std::move(*overhang);
  subscriber_ = handle.subscribe<sensor_msgs::JointState>(
      "joint_states", 5, [this](const auto& message) { on_joints(*message); });
}

void OutlineMonitor::on_joints(const sensor_msgs::JointState& message) {
  if (message.name.size() != message.position.size()) return;
  const std::lock_guard lock(mutex_);
  bool changed = false;
  for (std::size_t i = 0; i < message.name.size(); ++i) {
    if (!std::isfinite(message.position[i])) continue;
    const auto [known, is_new] = positions_.try_emplace(message.name[i], message.position[i]);
    changed = changed || is_new || std::abs(known->second - message.position[i]) > kMinChangeRad;
  }
  const auto now = ros::WallTime::now();
  if (!changed || (now - computed_).toSec() < kPeriodS) return;
  for (std::size_t i = 0; i < message.name.size(); ++i)
    if (std::isfinite(message.position[i])) positions_[message.name[i]] = message.position[i];
  computed_ = now;
  rebuild();
}

void OutlineMonitor::rebuild() {
  const auto points = overhang_ && !positions_.empty() ? overhang_->points(positions_, base_)
                                                       : std::vector<Eigen::Vector2d>();
  const auto whole = points.empty() ? base_ : base_.extended(points);
  overhang_m_ = whole.circumscribed_radius_m() - base_.circumscribed_radius_m();
  footprint_ = std::make_shared<const navigate::Footprint>(whole.padded(padding_m_));
  bare_ = std::make_shared<const navigate::Footprint>(whole);
}

OutlineMonitor::FootprintPtr OutlineMonitor::bare() const {
  const std::lock_guard lock(mutex_);
  return bare_;
}

OutlineMonitor::FootprintPtr OutlineMonitor::footprint() const {
  const std::lock_guard lock(mutex_);
  return footprint_;
}

double OutlineMonitor::overhang_m() const {
  const std::lock_guard lock(mutex_);
  return overhang_m_;
}

void OutlineMonitor::set_params(const ros_params::NavigatorNodeParams& params) {
  const std::lock_guard lock(mutex_);
  base_ = params.footprint.outline();
  padding_m_ = params.footprint.padding_m;
  rebuild();
}

}  // namespace extperfc::ros_navigate
