#include "ros/arm/depth_obstacle_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <ros/console.h>
#include <visualization_msgs/Marker.h>

#include "extperfc/base/stopwatch.hpp"

#include "ros/convert/geometry.hpp"
#include "ros/convert/image.hpp"

namespace extperfc::ros_arm {

namespace {

constexpr double kPatience = 0.5;  ///< see arm::VoxelChangeDetector [s]
constexpr double kEarly = 0.9;     ///< of the period, because stamps of cameras jitter

/// Largest displacement of a corner of the observed box.
double farthest(const Pose& motion, const arm::DepthObstaclesParams& box) {
  double largest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d at;
    for (int axis = 0; axis < 3; ++axis)
      at[axis] = (corner >> axis & 1) != 0 ? box.high_m[axis] : box.low_m[axis];
    largest = std::max(largest, (motion * at - at).norm());
  }
  return largest;
}

/// Blue at 0, over green to red at 1.
std_msgs::ColorRGBA rainbow(double ratio) {
  const auto part = [&](double middle) {
    return static_cast<float>(std::clamp(1.5 - std::abs(4.0 * ratio - middle), 0.0, 1.0));
  };
  std_msgs::ColorRGBA color;
  color.r = part(3.0);
  color.g = part(2.0);
  color.b = part(1.0);
  color.a = 1.0F;
  return color;
}

/// Cubes of the voxels' size at these centres, in the root's frame.
visualization_msgs::Marker voxel_marker(const std::vector<Eigen::Vector3d>& middles,
                                        const arm::DepthObstaclesParams& box) {
  visualization_msgs::Marker marker;
  marker.ns = PlanningScene::kSeenName;
  marker.type = visualization_msgs::Marker::CUBE_LIST;
  // An empty list would be an error to rviz.
  marker.action = middles.empty() ? visualization_msgs::Marker::DELETE : visualization_msgs::Marker::ADD;
  marker.frame_locked = 1U;
  marker.pose = ros_convert::to_message(Pose::Identity());
  marker.scale = ros_convert::to_vector(Eigen::Vector3d::Constant(box.voxel_m));
  marker.color.a = 1.0F;
  for (const auto& middle : middles) {
    marker.points.push_back(ros_convert::to_point(middle));
    marker.colors.push_back(rainbow((middle.z() - box.low_m.z()) / (box.high_m.z() - box.low_m.z())));
  }
  return marker;
}

}  // namespace

Result<std::unique_ptr<DepthObstacleMonitor>> DepthObstacleMonitor::make(
    SceneMonitorContext context, const ros_params::DepthObstacleMonitorParams& params) {
  auto joints = StampedJoints::make(context.arms);
  if (!joints) return fail(joints.error().code, "depth: " + joints.error().message);
  auto own = params;
  own.obstacles.name = PlanningScene::kSeenName;
  auto obstacles = arm::DepthObstacles::make((*joints)->model(), own.obstacles);
  if (!obstacles) return fail(obstacles.error().code, "depth: " + obstacles.error().message);
  return std::unique_ptr<DepthObstacleMonitor>(
      new DepthObstacleMonitor(std::move(context), own, std::move(*joints), std::move(*obstacles)));
}

DepthObstacleMonitor::DepthObstacleMonitor(SceneMonitorContext context,
                                           const ros_params::DepthObstacleMonitorParams& params,
                                           std::unique_ptr<StampedJoints> joints,
                                           arm::DepthObstacles obstacles)
    : context_(std::move(context)),
      params_(params),
      joints_(std::move(joints)),
      world_frame_(context_.transforms, context_.world_frame),
      obstacles_(std::move(obstacles)),
      change_detector_(params.obstacles.low_m, params.obstacles.voxel_m, kPatience) {}

void DepthObstacleMonitor::start(ros::NodeHandle handle) {
  voxels_publisher_ = handle.advertise<visualization_msgs::Marker>(kVoxelsTopic, 1);
  worker_ = std::thread([this] {
    while (const auto message = images_.take()) process(*message);
  });
  for (auto* input : {&image_health_, &info_health_}) input->listening(true);
  joints_->start(handle);
  subscribers_.push_back(handle.subscribe(kInfoTopic, 1, &DepthObstacleMonitor::on_info, this));
  subscribers_.push_back(handle.subscribe(kImageTopic, 1, &DepthObstacleMonitor::on_image, this));
}

DepthObstacleMonitor::~DepthObstacleMonitor() {
  for (auto& subscriber : subscribers_) subscriber.shutdown();
  joints_->close();
  images_.close();
  if (worker_.joinable()) worker_.join();
}

void DepthObstacleMonitor::on_image(const ImageEvent& event) {
  const auto& message = event.getConstMessage();
  const ros::Time& stamp = message->header.stamp;
  image_health_.received(stamp, message->data.data(), ros_health::came_by_pointer(event));
  {
    const std::lock_guard lock(input_mutex_);
    const double since = stamp.toSec() - taken_.toSec();
    if (since >= 0 && since < kEarly / params_.rate_hz) {
      ++skipped_;
      return;
    }
    taken_ = stamp;
  }
  images_.put(message);
}

void DepthObstacleMonitor::on_info(const InfoEvent& event) {
  const auto& message = event.getConstMessage();
  info_health_.received(message->header.stamp, message.get(), ros_health::came_by_pointer(event));
  const std::lock_guard lock(input_mutex_);
  info_ = message;
}

void DepthObstacleMonitor::process(const sensor_msgs::ImageConstPtr& message) {
  const auto fail_with = [&](const std::string& text) {
    // Errors of tf contain times, so that each text is new.
    if (work_health_.failed(text)) ROS_ERROR_STREAM_THROTTLE(5.0, "depth: " << text);
  };
  const auto image = ros_convert::share_image(message);
  if (!image) return fail_with(image.error().message);
  const auto view = view_of(message->header);
  if (!view) return fail_with(view.error().message);
  const Stopwatch watch;
  Result<bool> changed = false;
  {
    const std::lock_guard lock(mutex_);
    changed = update(image->view, *view, message->header.stamp.toSec());
  }
  if (!changed) return fail_with(changed.error().message);
  work_health_.done(watch.milliseconds(), ros_health::age_ms(message->header.stamp));
  if (*changed) context_.changed();
  publish_voxels();
}

Result<DepthObstacleMonitor::View> DepthObstacleMonitor::view_of(const std_msgs::Header& header) {
  const auto root_T_camera = root_T_header(context_.transforms, header, kImageTopic);
  if (!root_T_camera) return tl::unexpected(root_T_camera.error());
  sensor_msgs::CameraInfoConstPtr info;
  {
    const std::lock_guard lock(input_mutex_);
    info = info_;
  }
  if (!info)
    return fail(ErrorCode::kNotFound,
                std::string("no camera info received on ") + kInfoTopic + " yet: is it published?");
  const auto camera = ros_convert::to_camera_model(*info);
  if (!camera) return tl::unexpected(camera.error());
  auto positions = joints_->at(header.stamp);
  if (!positions) return tl::unexpected(positions.error());
  const auto world_T_root = world_frame_.world_T_root(header.stamp);
  if (!world_T_root) return tl::unexpected(world_T_root.error());
  return View{*camera, *root_T_camera, *positions, *world_T_root};
}

void DepthObstacleMonitor::begin(const View& view, double time_s) {
  const auto& box = params_.obstacles;
  if (time_s_ && time_s < *time_s_) obstacles_.clear();
  time_s_ = time_s;
  if (!view.world_T_root) return;
  if (origin_T_root_ && farthest(origin_T_root_->inverse() * *view.world_T_root, box) <= box.voxel_m) return;
  if (origin_T_root_) {
    obstacles_.clear();
    ++moves_;
  }
  origin_T_root_ = view.world_T_root;
}

Result<bool> DepthObstacleMonitor::update(const ImageView& image, const View& view, double time_s) {
  begin(view, time_s);
  const auto known = context_.scene.world();
  if (!known) return fail(ErrorCode::kNotFound, known.error().message);
  const auto done = obstacles_.update(image, view.camera, view.root_T_camera, view.positions, *known, time_s);
  if (!done) return tl::unexpected(done.error());
  latest_ = *done;
  const bool noticeable = change_detector_.changed(obstacles_.voxels(), time_s);
  if (auto set = context_.scene.set_seen(obstacles_.object(), noticeable); !set)
    return tl::unexpected(set.error());
  return noticeable;
}

void DepthObstacleMonitor::publish_voxels() {
  if (voxels_publisher_.getNumSubscribers() == 0) return;
  std::vector<Eigen::Vector3d> middles;
  {
    const std::lock_guard lock(mutex_);
    middles = obstacles_.voxels();
  }
  auto marker = voxel_marker(middles, params_.obstacles);
  marker.header.frame_id = context_.arms.root_link();
  voxels_publisher_.publish(marker);
}

void DepthObstacleMonitor::clear() {
  {
    const std::lock_guard lock(mutex_);
    obstacles_.clear();
    latest_ = {};
    if (!change_detector_.changed({}, time_s_.value_or(0.0))) return;
    [[maybe_unused]] const auto set =
        context_.scene.set_seen(std::nullopt, true);  // an empty object is always valid
  }
  context_.changed();
  publish_voxels();
}

void DepthObstacleMonitor::scene_changed() {
  {
    const std::lock_guard lock(mutex_);
    const auto known = context_.scene.world();  // the next image reports the error
    if (!known || !time_s_ || !obstacles_.forget(*known)) return;
    const bool noticeable = change_detector_.changed(obstacles_.voxels(), *time_s_);
    [[maybe_unused]] const auto set =
        context_.scene.set_seen(obstacles_.object(), noticeable);  // less than before
  }
  publish_voxels();
}

void DepthObstacleMonitor::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  status.summary(diagnostic_msgs::DiagnosticStatus::OK, "running");
  image_health_.report(status, kImageTopic, params_.timeout_s);
  info_health_.report(status, kInfoTopic, params_.timeout_s);
  work_health_.report(status);
  status.add("dropped", images_.dropped());
  {
    const std::lock_guard lock(input_mutex_);
    status.add("skipped for depth/rate_hz", skipped_);
    status.add("age of the joint states at the latest image [s]", taken_.toSec() - joints_->newest_s());
  }
  const std::lock_guard lock(mutex_);
  status.add("points", latest_.points);
  status.add("points on the robot", latest_.robot_points);
  status.add("points on known objects", latest_.object_points);
  status.add("voxels", latest_.voxels);
  status.add("boxes", latest_.boxes);
  status.add("grid of the boxes [m]", latest_.box_grid_m);
  status.add("cleared because the robot moved", moves_);
}

}  // namespace extperfc::ros_arm
