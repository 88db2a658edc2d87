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

/// Two masters joined: what is published, served or set on one side appears on the other, converted where the
/// definitions differ.
namespace extperfc::translate {

/// The two sides that a bridge joins: the robot and the workstation.
enum class Side : std::uint8_t { kRobot = 0, kWorkstation = 1 };
[[nodiscard]] constexpr Side other(Side side) {
  return side == Side::kRobot ? Side::kWorkstation : Side::kRobot;
}
[[nodiscard]] const char* to_string(Side side);  ///< "robot", "workstation"

enum class Directions : std::uint8_t { kBoth, kRobotToWorkstation, kWorkstationToRobot };

/// What crosses: a name crosses when an `allow` expression matches all of it and no `deny` expression does
/// (ECMAScript regular expressions over absolute names).
struct NameFilter {
  std::vector<std::string> allow;
  std::vector<std::string> deny;
};

/// How the topics that match are carried. The first entry that matches counts.
struct TopicProfile {
  std::string pattern;  ///< regular expression over the whole name
  Directions directions{Directions::kBoth};
  std::size_t queue{10};  ///< messages per subscriber, drop-oldest
  double max_rate_hz{0};  ///< 0: every message
  double max_age_s{0};    ///< a message that waited longer is dropped; 0: any age
  Priority priority{Priority::kNormal};
  bool tcp_nodelay{true};
  bool lazy{true};  ///< subscribe on one side only while somebody subscribes on the other
  PlanOptions::Slash frame_slash{PlanOptions::Slash::kKeep};
};

struct SideParams {
  PeerParams peer;
  /// Sets of the definition store in which this side's own version of a type is looked up, in order; for
  /// subscribers that take any MD5 (rosbag) and for types that nobody has told yet.
  std::vector<std::string> definitions;
};

struct ClockParams {
  bool shift_stamps{false};  ///< add the measured offset to every `time` field
  /// Topics of the robot side whose first field is a Header; the smallest (receive time - stamp) of a window
  /// is the offset plus the shortest delay.
  std::vector<std::string> reference_topics;
  std::string ntp_server;  ///< SNTP host of the robot side; preferred to topics; empty: none
  std::uint16_t ntp_port{123};
  double window_s{10.0};
  double report_above_s{0.1};  ///< diagnostics warn above
};

struct BridgeParams {
  std::array<SideParams, 2> sides;  ///< by Side
  double poll_period_s{1.0};        ///< between looks at the graphs
  NameFilter topics, services;
  std::vector<TopicProfile> profiles;  ///< what matches none has TopicProfile's defaults
  std::vector<std::string> params_robot_to_workstation,
      params_workstation_to_robot;  ///< prefixes; none by default
  bool clock{false};                ///< let /clock cross, in this direction only
  Directions clock_direction{Directions::kRobotToWorkstation};
  bool rosout{true};                 ///< let /rosout cross, robot to workstation
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
    std::string plan;  ///< "pass", "convert", or why there is none
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
    double offset_s{0};  ///< the robot's clock minus ours (the workstation side's)
    std::string source;  ///< "ntp host", "topic /robot/joint_states"
    double age_s{0};
    std::string problem;  ///< of a reference topic; empty when all is well
  } clock;
};

/// The bridge itself, on one event loop. Construct, run the loop; destroy on the loop's thread after it
/// ended.
class Bridge {
 public:
  struct Handlers {
    std::function<void(const std::string& line)> on_log;      ///< what people should know
    std::function<void(const std::string& line)> on_problem;  ///< what people should mend; each once
    std::function<void()>
        on_shutdown;  ///< `rosnode kill` of one of the bridge's nodes, or its name was taken
  };
  /// Checks parameters (regular expressions, URIs, sets), opens ports. Masters need not be there yet.
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
