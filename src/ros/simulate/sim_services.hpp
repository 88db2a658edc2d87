#pragma once

#include <vector>

#include <extperfc/MoveBody.h>
#include <extperfc/SetFault.h>
#include <extperfc/SetRealTimeFactor.h>
#include <extperfc/StepSimulation.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include "ros/simulate/fault_control.hpp"
#include "ros/simulate/sim_thread.hpp"

namespace extperfc::ros_simulate {

/// Services of the simulation. They answer in separate threads, so that a long sim/step blocks no other call.
///
/// Services:
///   sim/pause                 std_srvs/SetBool
///   sim/step                  extperfc/StepSimulation, while paused
///   sim/reset                 std_srvs/Trigger
///   sim/set_real_time_factor  extperfc/SetRealTimeFactor
///   sim/set_fault             extperfc/SetFault
///   sim/move_body             extperfc/MoveBody
class SimServices {
 public:
  SimServices(const ros::NodeHandle& handle, SimThread& thread, FaultControl& faults);
  /// SimThread::stop() must have been called: calls that wait for the simulation end then.
  ~SimServices();
  SimServices(const SimServices&) = delete;
  SimServices& operator=(const SimServices&) = delete;

 private:
  template <typename Service>
  using Handler = void (SimServices::*)(const typename Service::Request&, typename Service::Response&);
  /// Advertises a service whose answer never throws.
  template <typename Service>
  void advertise(const char* name, Handler<Service> handler);

  void pause(const std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  void step(const StepSimulation::Request& request, StepSimulation::Response& response);
  void reset(const std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  void set_real_time_factor(const SetRealTimeFactor::Request& request, SetRealTimeFactor::Response& response);
  void set_fault(const SetFault::Request& request, SetFault::Response& response);
  void move_body(const MoveBody::Request& request, MoveBody::Response& response);

  SimThread& thread_;
  FaultControl& faults_;
  ros::CallbackQueue queue_;
  ros::NodeHandle handle_;  ///< with queue_
  std::vector<ros::ServiceServer> servers_;
  ros::AsyncSpinner spinner_;
};

}  // namespace extperfc::ros_simulate
