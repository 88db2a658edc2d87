#pragma once

#include <string>

#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <gtest/gtest.h>
#include <ros/service.h>

namespace extperfc::ros_test {

/// A change of parameters of one node, as rqt_reconfigure sends it.
class ReconfigureClient {
 public:
  explicit ReconfigureClient(std::string node) : node_(std::move(node)) {}

  dynamic_reconfigure::Config set(const std::string& name, bool value) const {
    dynamic_reconfigure::Config config;
    config.bools.emplace_back();
    config.bools.back().name = name;
    config.bools.back().value = static_cast<std::uint8_t>(value ? 1 : 0);
    return send(config);
  }
  dynamic_reconfigure::Config set(const std::string& name, double value) const {
    dynamic_reconfigure::Config config;
    config.doubles.emplace_back();
    config.doubles.back().name = name;
    config.doubles.back().value = value;
    return send(config);
  }
  dynamic_reconfigure::Config set(const std::string& name, const char* value) const {
    dynamic_reconfigure::Config config;
    config.strs.emplace_back();
    config.strs.back().name = name;
    config.strs.back().value = value;
    return send(config);
  }

  /// The values in force afterwards.
  dynamic_reconfigure::Config send(const dynamic_reconfigure::Config& config) const {
    dynamic_reconfigure::Reconfigure call;
    call.request.config = config;
    EXPECT_TRUE(ros::service::call(node_ + "/set_parameters", call));
    return call.response.config;
  }

 private:
  std::string node_;
};

/// The value of a parameter in a Config; the default of its type when it is not there.
template <typename Parameters>
auto value_of(const Parameters& parameters, const std::string& name) {
  for (const auto& parameter : parameters)
    if (parameter.name == name) return parameter.value;
  ADD_FAILURE() << "no parameter " << name;
  return typename Parameters::value_type().value;
}

}  // namespace extperfc::ros_test
