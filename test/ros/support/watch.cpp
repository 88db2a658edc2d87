#include "test/ros/support/watch.hpp"

#include <array>
#include <cstdio>
#include <cstdlib>

namespace extperfc::ros_test {

Report::Report(const diagnostic_msgs::DiagnosticStatus& status)
    : level_(status.level), message_(status.message) {
  for (const auto& pair : status.values) values_[pair.key] = pair.value;
}

std::string Report::value(const std::string& key) const {
  const auto found = values_.find(key);
  return found == values_.end() ? "" : found->second;
}

long Report::number(const std::string& key) const {
  const auto text = value(key);
  return text.empty() ? -1 : std::strtol(text.c_str(), nullptr, 10);
}

bool Report::is_error_about(const std::string& text) const {
  return level_ == diagnostic_msgs::DiagnosticStatus::ERROR && message_.find(text) != std::string::npos;
}

bool Report::is_warning_about(const std::string& text) const {
  return level_ == diagnostic_msgs::DiagnosticStatus::WARN && message_.find(text) != std::string::npos;
}

std::vector<Report> DiagnosticsWatch::all() const {
  std::vector<Report> reports;
  for (const auto& array : inbox_.all())
    for (const auto& status : array->status)
      if (status.name.rfind(node_ + ": ", 0) == 0) reports.emplace_back(status);
  return reports;
}

Report DiagnosticsWatch::latest() const {
  const auto reports = all();
  return reports.empty() ? Report() : reports.back();
}

bool DiagnosticsWatch::wait(const std::function<bool(const Report&)>& condition) const {
  return wait_for([&] {
    for (const auto& report : all())
      if (condition(report)) return true;
    return false;
  });
}

bool DiagnosticsWatch::wait_latest(const std::function<bool(const Report&)>& condition) const {
  return wait_for([&] { return condition(latest()); });
}

bool DiagnosticsWatch::goes_on() {
  constexpr std::size_t kSeveral = 5;  // more than can be on their way
  forget();
  return wait_for([&] { return all().size() >= kSeveral; });
}

std::map<std::string, std::string> DiagnosticsWatch::addresses(const std::string& key) const {
  std::map<std::string, std::string> gathered;
  for (const auto& report : all()) {
    const auto text = report.value(key);
    const auto at = text.find(" @ ");
    if (at == std::string::npos || text.rfind("0.", 0) == 0) continue;  // nothing arrived yet
    gathered[text.substr(0, at)] = text.substr(at + 3);
  }
  return gathered;
}

std::size_t LogWatch::count(const std::string& text) const {
  std::size_t lines = 0;
  for (const auto& line : inbox_.all())
    if (line->level >= rosgraph_msgs::Log::WARN && line->msg.find(text) != std::string::npos) ++lines;
  return lines;
}

std::string LogWatch::text() const {
  std::string all;
  for (const auto& line : inbox_.all())
    if (line->level >= rosgraph_msgs::Log::WARN) all += line->name + ": " + line->msg + "\n";
  return all.empty() ? "(nothing was logged)" : all;
}

std::string stamp_text(const ros::Time& stamp) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%u.%09u", stamp.sec, stamp.nsec);
  return text.data();
}

std::string address_text(const void* data) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%p", data);
  return text.data();
}

}  // namespace extperfc::ros_test
