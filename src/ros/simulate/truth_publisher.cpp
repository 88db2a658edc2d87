#include "ros/simulate/truth_publisher.hpp"

#include <utility>

#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Odometry.h>
#include <std_msgs/Bool.h>
#include <vision_msgs/Detection3DArray.h>
#include <vision_msgs/VisionInfo.h>

#include "extperfc/simulate/floor_plan.hpp"

#include "ros/convert/geometry.hpp"
#include "ros/simulate/body_extent.hpp"
#include "ros/simulate/frames.hpp"

namespace extperfc::ros_simulate {

namespace {

constexpr bool kLatched = true;
constexpr double kExact = 1e-9;  ///< variance of the truth

Eigen::AlignedBox3d person_extent() {
  return {Eigen::Vector3d(-0.25, -0.25, 0), Eigen::Vector3d(0.25, 0.25, 1.75)};
}

vision_msgs::Detection3D to_detection(int class_id, const Pose& map_T_object,
                                      const Eigen::AlignedBox3d& extent, const std_msgs::Header& header) {
  vision_msgs::Detection3D detection;
  detection.header = header;
  detection.results.resize(1);
  detection.results[0].id = class_id;
  detection.results[0].score = 1.0;
  detection.bbox.center = ros_convert::to_message(map_T_object * make_pose(extent.center()));
  detection.bbox.size = ros_convert::to_vector(extent.sizes());
  detection.results[0].pose.pose = detection.bbox.center;
  detection.results[0].pose.covariance = ros_convert::planar_covariance(kExact, kExact, kExact);
  return detection;
}

}  // namespace

TruthPublisher::TruthPublisher(ros::NodeHandle handle, const ros::NodeHandle& private_handle, SimHost& host,
                               const ros_params::TruthParams& params, const simulate::WorldSpec& world,
                               const TruthClasses& classes)
    : host_(host),
      markers_(world),
      odom_ticker_(params.odom_rate_hz),
      objects_ticker_(params.objects_rate_hz),
      markers_ticker_(params.markers_rate_hz),
      odom_publisher_(handle.advertise<nav_msgs::Odometry>("sim/truth/odom", 10)),
      blocked_publisher_(handle.advertise<std_msgs::Bool>("sim/truth/blocked", 5, kLatched)),
      objects_publisher_(handle.advertise<vision_msgs::Detection3DArray>("sim/truth/objects", 5)),
      map_publisher_(handle.advertise<nav_msgs::OccupancyGrid>("sim/truth/map", 1, kLatched)),
      vision_info_publisher_(
          handle.advertise<vision_msgs::VisionInfo>("sim/truth/vision_info", 1, kLatched)) {
  find_objects(world, classes);
  publish_vision_info(private_handle);
  host.after_step(
      [this](const simulate::Simulator& simulator, const ros::Time& stamp) { after_step(simulator, stamp); });
  advertise_markers(handle);
}

void TruthPublisher::find_objects(const simulate::WorldSpec& world, const TruthClasses& classes) {
  for (std::size_t i = 0; i < world.bodies.size(); ++i)
    if (const int id = classes.id(world.bodies[i].label); id >= 0)
      objects_.push_back({i, false, id, extent_of(world.bodies[i])});
  for (std::size_t i = 0; i < world.people.size(); ++i)
    objects_.push_back({i, true, classes.id("person"), person_extent()});
}

Result<void> TruthPublisher::publish_map(const simulate::WorldSpec& world,
                                         const ros_params::TruthParams& params) {
  auto plan = simulate::floor_plan(world, params.map_resolution_m, params.map_min_z_m, params.map_max_z_m);
  if (!plan) return tl::unexpected(plan.error());
  const auto grid = boost::make_shared<nav_msgs::OccupancyGrid>();
  grid->header.frame_id = kMapFrame;
  grid->info.resolution = static_cast<float>(plan->resolution_m);
  grid->info.width = static_cast<std::uint32_t>(plan->width);
  grid->info.height = static_cast<std::uint32_t>(plan->height);
  grid->info.origin.position = ros_convert::to_point({plan->origin_m.x(), plan->origin_m.y(), 0});
  grid->info.origin.orientation.w = 1.0;
  grid->data.assign(plan->data.begin(), plan->data.end());
  map_publisher_.publish(grid);
  return {};
}

void TruthPublisher::publish_vision_info(const ros::NodeHandle& private_handle) {
  vision_msgs::VisionInfo info;
  info.method = "ground truth";
  info.database_location = private_handle.resolveName("classes");
  vision_info_publisher_.publish(info);
}

/// A new listener gets everything, and the others once more, from the simulation thread, which alone knows
/// where objects are.
void TruthPublisher::advertise_markers(ros::NodeHandle& handle) {
  const auto connected = [this](const ros::SingleSubscriberPublisher&) {
    host_.post([this](simulate::Simulator& simulator) {
      markers_publisher_.publish(
          boost::make_shared<visualization_msgs::MarkerArray>(markers_.all(simulator.snapshot(), stamp_)));
    });
  };
  markers_publisher_ = handle.advertise<visualization_msgs::MarkerArray>("sim/world_markers", 5, connected);
}

void TruthPublisher::after_step(const simulate::Simulator& simulator, const ros::Time& stamp) {
  const double time_s = simulator.time_s();
  stamp_ = stamp;
  publish_blocked(simulator.base_state().blocked);
  if (odom_ticker_.due(time_s) && odom_publisher_.getNumSubscribers() > 0)
    publish_odometry(simulator.base_state(), stamp);
  const bool objects = objects_ticker_.due(time_s) && objects_publisher_.getNumSubscribers() > 0;
  const bool markers = markers_ticker_.due(time_s) && markers_publisher_.getNumSubscribers() > 0;
  if (!objects && !markers) return;
  const auto snapshot = simulator.snapshot();
  if (objects) publish_objects(snapshot, stamp);
  if (!markers) return;
  if (auto moved = markers_.moved(snapshot, stamp); !moved.markers.empty())
    markers_publisher_.publish(boost::make_shared<visualization_msgs::MarkerArray>(std::move(moved)));
}

void TruthPublisher::publish_blocked(bool blocked) {
  if (blocked_ == blocked) return;
  blocked_ = blocked;
  const auto message = boost::make_shared<std_msgs::Bool>();
  message->data = blocked ? 1U : 0U;
  blocked_publisher_.publish(message);
}

void TruthPublisher::publish_odometry(const simulate::BaseState& base, const ros::Time& stamp) {
  const auto message = boost::make_shared<nav_msgs::Odometry>();
  message->header.stamp = stamp;
  message->header.frame_id = kMapFrame;
  message->child_frame_id = kFootprintFrame;
  message->pose.pose = ros_convert::to_message(to_pose(base.truth));
  message->pose.covariance = ros_convert::planar_covariance(kExact, kExact, kExact);
  message->twist.twist = ros_convert::to_message(base.velocity);
  message->twist.covariance = message->pose.covariance;
  odom_publisher_.publish(message);
}

void TruthPublisher::publish_objects(const simulate::Snapshot& snapshot, const ros::Time& stamp) {
  const auto message = boost::make_shared<vision_msgs::Detection3DArray>();
  message->header.stamp = stamp;
  message->header.frame_id = kMapFrame;
  for (const auto& object : objects_) {
    const Pose pose = object.is_person ? to_pose(snapshot.world_T_person[object.index])
                                       : snapshot.world_T_body[object.index];
    message->detections.push_back(to_detection(object.class_id, pose, object.extent, message->header));
  }
  objects_publisher_.publish(message);
}

}  // namespace extperfc::ros_simulate
