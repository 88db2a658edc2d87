#include "ros/params/param_reader.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <type_traits>

#include "extperfc/base/text.hpp"

namespace extperfc::ros_params {

namespace {

template <typename T>
std::string text_of(const T& value) {
  std::ostringstream stream;
  if constexpr (std::is_same_v<T, XmlRpc::XmlRpcValue>)
    value.write(stream);
  else
    stream << value;
  return stream.str();
}

}  // namespace

ParamReader::ParamReader(const ros::NodeHandle& private_handle) : ns_(private_handle.getNamespace()) {
  XmlRpc::XmlRpcValue all;
  if (!private_handle.getParam(ns_, all) || all.getType() != XmlRpc::XmlRpcValue::TypeStruct) return;
  for (auto& [key, value] : all) given_[key] = value;
}

const XmlRpc::XmlRpcValue* ParamReader::find(const std::string& key) {
  known_.push_back(key);
  const auto it = given_.find(key);
  return it == given_.end() ? nullptr : &it->second;
}

void ParamReader::wrong_type(const std::string& key, const char* wanted) {
  errors_.push_back(ns_ + "/" + key + " must be " + wanted + ", but is '" + text_of(given_.at(key)) + "'");
}

void ParamReader::read(const std::string& key, std::string& value) {
  read_text(key, value);
  params_.push_back({key, value, "", ""});
}

void ParamReader::read_text(const std::string& key, std::string& value) {
  const auto* found = find(key);
  if (!found) return;
  if (found->getType() != XmlRpc::XmlRpcValue::TypeString) return wrong_type(key, "a text");
  value = static_cast<std::string>(XmlRpc::XmlRpcValue(*found));
}

void ParamReader::read(const std::string& key, bool& value) {
  read_flag(key, value);
  params_.push_back({key, value, false, true});
}

void ParamReader::read_flag(const std::string& key, bool& value) {
  const auto* found = find(key);
  if (!found) return;
  if (found->getType() != XmlRpc::XmlRpcValue::TypeBoolean) return wrong_type(key, "true or false");
  value = static_cast<bool>(XmlRpc::XmlRpcValue(*found));
}

template <typename T>
void ParamReader::read_number(const std::string& key, T& value, Range<T> range) {
  const auto* found = find(key);
  if (!found) return;
  XmlRpc::XmlRpcValue copy(*found);
  T given{};
  if (copy.getType() == XmlRpc::XmlRpcValue::TypeInt) {
    given = static_cast<T>(static_cast<int>(copy));
  } else if (std::is_floating_point_v<T> && copy.getType() == XmlRpc::XmlRpcValue::TypeDouble) {
    given = static_cast<T>(static_cast<double>(copy));
  } else {
    return wrong_type(key, std::is_floating_point_v<T> ? "a number" : "a whole number");
  }
  if (!(given >= range.low && given <= range.high)) {  // NaN fails too
    errors_.push_back(ns_ + "/" + key + " = " + text_of(given) + " is out of its range [" +
                      text_of(range.low) + ", " + text_of(range.high) + "]");
    return;
  }
  value = given;
}

void ParamReader::read(const std::string& key, int& value, Range<int> range) {
  read_number(key, value, range);
  params_.push_back({key, value, range.low, range.high});
}

void ParamReader::read(const std::string& key, double& value, Range<double> range) {
  read_number(key, value, range);
  params_.push_back({key, value, range.low, range.high});
}

void ParamReader::read_frame(const std::string& key, std::string& frame) {
  read(key, frame);
  if (!frame.empty() && frame.front() == '/') frame.erase(0, 1);
  if (frame.empty()) complain(key + " must be the name of a frame, not empty");
}

void ParamReader::require(const std::string& key, std::string& value, const std::string& remedy) {
  read(key, value);
  if (given_.count(key) == 0 || value.empty()) errors_.push_back(ns_ + "/" + key + " is not set: " + remedy);
}

Result<void> ParamReader::finish() {
  for (const auto& entry : given_)
    if (std::find(known_.begin(), known_.end(), entry.first) == known_.end())
      errors_.push_back(ns_ + "/" + entry.first +
                        " is not a parameter of this nodelet; it knows: " + joined(known_));
  if (errors_.empty()) return {};
  return fail(ErrorCode::kInvalidArgument, joined(errors_, "\n  "));
}

}  // namespace extperfc::ros_params
