#include <algorithm>
#include <cmath>
#include <string>

#include "extperfc/offline/relations.hpp"

namespace extperfc::offline {

namespace {

using ScanPoses = std::vector<std::optional<Pose2>>;

constexpr double kSameStampS = 1e-4;

std::size_t count_of(const std::vector<ScanMoment>& scans) {
  std::size_t max_index = 0;
  for (const auto& scan : scans) max_index = std::max(max_index, scan.index + 1);
  return max_index;
}

/// For each pose the place of its scan, both in their order.
Result<std::vector<std::size_t>> match(const Trajectory& trajectory, const std::vector<ScanMoment>& scans) {
  std::vector<std::size_t> matched;
  std::size_t next = 0;
  for (const auto& pose : trajectory) {
    const auto found = std::find_if(
        scans.begin() + static_cast<std::ptrdiff_t>(next), scans.end(),
        [&](const ScanMoment& scan) { return std::abs(scan.stamp_s - pose.stamp_s) <= kSameStampS; });
    if (found == scans.end())
      return fail(ErrorCode::kInvalidArgument,
                  "the recording has no scan with the stamp " + std::to_string(pose.stamp_s) + " of pose " +
                      std::to_string(matched.size()) +
                      " of the trajectory (or not in this order); is it of this recording?");
    matched.push_back(static_cast<std::size_t>(found - scans.begin()));
    next = matched.back() + 1;
  }
  return matched;
}

/// The scans strictly between two poses, by odometry. What odometry misses at the second pose is shared out
/// in proportion to the scans passed.
void interpolate(const std::vector<ScanMoment>& scans, std::size_t first, std::size_t last,
                 ScanPoses& poses) {
  if (!scans[first].odom_T_base || !scans[last].odom_T_base) return;
  const Pose2 start = *poses[scans[first].index];
  const Pose2 end = *poses[scans[last].index];
  const Pose2 reckoned = compose(start, between(*scans[first].odom_T_base, *scans[last].odom_T_base));
  const Pose2 missed{end.x - reckoned.x, end.y - reckoned.y, wrap_angle(end.yaw - reckoned.yaw)};
  for (std::size_t i = first + 1; i < last; ++i) {
    if (!scans[i].odom_T_base) continue;
    const double ratio = static_cast<double>(i - first) / static_cast<double>(last - first);
    const Pose2 there = compose(start, between(*scans[first].odom_T_base, *scans[i].odom_T_base));
    poses[scans[i].index] = Pose2{there.x + ratio * missed.x, there.y + ratio * missed.y,
                                  wrap_angle(there.yaw + ratio * missed.yaw)};
  }
}

}  // namespace

Result<ScanPoses> poses_of_scans(const Trajectory& trajectory, const std::vector<ScanMoment>& scans) {
  ScanPoses poses(count_of(scans));
  if (trajectory.size() == scans.size()) {
    for (std::size_t i = 0; i < scans.size(); ++i) poses[scans[i].index] = trajectory[i].pose;
    return poses;
  }
  const auto matched = match(trajectory, scans);
  if (!matched) return tl::unexpected(matched.error());
  for (std::size_t i = 0; i < matched->size(); ++i) poses[scans[(*matched)[i]].index] = trajectory[i].pose;
  for (std::size_t i = 1; i < matched->size(); ++i)
    interpolate(scans, (*matched)[i - 1], (*matched)[i], poses);
  return poses;
}

}  // namespace extperfc::offline
