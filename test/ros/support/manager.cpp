#include "test/ros/support/manager.hpp"

#include <ros/param.h>

namespace extperfc::ros_test {

Manager::~Manager() {
  for (const auto& name : std::set<std::string>(names_)) unload(name);
}

bool Manager::load(const std::string& name, const std::string& type, const Params& params) {
  (void)ros::param::del(name);
  ros::param::set(name + "/diagnostic_period", 0.02);
  for (const auto& [key, value] : params) ros::param::set(name + "/" + key, value);
  names_.insert(name);
  return loader_.load(name, "extperfc/" + type, {}, {});
}

void Manager::unload(const std::string& name) {
  (void)loader_.unload(name);
  (void)ros::param::del(name);
  names_.erase(name);
}

std::string model_folder(const std::string& name) {
  return std::string(EXTPERFC_TEST_DATA) + "/models/" + name;
}

Params detector_params(const std::string& model) {
  return {{"model", model_folder(model)}, {"backend", "opencv"}, {"threads", 1}};
}

}  // namespace extperfc::ros_test
