#include "ros/params/reconfigure.hpp"

#include <stdexcept>
#include <utility>

#include <ros/console.h>

#include "extperfc/base/text.hpp"

namespace extperfc::ros_params {

namespace {

using XmlRpc::XmlRpcValue;

const char* type_name(const XmlRpcValue& value) {
  switch (value.getType()) {
    case XmlRpcValue::TypeBoolean:
      return "bool";
    case XmlRpcValue::TypeInt:
      return "int";
    case XmlRpcValue::TypeDouble:
      return "double";
    default:
      return "str";
  }
}

template <typename Parameters, typename Value>
void append(Parameters& parameters, const std::string& name, const Value& value) {
  typename Parameters::value_type parameter;
  parameter.name = name;
  parameter.value = value;
  parameters.push_back(parameter);
}

void append(dynamic_reconfigure::Config& config, const std::string& name, XmlRpcValue value) {
  switch (value.getType()) {
    case XmlRpcValue::TypeBoolean:
      return append(config.bools, name, static_cast<std::uint8_t>(static_cast<bool>(value) ? 1 : 0));
    case XmlRpcValue::TypeInt:
      return append(config.ints, name, static_cast<int>(value));
    case XmlRpcValue::TypeDouble:
      return append(config.doubles, name, static_cast<double>(value));
    default:
      return append(config.strs, name, static_cast<std::string>(value));
  }
}

/// All values in the one group that rqt_reconfigure expects.
dynamic_reconfigure::Config to_message(const std::map<std::string, XmlRpcValue>& values) {
  dynamic_reconfigure::Config config;
  for (const auto& [name, value] : values) append(config, name, value);
  dynamic_reconfigure::GroupState group;
  group.name = "Default";
  group.state = 1;
  config.groups.push_back(group);
  return config;
}

/// The Python dictionary in which dynamic_reconfigure lists the values of an enumeration.
std::string edit_method(const std::vector<std::string>& choices) {
  if (choices.empty()) return {};
  std::string entries;
  for (const auto& choice : choices) {
    if (!entries.empty()) entries += ", ";
    entries.append("{'name': '").append(choice).append("', 'type': 'str', 'value': '");
    entries.append(choice).append("', 'description': ''}");
  }
  return "{'enum_description': '', 'enum': [" + entries + "]}";
}

const ReadParam& found(const std::vector<ReadParam>& read, const std::string& name) {
  for (const auto& param : read)
    if (param.name == name) return param;
  throw std::logic_error("the loader does not read the parameter " + name);
}

}  // namespace

Reconfigure::Reconfigure(const ros::NodeHandle& private_handle, const std::vector<ReadParam>& read,
                         const std::vector<DynamicParam>& params, Apply apply)
    : handle_(private_handle), apply_(std::move(apply)) {
  for (const auto& param : params) values_[param.name] = found(read, param.name).value;
  descriptions_ =
      handle_.advertise<dynamic_reconfigure::ConfigDescription>("parameter_descriptions", 1, true);
  updates_ = handle_.advertise<dynamic_reconfigure::Config>("parameter_updates", 1, true);
  descriptions_.publish(describe(read, params));
  updates_.publish(to_message(values_));
  server_ = handle_.advertiseService("set_parameters", &Reconfigure::serve, this);
}

std::string Reconfigure::last_refusal() const {
  const std::lock_guard lock(mutex_);
  return last_refusal_;
}

bool Reconfigure::serve(dynamic_reconfigure::Reconfigure::Request& request,
                        dynamic_reconfigure::Reconfigure::Response& response) {
  const auto values = wanted(request.config);
  const auto changed = values ? change(*values) : Result<void>(tl::unexpected(values.error()));
  if (!changed)
    ROS_ERROR("%s: refused a change of parameters, the old values stay: %s", handle_.getNamespace().c_str(),
              changed.error().message.c_str());
  {
    const std::lock_guard lock(mutex_);
    last_refusal_ = changed ? "" : changed.error().message;
  }
  response.config = to_message(values_);
  updates_.publish(response.config);
  return true;
}

/// The values in force with those of the request.
Result<Reconfigure::Values> Reconfigure::wanted(const dynamic_reconfigure::Config& config) const {
  Values values = values_;
  std::string problem;
  const auto take = [&](const std::string& name, const XmlRpcValue& value) {
    const auto known = values.find(name);
    if (known == values.end()) {
      std::vector<std::string> names;
      for (const auto& entry : values_) names.push_back(entry.first);
      problem = in_quotes(name) + " cannot be changed while the node runs; these can: " + joined(names);
    } else if (known->second.getType() != value.getType()) {
      problem = in_quotes(name) + " is of type " + type_name(known->second) + ", not " + type_name(value);
    } else {
      known->second = value;
    }
  };
  for (const auto& entry : config.bools) take(entry.name, XmlRpcValue(entry.value != 0));
  for (const auto& entry : config.ints) take(entry.name, XmlRpcValue(entry.value));
  for (const auto& entry : config.doubles) take(entry.name, XmlRpcValue(entry.value));
  for (const auto& entry : config.strs) take(entry.name, XmlRpcValue(entry.value));
  if (!problem.empty()) return fail(ErrorCode::kInvalidArgument, problem);
  return values;
}

Result<void> Reconfigure::change(const Values& wanted) {
  const Values before = values_;
  store(wanted);
  auto applied = apply_();
  if (applied)
    values_ = wanted;
  else
    store(before);
  return applied;
}

void Reconfigure::store(const Values& values) const {
  for (const auto& [name, value] : values) handle_.setParam(name, value);
}

dynamic_reconfigure::ConfigDescription Reconfigure::describe(const std::vector<ReadParam>& read,
                                                             const std::vector<DynamicParam>& params) const {
  dynamic_reconfigure::ConfigDescription description;
  Values low;
  Values high;
  dynamic_reconfigure::Group group;
  group.name = "Default";
  for (const auto& param : params) {
    const auto& known = found(read, param.name);
    dynamic_reconfigure::ParamDescription one;
    one.name = param.name;
    one.type = type_name(known.value);
    one.description = param.text;
    one.edit_method = edit_method(param.choices);
    group.parameters.push_back(one);
    low[param.name] = known.low;
    high[param.name] = known.high;
  }
  description.groups.push_back(group);
  description.min = to_message(low);
  description.max = to_message(high);
  description.dflt = to_message(values_);
  return description;
}

}  // namespace extperfc::ros_params
