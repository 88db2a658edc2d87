#include "ros/simulate/sim_services.hpp"

#include <cmath>
#include <string>

#include <Eigen/Geometry>
#include <ros/console.h>

namespace extperfc::ros_simulate {

namespace {

constexpr double kFastest = 100.0;

template <typename Response>
void answer(const Result<void>& result, Response& response) {
  response.success = static_cast<unsigned char>(result.has_value());
  response.message = result ? "" : result.error().message;
}

Result<Pose> to_pose(const geometry_msgs::Pose& message) {
  const Eigen::Vector3d position(message.position.x, message.position.y, message.position.z);
  const Eigen::Quaterniond rotation(message.orientation.w, message.orientation.x, message.orientation.y,
                                    message.orientation.z);
  if (!position.allFinite() || !rotation.coeffs().allFinite())
    return fail(ErrorCode::kInvalidArgument, "the pose has numbers that are not finite");
  if (rotation.norm() < 0.5)
    return fail(ErrorCode::kInvalidArgument, "the pose's orientation is not a rotation: set w = 1 for none");
  Pose pose = Pose::Identity();
  pose.translation() = position;
  pose.linear() = rotation.normalized().toRotationMatrix();
  return pose;
}

Result<void> move(simulate::Simulator& simulator, const std::string& name, const Pose& world_T_body) {
  if (name != "robot") {
    auto moved = simulator.move_body(name, world_T_body);
    if (!moved) moved.error().message = "'" + name + "' cannot be moved: " + moved.error().message;
    return moved;
  }
  const Eigen::Vector3d forward = world_T_body.linear().col(0);
  simulator.move_robot(
      {world_T_body.translation().x(), world_T_body.translation().y(), std::atan2(forward.y(), forward.x())});
  return {};
}

}  // namespace

SimServices::SimServices(const ros::NodeHandle& handle, SimThread& thread, FaultControl& faults)
    : thread_(thread), faults_(faults), handle_(handle), spinner_(2, &queue_) {
  handle_.setCallbackQueue(&queue_);
  advertise<std_srvs::SetBool>("sim/pause", &SimServices::pause);
  advertise<StepSimulation>("sim/step", &SimServices::step);
  advertise<std_srvs::Trigger>("sim/reset", &SimServices::reset);
  advertise<SetRealTimeFactor>("sim/set_real_time_factor", &SimServices::set_real_time_factor);
  advertise<SetFault>("sim/set_fault", &SimServices::set_fault);
  advertise<MoveBody>("sim/move_body", &SimServices::move_body);
  spinner_.start();
}

SimServices::~SimServices() {
  for (auto& server : servers_) server.shutdown();
  spinner_.stop();
}

template <typename Service>
void SimServices::advertise(const char* name, Handler<Service> handler) {
  using Request = typename Service::Request;
  using Response = typename Service::Response;
  servers_.push_back(handle_.advertiseService<Request, Response>(
      name, boost::function<bool(Request&, Response&)>([this, handler](Request& request, Response& response) {
        try {
          (this->*handler)(request, response);
        } catch (const std::exception& error) {
          response.success = 0;
          response.message = error.what();
        }
        return true;
      })));
}

void SimServices::pause(const std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
  thread_.ask([&](simulate::Simulator&) { thread_.set_paused(request.data != 0); });
  response.success = 1;
  response.message = request.data ? "paused" : "running";
}

void SimServices::step(const StepSimulation::Request& request, StepSimulation::Response& response) {
  const auto stamp = thread_.run_steps(request.steps);
  response.success = static_cast<unsigned char>(stamp.has_value());
  if (stamp) {
    response.stamp = *stamp;
  } else {
    response.message = stamp.error().message;
  }
}

void SimServices::reset(const std_srvs::Trigger::Request& /*request*/,
                        std_srvs::Trigger::Response& response) {
  const auto done = thread_.ask([this](simulate::Simulator& simulator) {
    auto reset = thread_.reset(simulator);
    return reset ? faults_.begin(simulator) : reset;
  });
  answer(done, response);
}

void SimServices::set_real_time_factor(const SetRealTimeFactor::Request& request,
                                       SetRealTimeFactor::Response& response) {
  if (!(request.factor >= 0.0 && request.factor <= kFastest))
    return answer(fail(ErrorCode::kInvalidArgument, "the factor must be in [0, 100]; 0: as fast as possible"),
                  response);
  thread_.ask([&](simulate::Simulator&) { thread_.set_real_time_factor(request.factor); });
  answer({}, response);
}

void SimServices::set_fault(const SetFault::Request& request, SetFault::Response& response) {
  const auto kind = simulate::fault_kind(request.kind);
  if (!kind)
    return answer(fail(ErrorCode::kInvalidArgument,
                       "there is no fault '" + request.kind +
                           "': use camera_freeze, camera_drop, camera_nan, lidar_rings, lidar_drop, "
                           "joint_stuck, wheel_slip, clock_jump, die or none"),
                  response);
  const simulate::Fault fault{*kind, request.target, request.value, request.duration_s};
  const auto done = thread_.ask([&](simulate::Simulator& simulator) {
    auto set = faults_.set(simulator, fault);
    for (const auto& active : simulator.faults()) response.active.push_back(describe(active));
    return set;
  });
  if (done) ROS_WARN("fault set by service: %s", describe(fault).c_str());
  answer(done, response);
}

void SimServices::move_body(const MoveBody::Request& request, MoveBody::Response& response) {
  const auto pose = to_pose(request.pose);
  if (!pose) return answer(tl::unexpected(pose.error()), response);
  answer(thread_.ask([&](simulate::Simulator& simulator) { return move(simulator, request.name, *pose); }),
         response);
}

}  // namespace extperfc::ros_simulate
