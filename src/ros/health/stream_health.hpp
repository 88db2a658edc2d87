#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include <diagnostic_updater/DiagnosticStatusWrapper.h>
#include <ros/message_event.h>
#include <ros/this_node.h>
#include <ros/time.h>

namespace extperfc::ros_health {

/// True when a message came from a publisher of this process, so that it travelled as a pointer.
template <typename M>
bool came_by_pointer(const ros::MessageEvent<M>& event) {
  return event.getPublisherName() == ros::this_node::getName();
}

/// Time since `stamp` [ms]. Never throws, unlike ros::Time's own difference, which a wild stamp makes
/// overflow.
[[nodiscard]] inline double age_ms(const ros::Time& stamp) {
  return 1e3 * (ros::Time::now().toSec() - stamp.toSec());
}

/// What one input topic delivers: counted in its callback, reported in diagnostics. Thread-safe.
class InputHealth {
 public:
  explicit InputHealth(std::string label) : label_(std::move(label)) {}

  /// A message arrived. `data` is where its payload lies: the same address at both ends proves that nothing
  /// was copied.
  void received(const ros::Time& stamp, const void* data, bool by_pointer);

  /// Listening begins or ends; the silence that diagnostics warn of is counted from here.
  void listening(bool on);

  /// Adds this topic's values to `status`; WARN when listening and silent for more than `timeout_s`.
  void report(diagnostic_updater::DiagnosticStatusWrapper& status, const std::string& topic,
              double timeout_s);

 private:
  std::mutex mutex_;
  const std::string label_;
  bool listening_{false};
  bool by_pointer_{false};
  std::uint64_t count_{0};
  std::uint64_t count_at_report_{0};
  ros::WallTime last_report_{ros::WallTime::now()};
  ros::WallTime last_activity_{ros::WallTime::now()};
  ros::Time stamp_;
  const void* data_{nullptr};
};

/// What became of the work: processed, failed, and how long it took. Thread-safe.
class WorkHealth {
 public:
  /// One item done. `work_ms` is the time of the work itself, `latency_ms` from the item's stamp to its
  /// publication.
  void done(double work_ms, double latency_ms);

  /// One item failed. Returns true when this error is new (not the one before it), so that it is worth
  /// logging.
  bool failed(const std::string& message);

  /// Adds rate and times to `status`; ERROR with the message while the last item failed.
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  static constexpr std::size_t kKept = 256;  ///< latest items that percentiles are taken from
  struct Ring {
    std::array<double, kKept> values{};
    std::size_t count{0};
    void add(double value) { values[count++ % kKept] = value; }
    [[nodiscard]] std::vector<double> copy() const;
  };

  std::mutex mutex_;
  Ring work_ms_;
  Ring latency_ms_;
  std::uint64_t done_{0};
  std::uint64_t failed_{0};
  std::uint64_t done_at_report_{0};
  ros::WallTime last_report_{ros::WallTime::now()};
  std::string error_;  ///< of the last item; empty when it went well
};

}  // namespace extperfc::ros_health
