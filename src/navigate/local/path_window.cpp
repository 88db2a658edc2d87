#include "navigate/local/path_window.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "extperfc/base/math.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kBehind_m = 0.3;      // of the last place that is searched
constexpr double kAhead_m = 1.0;       // the same
constexpr double kFreshStart_m = 1.5;  // of a new path's beginning that is searched
constexpr double kLost_m = 0.7;        // neither stretch is near: the whole path is searched
constexpr double kSwitch_m = 0.1;      // the old place must be nearer by this than the beginning

double step_m(const Pose2& a, const Pose2& b) {
  return std::sqrt(square(b.x - a.x) + square(b.y - a.y) + square(kRadian_m * (b.yaw - a.yaw)));
}

float norm(float dx_m, float dy_m, float dyaw_rad) {
  const float across_m = static_cast<float>(kRadian_m) * dyaw_rad;
  return std::sqrt(dx_m * dx_m + dy_m * dy_m + across_m * across_m);
}

/// A differential base heads along its path, forwards or backwards, except where it rotates on the spot.
void align_headings(std::vector<Pose2>& poses) {
  constexpr double kMoves_m = 1e-3;
  constexpr double kAligned_rad = 0.6;
  for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
    const double dx = poses[i + 1].x - poses[i].x;
    const double dy = poses[i + 1].y - poses[i].y;
    if (std::hypot(dx, dy) < kMoves_m) continue;
    const double along = std::atan2(dy, dx);
    const double off = std::abs(wrap_angle(poses[i].yaw - along));
    if (off > kAligned_rad && off < kPi - kAligned_rad) poses[i].yaw = along;
  }
}

}  // namespace

void PathWindow::set(const Path& path, BaseKind base) {
  driven_ = driven_ || (!fresh_ && !poses_.empty());
  poses_ = path.poses;
  if (base == BaseKind::kDifferential) align_headings(poses_);
  if (poses_.size() == 1) poses_.push_back(poses_.front());
  lengths_.assign(1, 0.0);
  lengths_.reserve(poses_.size());
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    poses_[i].yaw = poses_[i - 1].yaw + wrap_angle(poses_[i].yaw - poses_[i - 1].yaw);
    lengths_.push_back(lengths_.back() + step_m(poses_[i - 1], poses_[i]));
  }
  fresh_ = true;
}

void PathWindow::clear() {
  *this = PathWindow();
}

void PathWindow::locate(const Pose2& robot) {
  Match best;
  if (fresh_) {
    best = match(robot, 0, kFreshStart_m);
    if (driven_) {
      const Match old = match(robot, at_m_ - kAhead_m, at_m_ + kAhead_m);
      if (old.distance_m + kSwitch_m < best.distance_m) best = old;
    }
  } else {
    best = match(robot, at_m_ - kBehind_m, at_m_ + kAhead_m);
  }
  if (best.distance_m > kLost_m) {
    const Match anywhere = match(robot, 0, lengths_.back());
    if (anywhere.distance_m + kSwitch_m < best.distance_m) best = anywhere;
  }
  at_m_ = best.at_m;
  fresh_ = false;
}

PathWindow::Match PathWindow::match(const Pose2& robot, double from_m, double to_m) const {
  Match best{std::numeric_limits<double>::infinity(), std::clamp(from_m, 0.0, lengths_.back())};
  for (std::size_t i = 0; i + 1 < poses_.size(); ++i) {
    if (lengths_[i + 1] < from_m || lengths_[i] > to_m) continue;
    const Pose2& a = poses_[i];
    const Pose2& b = poses_[i + 1];
    const Eigen::Vector3d edge(b.x - a.x, b.y - a.y, kRadian_m * (b.yaw - a.yaw));
    const Eigen::Vector3d to(robot.x - a.x, robot.y - a.y, kRadian_m * wrap_angle(robot.yaw - a.yaw));
    const double length2 = edge.squaredNorm();
    const double part = length2 > 0 ? std::clamp(edge.dot(to) / length2, 0.0, 1.0) : 0.0;
    const double distance_m = (to - part * edge).norm();
    // The end of a rotation on the spot wins over its beginning only when it is nearer.
    if (distance_m < best.distance_m)
      best = {distance_m, lengths_[i] + part * (lengths_[i + 1] - lengths_[i])};
  }
  if (!std::isfinite(best.distance_m)) {  // the stretch lies beyond the path
    const Pose2& end = from_m > 0 ? poses_.back() : poses_.front();
    best.distance_m = std::hypot(robot.x - end.x, robot.y - end.y);
  }
  return best;
}

Pose2 PathWindow::pose_at(double length_m) const {
  const auto after = std::upper_bound(lengths_.begin(), lengths_.end(), length_m);
  if (after == lengths_.begin()) return poses_.front();
  if (after == lengths_.end()) return poses_.back();
  const auto i = static_cast<std::size_t>(after - lengths_.begin());
  const Pose2& a = poses_[i - 1];
  const Pose2& b = poses_[i];
  const double part = (length_m - lengths_[i - 1]) / (lengths_[i] - lengths_[i - 1]);
  return {a.x + part * (b.x - a.x), a.y + part * (b.y - a.y), a.yaw + part * (b.yaw - a.yaw)};
}

void PathWindow::stations(const Pose2& robot, double length_m, std::vector<Station>& out) const {
  out.clear();
  const double end_m = std::min(length_m, remaining_m());
  const auto count = static_cast<std::size_t>(std::max(1.0, std::ceil(end_m / kStationStep_m - 1e-6)));
  const double first_yaw = pose_at(at_m_).yaw;
  const double shift = robot.yaw + wrap_angle(first_yaw - robot.yaw) - first_yaw;
  for (std::size_t i = 0; i <= count; ++i) {
    const double s = std::min(end_m, static_cast<double>(i) * kStationStep_m);
    const Pose2 pose = pose_at(at_m_ + s);
    Station station;
    station.x = static_cast<float>(pose.x - robot.x);
    station.y = static_cast<float>(pose.y - robot.y);
    station.yaw = static_cast<float>(pose.yaw + shift);
    out.push_back(station);
  }
  differentiate(out);
}

void differentiate(std::vector<Station>& stations) {
  constexpr std::size_t kReach = 2;  // stations to either side: jags of a grid's path are smaller
  const std::size_t last = stations.size() - 1;
  for (std::size_t i = 1; i <= last; ++i) {
    const Station& a = stations[i - 1];
    Station& b = stations[i];
    b.s = a.s + norm(b.x - a.x, b.y - a.y, b.yaw - a.yaw);
  }
  for (std::size_t i = 0; i <= last; ++i) {
    const Station& a = stations[i > kReach ? i - kReach : 0];
    const Station& b = stations[std::min(last, i + kReach)];
    const float dx = b.x - a.x;
    const float dy = b.y - a.y;
    const float dyaw = b.yaw - a.yaw;
    const float length = norm(dx, dy, dyaw);
    const float inverse = length > 1e-6F ? 1 / length : 0;
    stations[i].dx = dx * inverse;
    stations[i].dy = dy * inverse;
    stations[i].dyaw = dyaw * inverse;
  }
}

}  // namespace extperfc::navigate
