#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "extperfc/sources/scan_log.hpp"

namespace extperfc::sources {

/// Interpolates odometry at the stamps of scans, for recordings with separate streams of both.
///
/// A scan waits until odometry has passed its stamp and gets the interpolated pose. When odometry stops, or
/// has a gap of more than kLongestGapS, the scan is returned without odometry. The order of scans is kept. A
/// stamp that runs back by more than a second is a recording that starts again: no interpolation across it.
/// Memory is bounded. One thread at a time.
class ScanPairing {
 public:
  static constexpr double kLongestGapS = 1.0;
  static constexpr std::size_t kMaxWaiting = 400;

  void add_odometry(double stamp_s, const Pose2& odom_T_base);
  void add_scan(ScanRecord record);
  /// Call after the end of the recording: releases all waiting scans.
  void finish() { finished_ = true; }

  /// The next scan that is ready; no value when there is none.
  [[nodiscard]] std::optional<ScanRecord> take();
  /// Interpolated odometry pose at a stamp; no value outside of its stamps.
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
