#pragma once

#include <atomic>
#include <memory>

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <std_srvs/SetBool.h>

#include "ros/robot/arm_motion.hpp"
#include "ros/robot/tuck_plan.hpp"
#include "ros/simulate/sim_host.hpp"

namespace extperfc::ros_robot {

/// Tucks and untucks both arms. Answers when they are there, or with the reason why not: a disabled robot, a
/// tolerance, another command to an arm. It takes about 10 s of simulated time. A second call waits for the
/// first.
///
/// Services:
///   robot/tuck_arms  std_srvs/SetBool: true tucks both arms, false untucks them
/// Threads: a separate thread waits, so that the robot's topics stay alive meanwhile.
class TuckService {
 public:
  TuckService(ros::NodeHandle handle, ros_simulate::SimHost& host, const ArmMotions& motions,
              const TuckSpeed& speed);
  ~TuckService();
  TuckService(const TuckService&) = delete;
  TuckService& operator=(const TuckService&) = delete;

 private:
  struct Job;

  [[nodiscard]] ArmMotion& motion(simulate::Side side) const { return *motions_[static_cast<int>(side)]; }
  bool serve(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  void begin(const std::shared_ptr<Job>& job, const simulate::Simulator& simulator);
  void arm_done(const std::shared_ptr<Job>& job, simulate::Side side, ArmMotion::Status status,
                const simulate::TrajectoryEnd& end);

  ros_simulate::SimHost& host_;
  const ArmMotions motions_;
  const TuckSpeed speed_;
  std::atomic<bool> closing_{false};
  ros::CallbackQueue queue_;
  ros::ServiceServer server_;
  ros::AsyncSpinner spinner_{1, &queue_};
};

}  // namespace extperfc::ros_robot
