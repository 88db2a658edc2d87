#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include <diagnostic_updater/DiagnosticStatusWrapper.h>
#include <ros/time.h>

#include "extperfc/mapping/mapper.hpp"

namespace extperfc::ros_mapping {

/// Counts of scans by their result, for diagnostics. Thread-safe.
class MappingHealth {
 public:
  /// Diagnostics warn of what happened for `recent_s` of wall time.
  explicit MappingHealth(double recent_s) : recent_s_(recent_s) {}

  void used(const mapping::MapperUpdate& update, const mapping::MapperStatistics& statistics,
            mapping::MapperMode mode, double mapper_ms);
  /// `why_missing`: tf's error; empty: odometry is available or not used.
  void odometry(const std::string& why_missing);
  void imu_missing(const std::string& why);
  void without_transform();
  void jumped();
  void time_ran_back();
  void queue_full();
  void refused();
  void skipped_while_paused();
  void throttled();
  void paused(bool yes);
  /// The map was replaced; counters of the nodelet stay.
  void restarted();

  void report(diagnostic_updater::DiagnosticStatusWrapper& status) const;

 private:
  /// An event that diagnostics count.
  struct Event {
    std::uint64_t count{0};
    ros::WallTime last;
    void happened() {
      ++count;
      last = ros::WallTime::now();
    }
  };

  void warn_of(diagnostic_updater::DiagnosticStatusWrapper& status, const Event& event,
               const char* text) const;
  [[nodiscard]] const char* state() const;
  void report_counts(diagnostic_updater::DiagnosticStatusWrapper& status) const;
  void report_mapper(diagnostic_updater::DiagnosticStatusWrapper& status) const;
  void report_warnings(diagnostic_updater::DiagnosticStatusWrapper& status) const;

  const double recent_s_;
  mutable std::mutex mutex_;
  std::optional<mapping::MapperUpdate> last_;
  mapping::MapperStatistics statistics_;
  mapping::MapperMode mode_{mapping::MapperMode::kMapping};
  double mapper_ms_{0};
  double longest_mapper_ms_{0};
  std::uint64_t used_{0};
  std::uint64_t throttled_{0};
  std::uint64_t skipped_{0};
  std::uint64_t refused_{0};
  std::uint64_t without_odometry_{0};
  std::uint64_t without_imu_{0};
  bool paused_{false};
  std::string odometry_missing_;
  std::string imu_missing_;
  Event without_transform_;
  Event jumps_;
  Event contradictions_;
  Event backward_;
  Event queue_full_;
};

}  // namespace extperfc::ros_mapping
