#pragma once

#include <functional>
#include <string>

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>

namespace extperfc::ros_health {

/// Publishes what a nodelet says about itself on /diagnostics: soon after start(), then every
/// `~diagnostic_period` [s of wall time], 1 by default, at least 0.01. A change counts from the next report
/// on.
///
/// By wall time, because diagnostic_updater's own update() counts by ros time: it is silent while a
/// simulation stands still, and after a bag began again until the old time is reached.
class Reporter {
 public:
  /// Runs in the node handle's callback queue.
  using Report = std::function<void(diagnostic_updater::DiagnosticStatusWrapper&)>;

  Reporter(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle, const std::string& name,
           const std::string& hardware_id = "none");
  /// No report runs any more behind it.
  ~Reporter();
  Reporter(const Reporter&) = delete;
  Reporter& operator=(const Reporter&) = delete;

  /// A separate status; before start().
  void add(const std::string& name, const Report& report) { updater_.add(name, report); }
  void start() { timer_.start(); }

 private:
  void report();

  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
};

}  // namespace extperfc::ros_health
