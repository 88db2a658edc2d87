#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "extperfc/sources/scan_log.hpp"

namespace extperfc::sources {

/// Gives scans the odometry of their own stamps, where a recording holds both as streams of their own.
///
/// A scan waits until odometry has passed its stamp and gets the pose between its two neighbours. One that
/// waits in vain (odometry stops, or leaves a gap of more than kLongestGapS) leaves without. Scans leave in
/// the order in which they came. A stamp that runs back by more than a second is a recording that starts
/// again: nothing is paired across it. Memory is bounded. One thread at a time.
class ScanPairing {
 public:
  static constexpr double kLongestGapS = 1.0;
  static constexpr std::size_t kMostWaiting = 400;

  void add_odometry(double stamp_s, const Pose2& odom_T_base);
  void add_scan(ScanRecord record);
  /// The recording is over: nothing waits any longer.
  void finish() { finished_ = true; }

  /// The next scan that waits no longer; nothing when there is none.
  [[nodiscard]] std::optional<ScanRecord> take();
  /// Where odometry saw the robot at a stamp, interpolated; nothing where it does not reach.
  [[nodiscard]] std::optional<Pose2> at(double stamp_s) const;

 private:
  struct Waiting {
    ScanRecord record;
    std::size_t epoch{0};
  };
  [[nodiscard]] bool ready(const Waiting& scan) const;

  struct Odometry {
    double stamp_s{0};
    Pose2 pose;
  };
  std::deque<Odometry> track_;  // of the present epoch, by stamp
  std::deque<Waiting> waiting_;
  double newest_s_{0};    // stamp of the newest scan
  std::size_t epoch_{0};  // counts the recording's new starts
  bool finished_{false};
};

}  // namespace extperfc::sources
