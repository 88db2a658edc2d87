#pragma once

#include <memory>
#include <string>

#include <extperfc/MoveBody.h>
#include <extperfc/SetFault.h>
#include <extperfc/SetRealTimeFactor.h>
#include <extperfc/StepSimulation.h>
#include <gtest/gtest.h>
#include <ros/service.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include "test/ros/support/manager.hpp"
#include "test/ros/support/watch.hpp"

namespace extperfc::ros_test {

/// What keeps the tests quick: a small room, small images, few columns, no shadows. Time stands still, and
/// steps wait for the sensors.
[[nodiscard]] Params small_simulation();

/// The same that runs as fast as it can.
[[nodiscard]] Params running_simulation();

[[nodiscard]] Params with(Params params, const Params& more);

/// An entry of the parameter `faults`.
[[nodiscard]] XmlRpc::XmlRpcValue fault_entry(const std::string& kind, const std::string& target,
                                              double value);

/// Calls a service of the simulator in namespace `ns`; the test fails when nobody answers.
template <typename Service>
typename Service::Response call(const std::string& name, const typename Service::Request& request,
                                const std::string& ns = "") {
  Service service;
  service.request = request;
  const std::string full_name = ns + "/" + name;
  EXPECT_TRUE(wait_for([&] { return ros::service::exists(full_name, false); })) << full_name;
  EXPECT_TRUE(ros::service::call(full_name, service)) << full_name;
  return service.response;
}

/// A simulator in the test's own process.
class SimulatorTest : public testing::Test {
 protected:
  void load(const Params& params, const std::string& name = "/simulator") {
    ASSERT_TRUE(manager_.load(name, "simulator", params)) << log_.text();
  }

  /// Makes steps of 1/240 s, sensors included. The stamp afterwards.
  static ros::Time step(unsigned steps, const std::string& ns = "");
  static void pause(bool on);
  static void reset();
  static SetFault::Response set_fault(const std::string& kind, const std::string& target = "",
                                      double value = 1, double duration_s = 0);

  LogWatch log_;
  Manager manager_;
};

}  // namespace extperfc::ros_test
