#include "sources/recorded_poses.hpp"

#include <cmath>
#include <fstream>
#include <iterator>
#include <locale>
#include <sstream>
#include <string>

namespace extperfc::sources {

namespace {

/// Stamps are written with a microsecond; within this a stamp is the pose's own.
constexpr double kSameStampS = 1e-4;

Result<std::pair<double, Eigen::Isometry3d>> parse_pose(const std::string& line) {
  std::istringstream in(line);
  in.imbue(std::locale::classic());
  double stamp_s = 0.0;
  Eigen::Vector3d position;
  Eigen::Quaterniond rotation;
  if (!(in >> stamp_s >> position.x() >> position.y() >> position.z() >> rotation.x() >> rotation.y() >>
        rotation.z() >> rotation.w()))
    return fail(ErrorCode::kCorrupt, "expected 'stamp tx ty tz qx qy qz qw', found '" + line + "'");
  constexpr double kNormTolerance = 0.01;
  if (std::abs(rotation.norm() - 1.0) > kNormTolerance)
    return fail(ErrorCode::kCorrupt, "the quaternion of '" + line + "' is not of length 1");
  Eigen::Isometry3d pose(rotation.normalized());
  pose.translation() = position;
  return std::pair(stamp_s, pose);
}

Eigen::Isometry3d between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double ratio) {
  Eigen::Isometry3d pose(
      Eigen::Quaterniond(a.rotation()).slerp(ratio, Eigen::Quaterniond(b.rotation())).normalized());
  pose.translation() = (1.0 - ratio) * a.translation() + ratio * b.translation();
  return pose;
}

}  // namespace

Result<RecordedPoses> RecordedPoses::load(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) return fail(ErrorCode::kNotFound, "cannot read " + file.string());
  RecordedPoses recorded;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const auto first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    const auto pose = parse_pose(line);
    if (!pose)
      return fail(pose.error().code,
                  file.string() + " line " + std::to_string(number) + ": " + pose.error().message);
    recorded.poses_.insert(*pose);
  }
  return recorded;
}

std::optional<Eigen::Isometry3d> RecordedPoses::at(double stamp_s) const {
  constexpr double kLongestGapS = 0.5;
  const auto after = poses_.lower_bound(stamp_s - kSameStampS);
  if (after == poses_.end()) return std::nullopt;
  if (after->first <= stamp_s + kSameStampS) return after->second;
  if (after == poses_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const double gap_s = after->first - before->first;
  if (gap_s > kLongestGapS) return std::nullopt;
  return between(before->second, after->second, (stamp_s - before->first) / gap_s);
}

}  // namespace extperfc::sources
