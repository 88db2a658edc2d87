#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/definition_store.hpp"
#include "extperfc/translate/event_loop.hpp"
#include "extperfc/translate/peer.hpp"
#include "extperfc/translate/plan.hpp"
#include "extperfc/translate/rules.hpp"

/// A bridge between two masters: topics, services and parameters of one side appear on the other, converted
/// where the definitions differ.
namespace extperfc::translate {

/// The two sides that a bridge joins: the robot and the workstation.
enum class Side : std::uint8_t { kRobot = 0, kWorkstation = 1 };
[[nodiscard]] constexpr Side other(Side side) {
  return side == Side::kRobot ? Side::kWorkstation : Side::kRobot;
}
[[nodiscard]] const char* to_string(Side side);  ///< "robot", "workstation"

enum class Directions : std::uint8_t { kBoth, kRobotToWorkstation, kWorkstationToRobot };

/// Which names are bridged: those that an `allow` expression matches completely and no `deny` expression
/// matches (ECMAScript regular expressions over absolute names).
struct NameFilter {
  std::vector<std::string> allow;
  std::vector<std::string> deny;
};

/// Transport settings of the topics that match. The first matching entry applies.
struct TopicProfile {
  std::string pattern;  ///< regular expression over the whole name
  Directions directions{Directions::kBoth};
  std::size_t queue{10};  ///< messages per subscriber, drop-oldest
  double max_rate_hz{0};  ///< 0: no limit
  double max_age_s{0};    ///< messages that waited longer are dropped; 0: no limit
  Priority priority{Priority::kNormal};
  bool tcp_nodelay{true};
  bool lazy{true};  ///< subscribe on one side only while the other has subscribers
  PlanOptions::Slash frame_slash{PlanOptions::Slash::kKeep};
};

struct SideParams {
  PeerParams peer;
  /// Definition sets in which this side's definition of a type is looked up, in order; for subscribers that
  /// accept any MD5 (rosbag) and for types that no connection has defined yet.
  std::vector<std::string> definitions;
};

struct ClockParams {
  bool shift_stamps{false};  ///< add the measured offset to every `time` field
  /// Topics of the robot whose first field is a Header. The smallest (receive time - stamp) of a window is
  /// the offset plus the shortest delay.
  std::vector<std::string> reference_topics;
  std::string ntp_server;  ///< SNTP host on the robot's network; preferred to topics; empty: not used
  std::uint16_t ntp_port{123};
  double window_s{10.0};
  double report_above_s{0.1};  ///< diagnostics warn above
};

struct BridgeParams {
  std::array<SideParams, 2> sides;  ///< by Side
  double poll_period_s{1.0};        ///< period of reading the masters' graphs
  NameFilter topics, services;
  std::vector<TopicProfile> profiles;  ///< topics without a match use TopicProfile's defaults
  std::vector<std::string> params_robot_to_workstation,
      params_workstation_to_robot;  ///< prefixes; none by default
  bool clock{false};                ///< bridge /clock, in this direction only
  Directions clock_direction{Directions::kRobotToWorkstation};
  bool rosout{true};                 ///< bridge /rosout from the robot to the workstation
  std::uint8_t rosout_min_level{4};  ///< rosgraph_msgs/Log: 1 debug, 2 info, 4 warn, 8 error, 16 fatal
  double service_timeout_s{60.0};
  double schema_patience_s{3.0};  ///< how long a subscriber waits for the publisher's definition
  ClockParams clocks;
};

/// One topic in one direction, for diagnostics.
struct TopicStatus {
  std::string topic;
  Side from{Side::kRobot};
  struct Target {
    std::string type, md5;
    std::string plan;  ///< "pass", "convert", or the reason why there is no plan
    std::size_t subscribers{0};
  };
  std::string from_type, from_md5;
  std::vector<Target> to;
  std::size_t publishers{0};
  std::uint64_t messages{0}, bytes{0};
  std::uint64_t dropped{0};  ///< queue, age and rate limit
  std::uint64_t failed{0};   ///< could not be converted
  double rate_hz{0};
  double latency_mean_s{0},
      latency_max_s{0};  ///< from the last byte received to the send queue's first write
  std::string action;    ///< name of the action it belongs to, or empty
  std::string problem;   ///< the latest; empty when all is well
};

struct ServiceStatus {
  std::string service;
  Side from{Side::kRobot};  ///< where the server is
  std::string type, md5, plan, problem;
  std::uint64_t calls{0}, failed{0};
  double latency_mean_s{0};
};

struct BridgeStatus {
  struct SideStatus {
    std::string master_uri, uri, problem;
    bool reachable{false};
    std::uint64_t restarts{0};
    std::size_t topics{0}, services{0};
  };
  std::array<SideStatus, 2> sides;
  std::vector<TopicStatus> topics;
  std::vector<ServiceStatus> services;
  std::size_t params{0};
  struct Clock {
    bool known{false};
    double offset_s{0};  ///< the robot's clock minus the workstation's
    std::string source;  ///< "ntp host", "topic /robot/joint_states"
    double age_s{0};
    std::string problem;  ///< of a reference topic; empty when all is well
  } clock;
};

/// The bridge, on one event loop. Construct it, run the loop, and destroy it on the loop's thread after the
/// loop has ended.
class Bridge {
 public:
  struct Handlers {
    std::function<void(const std::string& line)> on_log;      ///< information for the user
    std::function<void(const std::string& line)> on_problem;  ///< problems for the user, each reported once
    std::function<void()>
        on_shutdown;  ///< `rosnode kill` of one of the bridge's nodes, or another node took its name
  };
  /// Checks parameters (regular expressions, URIs, sets), opens ports. The masters need not be running yet.
  [[nodiscard]] static Result<std::unique_ptr<Bridge>> make(EventLoop& loop, BridgeParams params,
                                                            DefinitionStore definitions, RuleSet rules,
                                                            Handlers handlers);
  virtual ~Bridge() = default;

  [[nodiscard]] virtual BridgeStatus status() = 0;
  /// Takes other rules: every plan is compiled again, and refused subscribers are invited again.
  virtual void replace_rules(RuleSet rules) = 0;
  /// Unregisters on both sides, then `done`.
  virtual void shut_down(std::chrono::milliseconds patience, std::function<void()> done) = 0;
};

}  // namespace extperfc::translate
