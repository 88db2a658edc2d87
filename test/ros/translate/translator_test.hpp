#pragma once

#include <string>

#include <ros/node_handle.h>
#include <ros/package.h>
#include <ros/param.h>
#include <yaml-cpp/yaml.h>

namespace extperfc::ros_test {

/// A YAML value as roslaunch would set it.
inline XmlRpc::XmlRpcValue to_param(const YAML::Node& node) {
  if (node.IsMap()) {
    XmlRpc::XmlRpcValue group;
    for (const auto& entry : node) group[entry.first.as<std::string>()] = to_param(entry.second);
    return group;
  }
  if (node.IsSequence()) {
    XmlRpc::XmlRpcValue list;
    list.setSize(static_cast<int>(node.size()));
    for (std::size_t i = 0; i < node.size(); ++i) list[static_cast<int>(i)] = to_param(node[i]);
    return list;
  }
  const bool quoted = node.Tag() == "!";
  int whole = 0;
  double number = 0.0;
  bool flag = false;
  if (!quoted && YAML::convert<int>::decode(node, whole)) return {whole};
  if (!quoted && YAML::convert<double>::decode(node, number)) return {number};
  if (!quoted && YAML::convert<bool>::decode(node, flag)) return {flag};
  return {node.as<std::string>()};
}

/// Groups are merged, everything else is replaced, as roslaunch does it.
inline void set_merged(const std::string& name, const YAML::Node& node) {
  if (node.IsMap())
    for (const auto& entry : node) set_merged(name + "/" + entry.first.as<std::string>(), entry.second);
  else
    ros::param::set(name, to_param(node));
}

/// Sets what a YAML file of this package says, below `ns`.
inline void set_from_file(const std::string& ns, const std::string& file) {
  set_merged(ns, YAML::LoadFile(ros::package::getPath("extperfc") + "/" + file));
}

}  // namespace extperfc::ros_test
