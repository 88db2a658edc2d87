#pragma once

#include <initializer_list>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <XmlRpcException.h>
#include <XmlRpcValue.h>
#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"

#include "ros/params/param_reader.hpp"

/// Parameters that are names of values, lists of texts, or lists of groups.
namespace extperfc::ros_params {

/// Values by the names that stand for them in parameters.
template <typename T>
using NamedValues = std::map<std::string, T>;
/// The value of a name, or an error with those that there are.
template <typename T>
Result<T> meaning(const std::string& name, const NamedValues<T>& values) {
  if (const auto found = values.find(name); found != values.end()) return found->second;
  std::string known;
  for (const auto& entry : values) known += (known.empty() ? "" : ", ") + entry.first;
  return fail(ErrorCode::kInvalidArgument, "'" + name + "' is unknown: use one of " + known);
}

template <typename T>
void read_named(ParamReader& reader, const ros::NodeHandle& handle, const std::string& key, T& value,
                const NamedValues<T>& values) {
  std::string name;
  reader.read(key, name);
  if (name.empty()) return;
  if (const auto found = meaning(name, values))
    value = *found;
  else
    reader.complain(handle.resolveName(key) + ": " + found.error().message);
}

inline void read_strings(ParamReader& reader, const ros::NodeHandle& handle, const std::string& key,
                         std::vector<std::string>& value) {
  reader.accept(key);
  if (handle.hasParam(key) && !handle.getParam(key, value))
    reader.complain(handle.resolveName(key) + " must be a list of texts");
}

inline std::string concatenated(std::initializer_list<std::string_view> parts) {
  std::string text;
  for (const auto part : parts) text += part;
  return text;
}

inline void check_expressions(ParamReader& reader, const std::string& where,
                              const std::vector<std::string>& expressions) {
  for (const auto& expression : expressions) {
    try {
      (void)std::regex(expression);
    } catch (const std::regex_error& error) {
      reader.complain(
          concatenated({where, ": '", expression, "' is no regular expression (", error.what(), ")"}));
    }
  }
}

/// One value of an entry of a list.
class Entry {
 public:
  explicit Entry(XmlRpc::XmlRpcValue& value) : value_(value) {}

  [[nodiscard]] std::string text() const { return static_cast<std::string>(value_); }
  [[nodiscard]] bool flag() const { return static_cast<bool>(value_); }
  [[nodiscard]] Result<double> number(Range<double> range) const {
    const double given = value_.getType() == XmlRpc::XmlRpcValue::TypeInt ? static_cast<int>(value_)
                                                                          : static_cast<double>(value_);
    if (given >= range.low && given <= range.high) return given;
    std::ostringstream problem;
    problem << given << " is out of its range [" << range.low << ", " << range.high << "]";
    return fail(ErrorCode::kInvalidArgument, problem.str());
  }

 private:
  XmlRpc::XmlRpcValue& value_;
};

/// Reads values by free labels, each given by its name, e.g. {cup: cylinder}.
template <typename T>
void read_named_by_label(ParamReader& reader, const ros::NodeHandle& handle, const std::string& key,
                         std::map<std::string, T>& values, const NamedValues<T>& names) {
  reader.accept(key);
  XmlRpc::XmlRpcValue given;
  if (!handle.getParam(key, given)) return;
  const auto place = handle.resolveName(key);
  if (given.getType() == XmlRpc::XmlRpcValue::TypeArray && given.size() == 0) return;
  if (given.getType() != XmlRpc::XmlRpcValue::TypeStruct)
    return reader.complain(concatenated(
        {place, " must be a group of labels and names, e.g. {label: ", names.begin()->first, "}"}));
  for (auto& [label, name] : given) {
    const bool text = name.getType() == XmlRpc::XmlRpcValue::TypeString;
    if (const auto value = meaning(text ? Entry(name).text() : "", names))
      values[label] = *value;
    else
      reader.complain(concatenated({place, "/", label, ": ", value.error().message}));
  }
}

/// Reads a list of groups; `set(item, key, entry)` takes one key. Every problem is reported with its place.
template <typename T, typename Set>
std::vector<T> read_list(ParamReader& reader, const ros::NodeHandle& handle, const std::string& key,
                         Set set) {
  std::vector<T> items;
  reader.accept(key);
  XmlRpc::XmlRpcValue list;
  if (!handle.getParam(key, list)) return items;
  const auto name = handle.resolveName(key);
  if (list.getType() != XmlRpc::XmlRpcValue::TypeArray) {
    reader.complain(name + " must be a list");
    return items;
  }
  for (int i = 0; i < list.size(); ++i) {
    const auto place = name + "[" + std::to_string(i) + "]";
    T item;
    if (list[i].getType() != XmlRpc::XmlRpcValue::TypeStruct) {
      reader.complain(place + " must be a group of keys and values");
      continue;
    }
    for (auto& [entry_key, value] : list[i]) {
      try {
        if (const auto done = set(item, entry_key, Entry(value)); !done)
          reader.complain(concatenated({place, "/", entry_key, ": ", done.error().message}));
      } catch (const XmlRpc::XmlRpcException&) {
        reader.complain(concatenated({place, "/", entry_key, " has a value of a wrong type"}));
      }
    }
    items.push_back(std::move(item));
  }
  return items;
}

}  // namespace extperfc::ros_params
