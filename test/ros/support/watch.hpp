#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <rosgraph_msgs/Log.h>

#include "test/ros/support/inbox.hpp"

namespace extperfc::ros_test {

/// What one nodelet said about itself once.
class Report {
 public:
  Report() = default;
  explicit Report(const diagnostic_msgs::DiagnosticStatus& status);

  [[nodiscard]] int level() const { return level_; }
  [[nodiscard]] const std::string& message() const { return message_; }
  /// The value of a key; empty when there is none.
  [[nodiscard]] std::string value(const std::string& key) const;
  [[nodiscard]] long number(const std::string& key) const;
  [[nodiscard]] bool is_error_about(const std::string& text) const;
  [[nodiscard]] bool is_warning_about(const std::string& text) const;

 private:
  int level_{-1};
  std::string message_;
  std::map<std::string, std::string> values_;
};

/// The diagnostics of one nodelet, by its node's name (without the leading slash).
class DiagnosticsWatch {
 public:
  explicit DiagnosticsWatch(std::string node) : node_(std::move(node)) {}

  [[nodiscard]] std::vector<Report> all() const;
  [[nodiscard]] Report latest() const;
  /// True as soon as a report meets the condition, old ones included.
  [[nodiscard]] bool wait(const std::function<bool(const Report&)>& condition) const;
  /// As wait(), but of the latest report only.
  [[nodiscard]] bool wait_latest(const std::function<bool(const Report&)>& condition) const;
  /// True when reports keep coming: several from now on. Forgets those before.
  [[nodiscard]] bool goes_on();
  void forget() { inbox_.clear(); }

  /// What a report says under `key`, "<stamp> @ <address>", gathered as stamp -> address.
  [[nodiscard]] std::map<std::string, std::string> addresses(const std::string& key) const;

 private:
  std::string node_;
  Inbox<diagnostic_msgs::DiagnosticArray> inbox_{"/diagnostics"};
};

/// What is logged to /rosout.
class LogWatch {
 public:
  /// Number of lines with `text` in them, at WARN or above.
  [[nodiscard]] std::size_t count(const std::string& text) const;
  [[nodiscard]] bool wait(const std::string& text) const {
    return wait_for([&] { return count(text) > 0; });
  }
  /// Everything at WARN or above, for a failing test's message.
  [[nodiscard]] std::string text() const;
  void forget() { inbox_.clear(); }

 private:
  Inbox<rosgraph_msgs::Log> inbox_{"/rosout"};
};

/// "<stamp> @ <address>" as diagnostics write it.
[[nodiscard]] std::string stamp_text(const ros::Time& stamp);
[[nodiscard]] std::string address_text(const void* data);

}  // namespace extperfc::ros_test
