#include "ros/navigate/cmd_vel_mux_node.hpp"

#include <utility>

#include <ros/console.h>

#include "ros/convert/geometry.hpp"

namespace extperfc::ros_navigate {

namespace {

/// Simulated time may stand still; a source that is silent is so by wall time.
double now_s() {
  return ros::WallTime::now().toSec();
}

}  // namespace

Result<std::unique_ptr<CmdVelMuxNode>> CmdVelMuxNode::make(const ros::NodeHandle& handle,
                                                           const ros::NodeHandle& private_handle,
                                                           const std::string& name) {
  const auto params = ros_params::load_cmd_vel_mux_params(private_handle);
  if (!params) return tl::unexpected(params.error());
  std::vector<navigate::VelocitySource> sources;
  sources.reserve(params->sources.size());
  for (const auto& source : params->sources) sources.push_back(source.source);
  auto mux = navigate::VelocityMux::make(std::move(sources), params->limits);
  if (!mux) return tl::unexpected(mux.error());
  return std::unique_ptr<CmdVelMuxNode>(
      new CmdVelMuxNode(handle, private_handle, *params, std::move(*mux), name));
}

CmdVelMuxNode::CmdVelMuxNode(const ros::NodeHandle& handle, ros::NodeHandle private_handle,
                             const ros_params::CmdVelMuxParams& params, navigate::VelocityMux mux,
                             const std::string& name)
    : handle_(handle),
      mux_(std::move(mux)),
      velocity_publisher_(handle_.advertise<geometry_msgs::Twist>("cmd_vel", 1)),
      active_publisher_(private_handle.advertise<std_msgs::String>("active", 1, true)),
      reporter_(handle_, private_handle, name) {
  active_publisher_.publish(std_msgs::String());
  reporter_.add("mux", [this](auto& status) { report(status); });
  reporter_.start();
  timer_ = handle_.createWallTimer(ros::WallDuration(1 / params.rate_hz), [this](const auto&) { send(); });
  for (std::size_t i = 0; i < params.sources.size(); ++i)
    subscribers_.push_back(handle_.subscribe<geometry_msgs::Twist>(
        params.sources[i].topic, 1,
        [this, i](const geometry_msgs::Twist::ConstPtr& message) { on_command(i, *message); }));
  subscribers_.push_back(handle_.subscribe<std_msgs::Bool>(
      params.stop_topic, 5, [this](const std_msgs::Bool::ConstPtr& message) { on_stop(*message); }));
  subscribers_.push_back(private_handle.subscribe<std_msgs::Int32>(
      "lock", 5, [this](const std_msgs::Int32::ConstPtr& message) { on_lock(*message); }));
}

CmdVelMuxNode::~CmdVelMuxNode() {
  for (auto& subscriber : subscribers_) subscriber.shutdown();
  timer_.stop();
  if (!active_.empty()) velocity_publisher_.publish(geometry_msgs::Twist());
}

void CmdVelMuxNode::on_command(std::size_t source, const geometry_msgs::Twist& message) {
  bool has_base = false;
  {
    const std::lock_guard lock(mutex_);
    const Twist2 velocity{message.linear.x, message.linear.y, message.angular.z};
    if (!mux_.command(source, velocity, now_s()) && refused_++ == 0)
      ROS_WARN("a velocity of %s is not finite: ignored", mux_.sources()[source].name.c_str());
    has_base = mux_.active(now_s()) == source;
  }
  if (has_base) send();  // without the delay of the timer
}

void CmdVelMuxNode::on_stop(const std_msgs::Bool& message) {
  {
    const std::lock_guard lock(mutex_);
    mux_.set_stop(message.data != 0);
  }
  send();
}

void CmdVelMuxNode::on_lock(const std_msgs::Int32& message) {
  const std::lock_guard lock(mutex_);
  mux_.set_lock(message.data == 0 ? std::nullopt : std::optional<int>(message.data));
}

void CmdVelMuxNode::send() {
  std::optional<navigate::MuxedVelocity> output;
  std::string active;
  {
    const std::lock_guard lock(mutex_);
    output = mux_.output(now_s());
    if (output && output->source) active = mux_.sources()[*output->source].name;
    if (mux_.stopped()) active = "stop";
  }
  if (output) velocity_publisher_.publish(ros_convert::to_message(output->velocity));
  publish_active(active);
}

void CmdVelMuxNode::publish_active(const std::string& name) {
  {
    const std::lock_guard lock(mutex_);
    if (active_ == name) return;
    active_ = name;
  }
  std_msgs::String message;
  message.data = name;
  active_publisher_.publish(message);
}

void CmdVelMuxNode::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const std::lock_guard lock(mutex_);
  status.summary(mux_.stopped() ? DiagnosticStatus::WARN : DiagnosticStatus::OK,
                 mux_.stopped() ? "stopped" : "running");
  status.add("active", active_);
  status.add("lock", mux_.lock() ? std::to_string(*mux_.lock()) : "none");
  status.add("refused", refused_);
}

}  // namespace extperfc::ros_navigate
