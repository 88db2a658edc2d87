#include "extperfc/sources/scan_pairing.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace extperfc::sources {

namespace {

constexpr double kStartsAgainS = 1.0;
constexpr double kNearEnoughS = 0.1;  // before the first and behind the last odometry
constexpr std::size_t kMaxTrack = 4000;

}  // namespace

void ScanPairing::add_odometry(double stamp_s, const Pose2& odom_T_base) {
  if (!track_.empty() && stamp_s < track_.back().stamp_s - kStartsAgainS) {
    track_.clear();
    ++epoch_;
  }
  if (!track_.empty() && stamp_s <= track_.back().stamp_s) return;  // a repetition, or a little late
  track_.push_back({stamp_s, odom_T_base});
  if (track_.size() > kMaxTrack) track_.pop_front();
}

void ScanPairing::add_scan(ScanRecord record) {
  newest_s_ = record.scan.stamp_s;
  // A scan far before all odometry belongs to the new start that odometry has not reached yet.
  const bool ahead = !track_.empty() && record.scan.stamp_s < track_.front().stamp_s - kStartsAgainS;
  waiting_.push_back({std::move(record), epoch_ + (ahead ? 1 : 0)});
}

bool ScanPairing::ready(const Waiting& scan) const {
  if (finished_ || waiting_.size() > kMaxWaiting || scan.epoch < epoch_) return true;
  const double stamp_s = scan.record.scan.stamp_s;
  if (newest_s_ > stamp_s + kLongestGapS || newest_s_ < stamp_s - kStartsAgainS) return true;
  return scan.epoch == epoch_ && !track_.empty() && track_.back().stamp_s >= stamp_s;
}

std::optional<ScanRecord> ScanPairing::take() {
  if (waiting_.empty() || !ready(waiting_.front())) return std::nullopt;
  Waiting scan = std::move(waiting_.front());
  waiting_.pop_front();
  if (scan.epoch == epoch_) scan.record.odom_T_base = at(scan.record.scan.stamp_s);
  return std::move(scan.record);
}

std::optional<Pose2> ScanPairing::at(double stamp_s) const {
  if (track_.empty()) return std::nullopt;
  const auto after =
      std::lower_bound(track_.begin(), track_.end(), stamp_s,
                       [](const Odometry& entry, double stamp) { return entry.stamp_s < stamp; });
  if (after == track_.end())
    return stamp_s - track_.back().stamp_s <= kNearEnoughS ? std::optional(track_.back().pose) : std::nullopt;
  if (after == track_.begin())
    return after->stamp_s - stamp_s <= kNearEnoughS ? std::optional(after->pose) : std::nullopt;
  const auto before = std::prev(after);
  const double gap_s = after->stamp_s - before->stamp_s;
  if (gap_s > kLongestGapS && after->stamp_s != stamp_s) return std::nullopt;
  const double ratio = (stamp_s - before->stamp_s) / gap_s;
  const double yaw_change = wrap_angle(after->pose.yaw - before->pose.yaw);
  return Pose2{before->pose.x + ratio * (after->pose.x - before->pose.x),
               before->pose.y + ratio * (after->pose.y - before->pose.y),
               wrap_angle(before->pose.yaw + ratio * yaw_change)};
}

}  // namespace extperfc::sources
