#include "ros/translate/bridge_diagnostics.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

namespace extperfc::ros_translate {

namespace {

using diagnostic_msgs::DiagnosticArray;
using diagnostic_msgs::DiagnosticStatus;
using translate::BridgeStatus;
using translate::ServiceStatus;
using translate::Side;
using translate::TopicStatus;

std::string number(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

std::string milliseconds_text(double seconds) {
  return number(1e3 * seconds, 3);
}

std::string short_md5(const std::string& md5) {
  constexpr std::size_t kDigits = 8;
  return md5.empty() ? "?" : md5.substr(0, kDigits);
}

std::string direction(Side from) {
  return std::string(translate::to_string(from)) + " to " + translate::to_string(translate::other(from));
}

void add(DiagnosticStatus& status, const std::string& key, std::string value) {
  diagnostic_msgs::KeyValue pair;
  pair.key = key;
  pair.value = std::move(value);
  status.values.push_back(std::move(pair));
}

/// The highest level counts; messages of one level are joined.
void merge(DiagnosticStatus& status, std::uint8_t level, const std::string& message) {
  const auto present = static_cast<std::uint8_t>(status.level);
  if (level > present) {
    status.level = static_cast<DiagnosticStatus::_level_type>(level);
    status.message = message;
  } else if (level == present && level != DiagnosticStatus::OK) {
    status.message += "; " + message;
  }
}

bool works(const std::string& plan) {
  return plan == "pass" || plan == "convert";
}

std::string problem_of(const TopicStatus& topic) {
  if (!topic.problem.empty()) return topic.problem;
  if (topic.publishers == 0) return {};  // plans are compiled when there is a publisher
  for (const auto& target : topic.to)
    if (!works(target.plan))
      return "no plan to " + target.type + " " + short_md5(target.md5) + ": " + target.plan;
  return {};
}

std::string problem_of(const ServiceStatus& service) {
  if (!service.problem.empty()) return service.problem;
  return service.plan.empty() || works(service.plan) ? "" : service.plan;
}

/// "pass", "convert", "pass, convert" with several definitions; "idle" without subscribers.
std::string plans_of(const TopicStatus& topic) {
  std::vector<std::string> plans;
  for (const auto& target : topic.to) plans.push_back(works(target.plan) ? target.plan : "none");
  std::sort(plans.begin(), plans.end());
  plans.erase(std::unique(plans.begin(), plans.end()), plans.end());
  std::string all;
  for (const auto& plan : plans) all += (all.empty() ? "" : ", ") + plan;
  return all.empty() ? "idle" : all;
}

void add_side(DiagnosticStatus& status, const BridgeStatus& bridge, Side side) {
  const auto& one = bridge.sides[static_cast<std::size_t>(side)];
  const std::string label = std::string(translate::to_string(side)) + " side ";
  add(status, label + "master", one.master_uri);
  add(status, label + "reachable", one.reachable ? "yes" : "no");
  add(status, label + "restarts", std::to_string(one.restarts));
  add(status, label + "our address", one.uri);
  add(status, label + "bridged topics", std::to_string(one.topics));
  add(status, label + "bridged services", std::to_string(one.services));
  if (!one.reachable)
    merge(status, DiagnosticStatus::ERROR,
          label + "master " + one.master_uri + " is not reachable" +
              (one.problem.empty() ? "" : ": " + one.problem));
}

void add_clock(DiagnosticStatus& status, const BridgeStatus::Clock& clock, const ReportParams& params) {
  if (!clock.problem.empty()) merge(status, DiagnosticStatus::WARN, clock.problem);
  if (!clock.known) {
    add(status, "clock offset [s]", "not known");
    add(status, "stamps", params.shift_stamps ? "not shifted yet" : "not shifted");
    if (params.shift_stamps)
      merge(status, DiagnosticStatus::WARN, "stamps are not shifted yet: the clock offset is not known");
    return;
  }
  add(status, "clock offset [s]", number(clock.offset_s, 6));
  add(status, "clock source", clock.source);
  add(status, "clock age [s]", number(clock.age_s, 1));
  add(status, "stamps", params.shift_stamps ? "shifted" : "not shifted");
  if (params.shift_stamps || std::abs(clock.offset_s) <= params.offset_warn_s) return;
  merge(status, DiagnosticStatus::WARN,
        "the robot's clock is " + number(std::abs(clock.offset_s), 3) + " s " +
            (clock.offset_s > 0 ? "ahead" : "behind") +
            " and stamps are not shifted: set the clock, or clocks/shift_stamps");
}

template <typename T>
std::size_t problems_in(const std::vector<T>& items) {
  return static_cast<std::size_t>(
      std::count_if(items.begin(), items.end(), [](const T& item) { return !problem_of(item).empty(); }));
}

/// Those with a problem first, otherwise in their order.
template <typename T>
std::vector<const T*> worst_first(const std::vector<T>& items) {
  std::vector<const T*> order;
  order.reserve(items.size());
  for (const auto& item : items) order.push_back(&item);
  std::stable_partition(order.begin(), order.end(), [](const T* item) { return !problem_of(*item).empty(); });
  return order;
}

std::string row(const TopicStatus& topic) {
  char text[160];
  std::snprintf(
      text, sizeof text, "  %-20s %-8s %8.1f Hz  %8.3f ms mean %8.3f ms max %8llu dropped %6llu failed  ",
      direction(topic.from).c_str(), plans_of(topic).c_str(), topic.rate_hz, 1e3 * topic.latency_mean_s,
      1e3 * topic.latency_max_s, static_cast<unsigned long long>(topic.dropped),
      static_cast<unsigned long long>(topic.failed));
  const auto problem = problem_of(topic);
  return text + topic.topic + " [" + topic.from_type + " " + short_md5(topic.from_md5) + "]" +
         (problem.empty() ? "" : "  PROBLEM: " + problem) + "\n";
}

std::string row(const ServiceStatus& service) {
  const auto problem = problem_of(service);
  return "  server on the " + std::string(translate::to_string(service.from)) + " side  " +
         std::to_string(service.calls) + " calls, " + std::to_string(service.failed) + " failed, " +
         milliseconds_text(service.latency_mean_s) + " ms mean  " + service.service + " [" + service.type +
         " " + short_md5(service.md5) + "]" + (problem.empty() ? "" : "  PROBLEM: " + problem) + "\n";
}

}  // namespace

DiagnosticStatus link_status(const BridgeStatus& status, const ReportParams& params) {
  DiagnosticStatus link;
  link.name = params.node + ": link";
  link.hardware_id = status.sides[static_cast<std::size_t>(Side::kRobot)].master_uri;
  link.message = "both masters answer";
  for (const auto side : {Side::kRobot, Side::kWorkstation}) add_side(link, status, side);
  add_clock(link, status.clock, params);
  const auto troubled = problems_in(status.topics) + problems_in(status.services);
  const auto all = status.topics.size() + status.services.size();
  add(link, "topics and services", std::to_string(all));
  add(link, "with a problem", std::to_string(troubled));
  add(link, "not shown one by one", std::to_string(all - std::min(all, params.max_items)));
  add(link, "bridged parameters", std::to_string(status.params));
  if (troubled > 0)
    merge(link, DiagnosticStatus::WARN,
          std::to_string(troubled) +
              (troubled == 1 ? " topic or service has a problem" : " topics or services have a problem"));
  return link;
}

DiagnosticStatus topic_status(const TopicStatus& topic, const ReportParams& params) {
  DiagnosticStatus status;
  status.name = params.node + ": topic " + topic.topic + ", " + direction(topic.from);
  status.message = plans_of(topic);
  if (const auto problem = problem_of(topic); !problem.empty())
    merge(status, DiagnosticStatus::WARN, problem);
  add(status, "from", topic.from_type + " " + short_md5(topic.from_md5));
  for (const auto& target : topic.to)
    add(status, "to " + target.type + " " + short_md5(target.md5),
        target.plan + ", subscribers: " + std::to_string(target.subscribers));
  add(status, "publishers", std::to_string(topic.publishers));
  add(status, "rate [Hz]", number(topic.rate_hz, 1));
  add(status, "latency mean [ms]", milliseconds_text(topic.latency_mean_s));
  add(status, "latency max [ms]", milliseconds_text(topic.latency_max_s));
  add(status, "messages", std::to_string(topic.messages));
  add(status, "bytes", std::to_string(topic.bytes));
  add(status, "dropped", std::to_string(topic.dropped));
  add(status, "failed", std::to_string(topic.failed));
  if (!topic.action.empty()) add(status, "action", topic.action);
  return status;
}

DiagnosticStatus service_status(const ServiceStatus& service, const ReportParams& params) {
  DiagnosticStatus status;
  status.name = params.node + ": service " + service.service;
  status.message = service.plan.empty() ? "idle" : service.plan;
  if (const auto problem = problem_of(service); !problem.empty())
    merge(status, DiagnosticStatus::WARN, problem);
  add(status, "server", std::string(translate::to_string(service.from)) + " side");
  add(status, "type", service.type + " " + short_md5(service.md5));
  add(status, "calls", std::to_string(service.calls));
  add(status, "failed", std::to_string(service.failed));
  add(status, "latency mean [ms]", milliseconds_text(service.latency_mean_s));
  return status;
}

DiagnosticArray to_diagnostics(const BridgeStatus& status, const ReportParams& params, const ros::Time& stamp,
                               bool details) {
  DiagnosticArray report;
  report.header.stamp = stamp;
  report.status.push_back(link_status(status, params));
  if (!details) return report;
  std::vector<DiagnosticStatus> items;
  for (const auto* topic : worst_first(status.topics)) {
    if (items.size() == params.max_items) break;
    items.push_back(topic_status(*topic, params));
  }
  for (const auto* service : worst_first(status.services)) items.push_back(service_status(*service, params));
  std::stable_partition(items.begin(), items.end(),
                        [](const auto& item) { return item.level != DiagnosticStatus::OK; });
  if (items.size() > params.max_items) items.resize(params.max_items);
  std::move(items.begin(), items.end(), std::back_inserter(report.status));
  return report;
}

std::string to_text(const BridgeStatus& status, ReportParams params) {
  params.max_items = status.topics.size() + status.services.size();  // all are shown one by one
  const auto link = link_status(status, params);
  std::string text = "link: " + link.message + "\n";
  for (const auto& value : link.values) text += "  " + value.key + ": " + value.value + "\n";
  text += "topics:\n";
  for (const auto* topic : worst_first(status.topics)) text += row(*topic);
  text += "services:\n";
  for (const auto* service : worst_first(status.services)) text += row(*service);
  return text;
}

}  // namespace extperfc::ros_translate
