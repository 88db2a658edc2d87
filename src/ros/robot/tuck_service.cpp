#include "ros/robot/tuck_service.hpp"

#include <chrono>
#include <future>
#include <string>
#include <utility>

namespace extperfc::ros_robot {

using simulate::Side;

/// One call. Of the simulation thread, but for `answer`'s future.
struct TuckService::Job {
  bool tuck{false};
  int moving_arms{0};
  std::string problem;  ///< empty: none
  std::promise<std::string> answer;
};

TuckService::TuckService(ros::NodeHandle handle, ros_simulate::SimHost& host, const ArmMotions& motions,
                         const TuckSpeed& speed)
    : host_(host), motions_(motions), speed_(speed) {
  handle.setCallbackQueue(&queue_);
  server_ = handle.advertiseService("robot/tuck_arms", &TuckService::serve, this);
  spinner_.start();
}

TuckService::~TuckService() {
  closing_ = true;
  server_.shutdown();
  spinner_.stop();
}

bool TuckService::serve(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
  const auto job = std::make_shared<Job>();
  job->tuck = request.data != 0;
  auto answer = job->answer.get_future();
  response.success = false;
  if (!host_.post([this, job](simulate::Simulator& simulator) { begin(job, simulator); })) {
    response.message = "the simulation accepts no commands now";
    return true;
  }
  // The simulation may be paused, for however long, or end.
  while (answer.wait_for(std::chrono::milliseconds(100)) != std::future_status::ready) {
    if (!closing_) continue;
    response.message = "the simulation has ended";
    return true;
  }
  const auto problem = answer.get();
  response.success = problem.empty();
  response.message = problem.empty() ? (job->tuck ? "tucked" : "untucked") : problem;
  return true;
}

void TuckService::begin(const std::shared_ptr<Job>& job, const simulate::Simulator& simulator) {
  const auto goals = plan_tuck(
      job->tuck, {simulator.arm_state(Side::kLeft).position, simulator.arm_state(Side::kRight).position},
      speed_);
  for (const Side side : simulate::kSides) {
    const auto started = motion(side).start(
        simulator, goals[static_cast<int>(side)],
        [this, job, side](ArmMotion::Status status, const auto& end) { arm_done(job, side, status, end); });
    if (!started) {
      job->problem = started.error().message;
      break;
    }
    ++job->moving_arms;
  }
  if (job->moving_arms == 0) return job->answer.set_value(job->problem);
  if (!job->problem.empty()) motion(Side::kLeft).stop();  // alone it could hit the other arm
}

void TuckService::arm_done(const std::shared_ptr<Job>& job, Side side, ArmMotion::Status status,
                           const simulate::TrajectoryEnd& end) {
  --job->moving_arms;
  if (status != ArmMotion::Status::kReached && job->problem.empty()) {
    job->problem = std::string(to_string(side)) + " arm: " + end.message;
    if (job->moving_arms > 0) motion(side == Side::kLeft ? Side::kRight : Side::kLeft).stop();
  }
  if (job->moving_arms == 0) job->answer.set_value(job->problem);
}

}  // namespace extperfc::ros_robot
