#include "ros/health/stream_health.hpp"

#include <algorithm>

#include "extperfc/base/running_stats.hpp"

namespace extperfc::ros_health {

using diagnostic_msgs::DiagnosticStatus;

void InputHealth::received(const ros::Time& stamp, const void* data, bool by_pointer) {
  const std::lock_guard lock(mutex_);
  ++count_;
  stamp_ = stamp;
  data_ = data;
  by_pointer_ = by_pointer;
  last_activity_ = ros::WallTime::now();
}

void InputHealth::listening(bool on) {
  const std::lock_guard lock(mutex_);
  if (on && !listening_) last_activity_ = ros::WallTime::now();
  listening_ = on;
}

void InputHealth::report(diagnostic_updater::DiagnosticStatusWrapper& status, const std::string& topic,
                         double timeout_s) {
  const std::lock_guard lock(mutex_);
  const auto now = ros::WallTime::now();
  const double period_s = (now - last_report_).toSec();
  const double rate_hz = period_s > 0.0 ? static_cast<double>(count_ - count_at_report_) / period_s : 0.0;
  last_report_ = now;
  count_at_report_ = count_;
  status.add(label_ + " topic", topic);
  status.addf(label_ + " rate [Hz]", "%.1f", rate_hz);
  status.add(label_ + " received", count_);
  status.add(label_ + " transport", count_ == 0 ? "none yet" : by_pointer_ ? "pointer (no copy)" : "network");
  status.addf(label_ + " last", "%u.%09u @ %p", stamp_.sec, stamp_.nsec, data_);
  const double silent_s = (now - last_activity_).toSec();
  if (listening_ && silent_s > timeout_s)
    status.mergeSummaryf(DiagnosticStatus::WARN, "no message on %s for %.1f s: is its publisher running?",
                         topic.c_str(), silent_s);
}

std::vector<double> WorkHealth::Ring::copy() const {
  return {values.begin(), values.begin() + static_cast<std::ptrdiff_t>(std::min(count, kKept))};
}

void WorkHealth::done(double work_ms, double latency_ms) {
  const std::lock_guard lock(mutex_);
  ++done_;
  work_ms_.add(work_ms);
  latency_ms_.add(latency_ms);
  error_.clear();
}

bool WorkHealth::failed(const std::string& message) {
  const std::lock_guard lock(mutex_);
  ++failed_;
  const bool is_new = error_ != message;
  error_ = message;
  return is_new;
}

void WorkHealth::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const std::lock_guard lock(mutex_);
  const auto now = ros::WallTime::now();
  const double period_s = (now - last_report_).toSec();
  status.addf("processed [Hz]", "%.1f",
              period_s > 0.0 ? static_cast<double>(done_ - done_at_report_) / period_s : 0.0);
  last_report_ = now;
  done_at_report_ = done_;
  status.add("processed", done_);
  status.add("failed", failed_);
  auto work = work_ms_.copy();
  auto latency = latency_ms_.copy();
  status.addf("work median [ms]", "%.2f", percentile(work, 0.5));
  status.addf("work p95 [ms]", "%.2f", percentile(work, 0.95));
  status.addf("latency median [ms]", "%.2f", percentile(latency, 0.5));
  status.addf("latency p95 [ms]", "%.2f", percentile(latency, 0.95));
  if (!error_.empty()) status.mergeSummary(DiagnosticStatus::ERROR, error_);
}

}  // namespace extperfc::ros_health
