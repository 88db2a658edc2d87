#pragma once

#include <cstddef>
#include <string>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/time.h>

#include "extperfc/translate/bridge.hpp"

/// A bridge's status as diagnostics and as text. Pure functions.
namespace extperfc::ros_translate {

struct ReportParams {
  std::string node;  ///< its name; statuses are "<node>: link", "<node>: topic /x, robot to workstation", ...
  double offset_warn_s{0.1};  ///< WARN when the clocks differ by more and stamps are not shifted
  bool shift_stamps{false};
  std::size_t max_items{200};  ///< topics and services in a report; those with problems first
};

/// The link as a whole. ERROR while a master cannot be reached; WARN when a topic or service has a
/// problem, or the clocks differ.
[[nodiscard]] diagnostic_msgs::DiagnosticStatus link_status(const translate::BridgeStatus& status,
                                                            const ReportParams& params);
/// One topic in one direction: types, MD5s (their first 8 digits), plan, rate, latency, drops, failures. WARN
/// when there is no plan, or a problem.
[[nodiscard]] diagnostic_msgs::DiagnosticStatus topic_status(const translate::TopicStatus& topic,
                                                             const ReportParams& params);
[[nodiscard]] diagnostic_msgs::DiagnosticStatus service_status(const translate::ServiceStatus& service,
                                                               const ReportParams& params);

/// The link, and with `details` the topics and services: up to ReportParams::max_items, problems first, then
/// by name.
[[nodiscard]] diagnostic_msgs::DiagnosticArray to_diagnostics(const translate::BridgeStatus& status,
                                                              const ReportParams& params,
                                                              const ros::Time& stamp, bool details);

/// All of it as lines for a terminal.
[[nodiscard]] std::string to_text(const translate::BridgeStatus& status, ReportParams params);

}  // namespace extperfc::ros_translate
