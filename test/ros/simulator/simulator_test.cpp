#include "test/ros/simulator/simulator_test.hpp"

#include <ros/package.h>

namespace extperfc::ros_test {

Params small_simulation() {
  return {{"world", ros::package::getPath("extperfc") + "/test/ros/simulator/small.yaml"},
          {"start_enabled", true},
          {"time/paused", true},
          {"camera/width", 64},
          {"camera/height", 48},
          {"camera/shadows", false},
          {"lidar/columns", 90}};
}

Params running_simulation() {
  return with(small_simulation(), {{"time/paused", false}, {"time/real_time_factor", 0}});
}

Params with(Params params, const Params& more) {
  for (const auto& [key, value] : more) params[key] = value;
  return params;
}

XmlRpc::XmlRpcValue fault_entry(const std::string& kind, const std::string& target, double value) {
  XmlRpc::XmlRpcValue entry;
  entry["kind"] = kind;
  entry["target"] = target;
  entry["value"] = value;
  return entry;
}

ros::Time SimulatorTest::step(unsigned steps, const std::string& ns) {
  StepSimulation::Request request;
  request.steps = steps;
  const auto response = call<StepSimulation>("sim/step", request, ns);
  EXPECT_TRUE(response.success) << response.message;
  return response.stamp;
}

void SimulatorTest::pause(bool on) {
  std_srvs::SetBool::Request request;
  request.data = static_cast<unsigned char>(on);
  const auto response = call<std_srvs::SetBool>("sim/pause", request);
  EXPECT_TRUE(response.success) << response.message;
}

void SimulatorTest::reset() {
  const auto response = call<std_srvs::Trigger>("sim/reset", {});
  EXPECT_TRUE(response.success) << response.message;
}

SetFault::Response SimulatorTest::set_fault(const std::string& kind, const std::string& target, double value,
                                            double duration_s) {
  SetFault::Request request;
  request.kind = kind;
  request.target = target;
  request.value = value;
  request.duration_s = duration_s;
  return call<SetFault>("sim/set_fault", request);
}

}  // namespace extperfc::ros_test
