#include "ros/mapping/mapping_health.hpp"

#include <algorithm>

namespace extperfc::ros_mapping {

using diagnostic_msgs::DiagnosticStatus;
using diagnostic_updater::DiagnosticStatusWrapper;

void MappingHealth::used(const mapping::MapperUpdate& update, const mapping::MapperStatistics& statistics,
                         mapping::MapperMode mode, double mapper_ms) {
  const std::lock_guard lock(mutex_);
  ++used_;
  last_ = update;
  statistics_ = statistics;
  mode_ = mode;
  mapper_ms_ = mapper_ms;
  longest_mapper_ms_ = std::max(longest_mapper_ms_, mapper_ms);
  if (update.odometry_contradicted) contradictions_.happened();
}

void MappingHealth::odometry(const std::string& why_missing) {
  const std::lock_guard lock(mutex_);
  odometry_missing_ = why_missing;
  if (!why_missing.empty()) ++without_odometry_;
}

void MappingHealth::imu_missing(const std::string& why) {
  const std::lock_guard lock(mutex_);
  imu_missing_ = why;
  if (!why.empty()) ++without_imu_;
}

void MappingHealth::without_transform() {
  const std::lock_guard lock(mutex_);
  without_transform_.happened();
}

void MappingHealth::jumped() {
  const std::lock_guard lock(mutex_);
  jumps_.happened();
}

void MappingHealth::time_ran_back() {
  const std::lock_guard lock(mutex_);
  backward_.happened();
}

void MappingHealth::queue_full() {
  const std::lock_guard lock(mutex_);
  queue_full_.happened();
}

void MappingHealth::refused() {
  const std::lock_guard lock(mutex_);
  ++refused_;
}

void MappingHealth::skipped_while_paused() {
  const std::lock_guard lock(mutex_);
  ++skipped_;
}

void MappingHealth::throttled() {
  const std::lock_guard lock(mutex_);
  ++throttled_;
}

void MappingHealth::paused(bool yes) {
  const std::lock_guard lock(mutex_);
  paused_ = yes;
}

void MappingHealth::restarted() {
  const std::lock_guard lock(mutex_);
  last_.reset();
  statistics_ = {};
}

void MappingHealth::report(DiagnosticStatusWrapper& status) const {
  const std::lock_guard lock(mutex_);
  report_counts(status);
  report_mapper(status);
  report_warnings(status);
}

const char* MappingHealth::state() const {
  if (paused_) return "paused";
  if (used_ == 0) return "waiting for a scan";
  return mode_ == mapping::MapperMode::kLocalization ? "localizing" : "mapping";
}

void MappingHealth::report_counts(DiagnosticStatusWrapper& status) const {
  status.add("state", state());
  status.add("scans used", used_);
  status.add("scans refused", refused_);
  status.add("scans dropped: queue full", queue_full_.count);
  status.add("scans dropped: no transform", without_transform_.count);
  status.add("scans skipped while paused", skipped_);
  status.add("scans skipped by throttle_scans", throttled_);
  status.add("scans without odometry", without_odometry_);
  status.add("scans without imu", without_imu_);
  status.add("odometry jumps", jumps_.count);
  status.add("odometry contradicted", contradictions_.count);
  status.add("time ran back", backward_.count);
}

void MappingHealth::report_mapper(DiagnosticStatusWrapper& status) const {
  status.add("key frames", statistics_.key_frames);
  status.add("key frames thinned", statistics_.thinned_key_frames);
  status.add("scans unusable", statistics_.unusable_scans);
  status.add("loops closed", statistics_.loops);
  status.add("times carried", statistics_.carried);
  status.add("parts of the map", statistics_.parts);
  status.add("resamplings", statistics_.resamplings);
  status.addf("effective particles", "%.2f", statistics_.effective_particles);
  status.addf("entropy [nat]", "%.4f", statistics_.entropy);
  status.addf("path [m]", "%.2f", statistics_.path_m);
  status.addf("standard deviation of the position [m]", "%.3f", statistics_.position_sigma_m);
  status.addf("fit of the last scan", "%.3f", last_ ? last_->fit : 0.0);
  status.addf("mapper last [ms]", "%.2f", mapper_ms_);
  status.addf("mapper longest [ms]", "%.2f", longest_mapper_ms_);
}

void MappingHealth::warn_of(DiagnosticStatusWrapper& status, const Event& event, const char* text) const {
  if (event.count > 0 && (ros::WallTime::now() - event.last).toSec() < recent_s_)
    status.mergeSummary(DiagnosticStatus::WARN, text);
}

void MappingHealth::report_warnings(DiagnosticStatusWrapper& status) const {
  if (paused_)
    status.mergeSummary(DiagnosticStatus::WARN, "paused: scans are skipped until ~resume is called");
  if (last_ && last_->status == mapping::ScanStatus::kUnusable)
    status.mergeSummary(
        DiagnosticStatus::WARN,
        "the last scan has too few returns for scan matching: the pose follows odometry alone");
  else if (last_ && last_->lost)
    status.mergeSummary(DiagnosticStatus::WARN, "the scan shows other surroundings: was the robot carried?");
  else if (last_ && statistics_.key_frames > 1 && !last_->matched)
    status.mergeSummary(DiagnosticStatus::WARN,
                        "the last scan does not fit the map: the pose follows odometry alone");
  if (statistics_.parts > 1)
    status.mergeSummary(
        DiagnosticStatus::WARN,
        "the robot was carried to a place that is not recognized yet: drive on, or publish initialpose");
  if (!odometry_missing_.empty())
    status.mergeSummary(DiagnosticStatus::WARN, "no odometry, scan matching alone: " + odometry_missing_);
  if (!imu_missing_.empty()) status.mergeSummary(DiagnosticStatus::WARN, imu_missing_);
  warn_of(status, jumps_, "odometry jumped: the motion since the previous scan comes from scan matching");
  warn_of(status, contradictions_, "scans contradict odometry: do the wheels slip?");
  warn_of(status, backward_, "time ran back: mapping continues from the present pose");
  warn_of(status, queue_full_, "scans come faster than they are used: see throttle_scans and particles");
}

}  // namespace extperfc::ros_mapping
