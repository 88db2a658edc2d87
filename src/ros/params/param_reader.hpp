#pragma once

#include <map>
#include <string>
#include <vector>

#include <XmlRpcValue.h>
#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"

namespace extperfc::ros_params {

/// Inclusive range of a number.
template <typename T>
struct Range {
  T low;
  T high;
};

/// A parameter that was read, for those who describe it to a user.
struct ReadParam {
  std::string name;
  XmlRpc::XmlRpcValue value;      ///< in force: the given one, or the default
  XmlRpc::XmlRpcValue low, high;  ///< range of a number; both values of a bool; empty texts
};

/// Reads the parameters of one private namespace and collects everything that is wrong with them, so that a
/// user sees all errors at once: wrong types, values out of range, unknown keys.
class ParamReader {
 public:
  explicit ParamReader(const ros::NodeHandle& private_handle);

  /// Each leaves `value` (the default) alone when the key is not set.
  void read(const std::string& key, std::string& value);
  void read(const std::string& key, bool& value);
  void read(const std::string& key, int& value, Range<int> range);
  void read(const std::string& key, double& value, Range<double> range);

  /// The name of a frame, not empty; without the slash that tf's first version wrote before it.
  void read_frame(const std::string& key, std::string& frame);

  /// As read(), but an unset key is an error that ends with `remedy`.
  void require(const std::string& key, std::string& value, const std::string& remedy);

  /// A key that others may set here (image_transport's, for instance).
  void accept(const std::string& key) { known_.push_back(key); }

  /// Adds an error found by the caller, e.g. of two values that do not fit each other.
  void complain(const std::string& message) { errors_.push_back(message); }

  /// What read() was asked for so far, in this order.
  [[nodiscard]] const std::vector<ReadParam>& params() const { return params_; }

  /// Success, or one error whose text has a line per problem. Call once, last.
  [[nodiscard]] Result<void> finish();

 private:
  const XmlRpc::XmlRpcValue* find(const std::string& key);
  void wrong_type(const std::string& key, const char* wanted);
  void read_text(const std::string& key, std::string& value);
  void read_flag(const std::string& key, bool& value);
  template <typename T>
  void read_number(const std::string& key, T& value, Range<T> range);

  std::string ns_;
  std::map<std::string, XmlRpc::XmlRpcValue> given_;
  std::vector<std::string> known_{"diagnostic_period", "diagnostic_updater"};  // the updater's own
  std::vector<std::string> errors_;
  std::vector<ReadParam> params_;
};

}  // namespace extperfc::ros_params
