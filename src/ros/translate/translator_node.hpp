#pragma once

#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/bridge.hpp"
#include "extperfc/translate/event_loop.hpp"

#include "ros/params/translator_params.hpp"
#include "ros/translate/bridge_diagnostics.hpp"

namespace extperfc::ros_translate {

/// Bridges the ROS 1 masters of a robot and of a workstation, and converts messages, services and actions
/// whose definitions differ. Bridged messages do not pass through roscpp: the bridge has separate nodes at
/// both masters (parameters robot/name and workstation/name).
///
/// Publishes:
///   diagnostics  diagnostic_msgs/DiagnosticArray
/// Services:
///   ~status        std_srvs/Trigger: the content of the diagnostics, as text
///   ~reload_rules  std_srvs/Trigger: reads the rule files again and compiles every plan again; an invalid
///                  rule changes nothing
/// Parameters: config/translator.yaml. A robot's settings are loaded after it, see config/robots.
/// Frames: none; with clocks/shift_stamps the stamps of bridged messages are shifted.
/// Diagnostics: "link" (both masters, restarts, clock offset): ERROR while a master is away; one status for
///   each topic and direction, and each service: WARN when it cannot be converted.
/// Threads: the bridge's event loop has one; reports and services run in the caller's spinner and ask it.
class TranslatorNode {
 public:
  /// Reads definitions and rules, opens the bridge's ports. The robot's master need not be running.
  [[nodiscard]] static Result<std::unique_ptr<TranslatorNode>> make(const ros::NodeHandle& handle,
                                                                    const ros::NodeHandle& private_handle,
                                                                    ros_params::TranslatorParams params);
  ~TranslatorNode();
  TranslatorNode(const TranslatorNode&) = delete;
  TranslatorNode& operator=(const TranslatorNode&) = delete;

  /// Starts the bridge's thread and the reports.
  void start();
  /// Unregisters on both sides and ends the thread; a master that does not answer is waited for no longer
  /// than shut_down_patience_s.
  void shut_down();

 private:
  using Trigger = std_srvs::Trigger;

  TranslatorNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                 ros_params::TranslatorParams params);
  [[nodiscard]] Result<void> open();
  [[nodiscard]] std::optional<translate::BridgeStatus> fetch_status();
  void offer();
  void offer_again();
  void report();
  bool on_status(Trigger::Request& request, Trigger::Response& response);
  bool on_reload_rules(Trigger::Request& request, Trigger::Response& response);

  ros::NodeHandle handle_;
  ros::NodeHandle private_handle_;
  ros_params::TranslatorParams params_;
  ReportParams report_params_;
  translate::EventLoop loop_;
  std::unique_ptr<translate::Bridge> bridge_;  ///< of the loop's thread once that runs
  std::thread thread_;
  ros::Publisher diagnostics_;
  ros::WallTimer timer_;
  ros::ServiceServer status_service_;
  ros::ServiceServer reload_service_;
  std::optional<translate::SteadyTime> details_due_;
  std::uint64_t restarts_{0};  ///< of the home master, as far as this node has registered again
};

}  // namespace extperfc::ros_translate
