#include "arm/cartesian/tool_path.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/arm/cartesian_path.hpp"

#include "arm/kinematics/rotation.hpp"

namespace extperfc::arm {

namespace {

constexpr double kNoLengthM = 1e-9;

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, rotation_vector / angle).toRotationMatrix();
}

}  // namespace

Vector6 pose_difference(const Pose& to, const Pose& from) {
  Vector6 difference;
  difference << to.translation() - from.translation(),
      rotation_vector(to.linear() * from.linear().transpose());
  return difference;
}

ToolPath::ToolPath(const std::vector<Pose>& poses) {
  double length = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Vector6 change = pose_difference(poses[i], poses[i - 1]);
    const double line = change.head<3>().norm() + CartesianPlanner::kMetresPerRad * change.tail<3>().norm();
    if (line < kNoLengthM) continue;
    length += line;
    lines_.push_back({poses[i - 1], change, line});
    ends_.push_back(length);
  }
}

std::size_t ToolPath::line_at(double place) const {
  const auto line = std::upper_bound(ends_.begin(), ends_.end(), place) - ends_.begin();
  return std::min(static_cast<std::size_t>(line), lines_.size() - 1);
}

double ToolPath::line_end(double place) const {
  return ends_[line_at(place)];
}

Pose ToolPath::at(double place) const {
  const std::size_t index = line_at(place);
  const Line& line = lines_[index];
  const double fraction = std::clamp(1.0 - (ends_[index] - place) / line.length, 0.0, 1.0);
  Pose pose = Pose::Identity();
  pose.translation() = line.start.translation() + fraction * line.change.head<3>();
  pose.linear() = rotation_of(fraction * line.change.tail<3>()) * line.start.linear();
  return pose;
}

Vector6 ToolPath::tangent(double place) const {
  const Line& line = lines_[line_at(place)];
  return line.change / line.length;
}

}  // namespace extperfc::arm
