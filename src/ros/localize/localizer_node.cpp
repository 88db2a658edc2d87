#include "ros/localize/localizer_node.hpp"

#include <cmath>
#include <exception>
#include <utility>

#include <geometry_msgs/PoseArray.h>
#include <ros/init.h>

#include "extperfc/base/stopwatch.hpp"

#include "ros/convert/occupancy_grid.hpp"
#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_localize {

namespace {

using diagnostic_msgs::DiagnosticStatus;

constexpr double kReportTickS = 0.1;
constexpr double kStampJumpS = 1.0;         // stamps of several scanners may be slightly out of order
constexpr double kSureClusterWeight = 0.5;  // below, most of the weight is in other clusters

}  // namespace

Result<std::unique_ptr<LocalizerNode>> LocalizerNode::make(const ros::NodeHandle& handle,
                                                           const ros::NodeHandle& private_handle,
                                                           const std::string& name) {
  const auto params = ros_params::load_localizer_params(private_handle);
  if (!params) return tl::unexpected(params.error());
  for (const auto& note : params->notes) ROS_WARN("%s: %s", name.c_str(), note.c_str());
  std::unique_ptr<LocalizerNode> node(new LocalizerNode(handle, private_handle, *params, name));
  if (auto started = node->start(); !started) return tl::unexpected(started.error());
  return node;
}

LocalizerNode::LocalizerNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                             const ros_params::LocalizerNodeParams& params, const std::string& name)
    : handle_(handle),
      private_handle_(private_handle),
      params_(params),
      engine_(params, tf_buffer_),
      map_source_(handle, params, [this](MapPtr map) { inbox_.put_map(std::move(map)); }),
      updater_(handle, private_handle, name) {
  updater_.setHardwareID("none");
  updater_.add("localizer", this, &LocalizerNode::report);
}

LocalizerNode::~LocalizerNode() {
  diagnostics_timer_.stop();
  store_timer_.stop();
  scan_subscriber_.shutdown();
  pose_subscriber_.shutdown();
  global_service_.shutdown();
  nomotion_service_.shutdown();
  map_service_.shutdown();
  engine_.stop();
  map_source_.stop();
  inbox_.close();
  if (worker_.joinable()) worker_.join();
  store_pose();
}

Result<void> LocalizerNode::start() {
  advertise();
  if (auto started = map_source_.start(); !started) return started;
  worker_ = std::thread([this] {
    while (const auto work = inbox_.take()) work_off(*work);
  });
  diagnostics_timer_ =
      handle_.createWallTimer(ros::WallDuration(kReportTickS), [this](const auto&) { update_diagnostics(); });
  if (params_.save_pose_rate > 0)
    store_timer_ = handle_.createWallTimer(ros::WallDuration(1 / params_.save_pose_rate),
                                           [this](const auto&) { store_pose(); });
  scan_health_.listening(true);
  pose_subscriber_ = handle_.subscribe("initialpose", 2, &LocalizerNode::on_initial_pose, this);
  scan_subscriber_ = handle_.subscribe("scan", 2, &LocalizerNode::on_scan, this);
  return {};
}

void LocalizerNode::advertise() {
  const auto want_cloud = [this](const ros::SingleSubscriberPublisher&) { cloud_wanted_ = true; };
  pose_publisher_ = handle_.advertise<PoseMessage>("amcl_pose", 2, true);
  cloud_publisher_ = handle_.advertise<geometry_msgs::PoseArray>(
      "particlecloud", 2, want_cloud, ros::SubscriberStatusCallback(), ros::VoidConstPtr(), true);
  global_service_ =
      handle_.advertiseService("global_localization", &LocalizerNode::on_global_localization, this);
  nomotion_service_ =
      handle_.advertiseService("request_nomotion_update", &LocalizerNode::on_nomotion_update, this);
  map_service_ = handle_.advertiseService("set_map", &LocalizerNode::on_set_map, this);
}

void LocalizerNode::on_scan(const ScanEvent& event) {
  const auto& scan = event.getConstMessage();
  scan_health_.received(scan->header.stamp, scan->ranges.data(), ros_health::came_by_pointer(event));
  if (time_ran_back(scan->header.stamp)) inbox_.put_time_jump();
  inbox_.put_scan(scan);
}

bool LocalizerNode::time_ran_back(const ros::Time& stamp) {
  const auto now = ros::Time::now();
  const bool back = now < last_now_ || stamp.toSec() < last_stamp_.toSec() - kStampJumpS;
  last_now_ = now;
  last_stamp_ = stamp;
  if (back) {
    const std::lock_guard lock(state_mutex_);
    ++state_.time_jumps;
  }
  return back;
}

Result<GivenPose> LocalizerNode::to_given_pose(const PoseMessage& message) const {
  auto frame = message.header.frame_id;
  if (!frame.empty() && frame.front() == '/') frame.erase(0, 1);
  if (!frame.empty() && frame != params_.global_frame)
    return fail(ErrorCode::kInvalidArgument,
                "ignoring initial pose: its frame is " + frame + ", must be " + params_.global_frame);
  const auto pose = ros_convert::to_pose2(message.pose.pose);
  if (!pose) return fail(ErrorCode::kInvalidArgument, "ignoring initial pose: " + pose.error().message);
  const auto covariance = ros_convert::to_covariance(message.pose.covariance);
  if (!covariance.allFinite() || covariance.diagonal().minCoeff() < 0)
    return fail(ErrorCode::kInvalidArgument,
                "ignoring initial pose: covariance must be finite with a non-negative diagonal");
  return GivenPose{message.header.stamp, *pose, covariance};
}

void LocalizerNode::on_initial_pose(const PoseMessage::ConstPtr& message) {
  auto given = to_given_pose(*message);
  if (!given) {
    ROS_ERROR("%s", given.error().message.c_str());
    return;
  }
  inbox_.put_placement(*given);
}

bool LocalizerNode::on_global_localization(std_srvs::Empty::Request&, std_srvs::Empty::Response&) {
  inbox_.put_placement(GlobalInitialization{});
  return true;
}

bool LocalizerNode::on_nomotion_update(std_srvs::Empty::Request&, std_srvs::Empty::Response&) {
  inbox_.put_force();
  return true;
}

bool LocalizerNode::on_set_map(nav_msgs::SetMap::Request& request, nav_msgs::SetMap::Response& response) {
  auto map = ros_convert::to_occupancy_grid(request.map);
  const auto given = to_given_pose(request.initial_pose);
  response.success = map && given;
  if (!map)
    ROS_ERROR("set_map: %s", map.error().message.c_str());
  else if (!given)
    ROS_ERROR("set_map: %s", given.error().message.c_str());
  else
    inbox_.put_map(std::make_shared<const OccupancyGrid>(std::move(*map)), *given);
  return true;
}

/// Catches exceptions and reports them like other errors.
void LocalizerNode::work_off(const Work& work) {
  std::string error;
  try {
    const Stopwatch watch;
    const auto located = engine_.process(work);
    {
      const std::lock_guard lock(state_mutex_);
      state_.has_map = engine_.has_map();
    }
    if (!located)
      error = located.error().message;
    else if (*located) {
      publish(**located);
      work_health_.done(watch.milliseconds(), ros_health::age_ms((*located)->stamp));
    }
  } catch (const std::exception& thrown) {
    error = thrown.what();
  }
  if (!error.empty() && work_health_.failed(error)) ROS_ERROR("%s", error.c_str());
}

void LocalizerNode::publish(const Located& located) {
  if (params_.tf_broadcast) broadcast(located);
  if (located.updated) publish_pose(located);
  const double since_last_s = std::abs(located.stamp.toSec() - last_cloud_.toSec());
  const bool due = params_.gui_publish_rate <= 0 || since_last_s * params_.gui_publish_rate >= 1;
  if (cloud_wanted_.exchange(false) || (located.updated && due && cloud_publisher_.getNumSubscribers() > 0))
    publish_cloud(located.stamp);
  const std::lock_guard lock(state_mutex_);
  state_.located = located;
  state_.particles = engine_.particles().size();
  state_.updates += located.updated ? 1U : 0U;
}

void LocalizerNode::broadcast(const Located& located) {
  geometry_msgs::TransformStamped message;
  message.header.frame_id = params_.global_frame;
  message.header.stamp = located.stamp + ros::Duration(params_.transform_tolerance);
  message.child_frame_id = params_.odom_frame;
  message.transform = ros_convert::to_transform_message(located.map_T_odom);
  tf_broadcaster_.sendTransform(message);
}

void LocalizerNode::publish_pose(const Located& located) {
  PoseMessage message;
  message.header.frame_id = params_.global_frame;
  message.header.stamp = located.stamp;
  message.pose.pose = ros_convert::to_pose_message(located.map_T_base);
  message.pose.covariance = ros_convert::to_covariance_message(located.estimate.covariance);
  pose_publisher_.publish(message);
}

void LocalizerNode::publish_cloud(const ros::Time& stamp) {
  geometry_msgs::PoseArray message;
  message.header.frame_id = params_.global_frame;
  message.header.stamp = stamp;
  message.poses.reserve(engine_.particles().size());
  for (const auto& particle : engine_.particles())
    message.poses.push_back(ros_convert::to_pose_message(particle.pose));
  cloud_publisher_.publish(message);
  last_cloud_ = stamp;
}

void LocalizerNode::store_pose() {
  if (params_.save_pose_rate <= 0 || !ros::ok()) return;
  std::optional<Located> located;
  {
    const std::lock_guard lock(state_mutex_);
    located = state_.located;
  }
  if (located)
    ros_params::store_initial_pose(private_handle_, located->map_T_base, located->estimate.covariance);
}

/// By wall time: after ros time ran back, Updater::update() would wait until it has caught up.
void LocalizerNode::update_diagnostics() {
  const auto now = ros::WallTime::now();
  if ((now - last_report_).toSec() < updater_.getPeriod()) return;
  last_report_ = now;
  updater_.force_update();
}

void LocalizerNode::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  status.summary(DiagnosticStatus::OK, "localized");
  status.add("dropped", inbox_.dropped());
  scan_health_.report(status, handle_.resolveName("scan"), params_.timeout_s);
  work_health_.report(status);
  State state;
  {
    const std::lock_guard lock(state_mutex_);
    state = state_;
  }
  status.add("map", state.has_map ? "loaded" : "none");
  status.add("updates", state.updates);
  status.add("time ran back", state.time_jumps);
  status.add("particles", state.particles);
  if (const auto problem = map_source_.problem(); !state.has_map && !problem.empty())
    status.mergeSummary(DiagnosticStatus::WARN, problem);
  else if (!state.located)
    status.mergeSummary(DiagnosticStatus::WARN, "not localized yet: waiting for the first usable scan");
  else
    report_estimate(status, *state.located);
}

void LocalizerNode::report_estimate(diagnostic_updater::DiagnosticStatusWrapper& status,
                                    const Located& located) const {
  const auto& estimate = located.estimate;
  const Eigen::Vector3d deviation = estimate.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const bool lost = estimate.fit < params_.lost_fit;
  status.addf("pose x y yaw [m m rad]", "%.3f %.3f %.4f", located.map_T_base.x, located.map_T_base.y,
              located.map_T_base.yaw);
  status.addf("deviation x y yaw [m m rad]", "%.4f %.4f %.5f", deviation.x(), deviation.y(), deviation.z());
  status.addf("cluster weight", "%.3f", estimate.cluster_weight);
  status.addf("fit", "%.3f", estimate.fit);
  status.add("lost", lost ? "yes" : "no");
  if (lost)
    status.mergeSummaryf(
        DiagnosticStatus::WARN,
        "lost: %.0f %% of the beams fit the map at the pose, less than lost_fit; give an initial "
        "pose or call global_localization",
        100 * estimate.fit);
  else if (estimate.cluster_weight < kSureClusterWeight)
    status.mergeSummaryf(DiagnosticStatus::WARN, "ambiguous: the pose has %.0f %% of the particles' weight",
                         100 * estimate.cluster_weight);
  else if (deviation.x() > params_.warn.x_m || deviation.y() > params_.warn.y_m ||
           deviation.z() > params_.warn.yaw_rad)
    status.mergeSummaryf(DiagnosticStatus::WARN, "uncertain: deviation %.2f m, %.2f m, %.2f rad",
                         deviation.x(), deviation.y(), deviation.z());
}

}  // namespace extperfc::ros_localize
