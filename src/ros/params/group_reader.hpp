#pragma once

#include <string>
#include <vector>

#include <XmlRpcValue.h>
#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"

#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

/// Reads a node's namespace and the groups of parameters in it; gathers what is wrong with all of them.
class GroupReader {
 public:
  explicit GroupReader(const ros::NodeHandle& private_handle) : handle_(private_handle) {}

  /// `read(reader, handle)` reads the keys of the group `name`; "" is the namespace itself.
  template <typename Read>
  void group(const std::string& name, Read&& read) {
    if (XmlRpc::XmlRpcValue value;
        !name.empty() && handle_.getParam(name, value) && value.getType() != XmlRpc::XmlRpcValue::TypeStruct)
      complain(handle_.resolveName(name) + " must be a group of parameters");
    const ros::NodeHandle handle = name.empty() ? handle_ : ros::NodeHandle(handle_, name);
    ParamReader reader(handle);
    read(reader, handle);
    if (auto finished = reader.finish(); !finished) complain(finished.error().message);
  }

  void complain(const std::string& problem) { problems_.push_back(problem); }

  /// Success, or one error whose text has a line per problem.
  [[nodiscard]] Result<void> finish() const {
    if (problems_.empty()) return {};
    std::string all = problems_.front();
    for (std::size_t i = 1; i < problems_.size(); ++i) all += "\n  " + problems_[i];
    return fail(ErrorCode::kInvalidArgument, all);
  }

 private:
  ros::NodeHandle handle_;
  std::vector<std::string> problems_;
};

}  // namespace extperfc::ros_params
