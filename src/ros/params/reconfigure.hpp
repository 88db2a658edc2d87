#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include <XmlRpcValue.h>
#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"

#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

/// A parameter that may change while the node runs.
struct DynamicParam {
  std::string name;
  std::string text;                  ///< for the tool's user
  std::vector<std::string> choices;  ///< of a text; empty: any text
};

/// Lets rqt_reconfigure and dynparam (ROS package dynamic_reconfigure) change parameters of a running
/// nodelet.
///
/// Types, ranges and first values are those that the node's ParamReader found, so they stand in one place. A
/// change is written to the parameter server, and `apply` reads it as at the start. Where `apply` fails, or
/// the request itself is wrong, everything stays as it was: the reason is logged and kept for diagnostics,
/// and the answer has the old values. Values out of their range are refused, not clamped.
///
/// Services:
///   ~set_parameters  dynamic_reconfigure/Reconfigure
/// Publishes (latched):
///   ~parameter_descriptions  dynamic_reconfigure/ConfigDescription
///   ~parameter_updates       dynamic_reconfigure/Config
/// Threads: `apply` runs in the node handle's callback queue.
class Reconfigure {
 public:
  /// Reads the parameters again and takes them over; must not throw.
  using Apply = std::function<Result<void>()>;

  /// `read` is what the reader found; each of `params` must be in it.
  Reconfigure(const ros::NodeHandle& private_handle, const std::vector<ReadParam>& read,
              const std::vector<DynamicParam>& params, Apply apply);
  Reconfigure(const Reconfigure&) = delete;
  Reconfigure& operator=(const Reconfigure&) = delete;

  /// Why the last change was refused; empty when it was not.
  [[nodiscard]] std::string last_refusal() const;

 private:
  using Values = std::map<std::string, XmlRpc::XmlRpcValue>;

  bool serve(dynamic_reconfigure::Reconfigure::Request& request,
             dynamic_reconfigure::Reconfigure::Response& response);
  [[nodiscard]] Result<Values> wanted(const dynamic_reconfigure::Config& config) const;
  Result<void> change(const Values& wanted);
  void store(const Values& values) const;
  [[nodiscard]] dynamic_reconfigure::ConfigDescription describe(
      const std::vector<ReadParam>& read, const std::vector<DynamicParam>& params) const;

  ros::NodeHandle handle_;
  Apply apply_;
  Values values_;  // in force
  mutable std::mutex mutex_;
  std::string last_refusal_;
  ros::Publisher descriptions_;
  ros::Publisher updates_;
  ros::ServiceServer server_;
};

}  // namespace extperfc::ros_params
