#include "ros/arm/object_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <ros/console.h>

#include "extperfc/arm/robot_overlap.hpp"
#include "extperfc/base/stopwatch.hpp"

#include "ros/convert/arm.hpp"
#include "ros/params/detector_params.hpp"

namespace extperfc::ros_arm {

namespace {

constexpr std::size_t kMaxDetections = 500;  ///< used of one message
constexpr double kNearRobot = 0.03;          ///< detections nearer to the robot are ambiguous [m]

/// The hypothesis with the highest finite score; nullptr without one.
const vision_msgs::ObjectHypothesisWithPose* best_of(const vision_msgs::Detection3D& detection) {
  const vision_msgs::ObjectHypothesisWithPose* best = nullptr;
  for (const auto& one : detection.results)
    if (std::isfinite(one.score) && (best == nullptr || one.score > best->score)) best = &one;
  return best;
}

/// Errors: invalid pose, sizes that are not positive.
Result<arm::UprightBox> box_of(const vision_msgs::BoundingBox3D& message, const Pose& frame_T_detections) {
  const Eigen::Vector3d size_m(message.size.x, message.size.y, message.size.z);
  if (!size_m.allFinite() || !(size_m.minCoeff() > 0.0))
    return fail(ErrorCode::kInvalidArgument, "size must be positive");
  const auto pose = ros_convert::to_pose(message.center);
  if (!pose) return tl::unexpected(pose.error());
  return arm::make_upright(frame_T_detections * *pose, size_m);
}

}  // namespace

Result<std::unique_ptr<ObjectMonitor>> ObjectMonitor::make(SceneMonitorContext context,
                                                           const ros_params::ObjectMonitorParams& params) {
  auto list = arm::ObjectList::make(params.list);
  if (!list) return fail(list.error().code, "objects: " + list.error().message);
  auto joints = StampedJoints::make(context.arms);
  if (!joints) return fail(joints.error().code, "objects: " + joints.error().message);
  return std::unique_ptr<ObjectMonitor>(
      new ObjectMonitor(std::move(context), params, std::move(*joints), std::move(*list)));
}

void ObjectMonitor::start(ros::NodeHandle handle) {
  worker_ = std::thread([this] {
    while (const auto message = messages_.take()) process(**message);
  });
  detections_health_.listening(true);
  joints_->start(handle);
  subscribers_.push_back(handle.subscribe(kInfoTopic, 1, &ObjectMonitor::on_info, this));
  subscribers_.push_back(handle.subscribe(kDetectionsTopic, 2, &ObjectMonitor::on_detections, this));
}

ObjectMonitor::~ObjectMonitor() {
  for (auto& subscriber : subscribers_) subscriber.shutdown();
  joints_->close();
  messages_.close();
  if (worker_.joinable()) worker_.join();
}

void ObjectMonitor::on_detections(const DetectionsEvent& event) {
  const auto& message = event.getConstMessage();
  detections_health_.received(message->header.stamp, message.get(), ros_health::came_by_pointer(event));
  messages_.put(message);
}

void ObjectMonitor::on_info(const vision_msgs::VisionInfoConstPtr& message) {
  auto names = ros_params::load_class_names(message->database_location);
  const std::lock_guard lock(mutex_);
  names_ = std::move(names);
  names_from_ = message->database_location;
}

void ObjectMonitor::process(const vision_msgs::Detection3DArray& message) {
  const Stopwatch watch;
  const auto changed = update(message);
  if (!changed) {
    // Errors of tf contain times, so that each text is new.
    if (work_health_.failed(changed.error().message))
      ROS_ERROR_STREAM_THROTTLE(5.0, "objects: " << changed.error().message);
    return;
  }
  work_health_.done(watch.milliseconds(), ros_health::age_ms(message.header.stamp));
  if (*changed) context_.changed();
}

Result<bool> ObjectMonitor::update(const vision_msgs::Detection3DArray& message) {
  const auto names = class_names();
  if (!names) return tl::unexpected(names.error());
  const auto view = view_of(message.header);
  if (!view) return tl::unexpected(view.error());
  const auto scene = known_objects(*view, message.header.stamp);
  if (!scene) return tl::unexpected(scene.error());
  const auto positions = joints_->at(message.header.stamp);
  if (!positions) return tl::unexpected(positions.error());
  const std::lock_guard lock(mutex_);
  if (view->frame != frame_) list_.clear();
  frame_ = view->frame;
  auto detections = detections_of(message, *names, *view, ignored_);
  mark_ambiguous(detections, *view, *positions);
  const auto done = list_.update(detections, *scene, message.header.stamp.toSec());
  ignored_.claimed += static_cast<std::uint64_t>(done.claimed);
  ignored_.ambiguous += static_cast<std::uint64_t>(done.ambiguous);
  ignored_.doubtful += static_cast<std::uint64_t>(done.doubtful);
  ignored_.duplicate += static_cast<std::uint64_t>(done.duplicate);
  ignored_.no_room += static_cast<std::uint64_t>(done.no_room);
  waiting_ = done.waiting;
  const auto changed = context_.scene.set_found(items(frame_));
  if (!changed) return fail(ErrorCode::kInvalidArgument, changed.error().message);
  return *changed;
}

Result<std::vector<std::string>> ObjectMonitor::class_names() {
  const std::lock_guard lock(mutex_);
  if (!names_.empty()) return names_;
  if (names_from_.empty())
    return fail(ErrorCode::kNotFound, std::string("no class names: no message on ") + kInfoTopic +
                                          " yet; is the detector's topic remapped?");
  return fail(ErrorCode::kNotFound, std::string("no class names: the parameter '") + names_from_ +
                                        "' named by " + kInfoTopic + " is not a list of strings; set it");
}

Result<ObjectMonitor::View> ObjectMonitor::view_of(const std_msgs::Header& header) {
  const auto root_T_detections = root_T_header(context_.transforms, header, kDetectionsTopic);
  if (!root_T_detections) return tl::unexpected(root_T_detections.error());
  // Without the world's frame at this stamp the message is skipped, because all objects would be lost.
  const auto world_T_root = world_frame_.world_T_root(header.stamp);
  if (!world_T_root) return tl::unexpected(world_T_root.error());
  View view;
  if (*world_T_root) {
    view.frame = context_.world_frame;
    view.frame_T_root = **world_T_root;
  }
  view.frame_T_detections = view.frame_T_root * *root_T_detections;
  return view;
}

std::vector<arm::ObjectDetection> ObjectMonitor::detections_of(const vision_msgs::Detection3DArray& message,
                                                               const std::vector<std::string>& names,
                                                               const View& view, Ignored& ignored) const {
  std::vector<arm::ObjectDetection> detections;
  for (const auto& detection : message.detections) {
    if (detections.size() >= kMaxDetections) {
      ++ignored.too_many;
      continue;
    }
    const auto* best = best_of(detection);
    auto box = box_of(detection.bbox, view.frame_T_detections);
    if (best == nullptr || !box) {
      ++ignored.broken;
    } else if (best->score < params_.min_score) {
      ++ignored.low_score;
    } else if (box->size_m.maxCoeff() > params_.largest_m) {
      ++ignored.too_large;
    } else if (best->id < 0 || best->id >= static_cast<std::int64_t>(names.size()) ||
               names[static_cast<std::size_t>(best->id)].empty()) {
      ++ignored.unknown_class;
    } else {
      const auto& label = names[static_cast<std::size_t>(best->id)];
      if (arm::is_round(kind_of(label))) box->yaw_rad = 0.0;
      detections.push_back({label, *box, false, best->score});
    }
  }
  return detections;
}

void ObjectMonitor::mark_ambiguous(std::vector<arm::ObjectDetection>& detections, const View& view,
                                   const arm::JointVector& positions) const {
  const Pose root_T_frame = view.frame_T_root.inverse();
  std::vector<Shape> shapes;
  shapes.reserve(detections.size());
  for (const auto& detection : detections) {
    Shape shape;
    shape.geometry = arm::shape_in(kind_of(detection.label),
                                   detection.box.size_m + Eigen::Vector3d::Constant(2.0 * kNearRobot));
    shape.body_T_shape = root_T_frame * arm::pose_of(detection.box);
    shapes.push_back(std::move(shape));
  }
  const auto ambiguous = arm::robot_overlaps(joints_->model(), positions, shapes);
  for (std::size_t i = 0; i < detections.size(); ++i) detections[i].ambiguous = ambiguous[i];
}

/// Everything in the scene, in the view's frame.
Result<std::vector<arm::KnownObject>> ObjectMonitor::known_objects(const View& view,
                                                                   const ros::Time& stamp) const {
  std::vector<arm::KnownObject> all;
  for (auto& item : context_.scene.items()) {
    arm::KnownObject known{
        std::move(item.name), std::move(item.label), item.frame_T_object, item.found, item.still, {}};
    if (item.held) {
      // Its own position and the gripper's, now and at the stamp.
      const auto now = context_.transforms.root_T_frame(item.frame, ros::Time());
      if (!now) return fail(ErrorCode::kNotFound, now.error().message);
      const Pose frame_T_link = view.frame_T_root * *now;
      known.world_T_object = frame_T_link * item.frame_T_object;
      known.places.emplace_back(frame_T_link.translation());
      if (const auto then = context_.transforms.root_T_frame(item.frame, stamp)) {
        known.places.emplace_back((view.frame_T_root * *then).translation());
        known.places.emplace_back((view.frame_T_root * *then * item.frame_T_object).translation());
      }
    } else if (item.frame != view.frame) {
      const auto root_T_frame = context_.transforms.root_T_frame(item.frame, ros::Time());
      if (!root_T_frame) return fail(ErrorCode::kNotFound, root_T_frame.error().message);
      known.world_T_object = view.frame_T_root * *root_T_frame * item.frame_T_object;
    }
    all.push_back(std::move(known));
  }
  return all;
}

/// The list as objects of the scene.
std::vector<CollisionObject> ObjectMonitor::items(const std::string& frame) const {
  std::vector<CollisionObject> all;
  for (const auto& object : list_.objects()) {
    CollisionObject item;
    item.name = object.name;
    item.label = object.label;
    Shape shape;
    shape.geometry = arm::shape_in(kind_of(object.label), object.size_m);
    item.shapes.push_back(std::move(shape));
    item.frame = frame;
    item.frame_T_object = object.world_T_object;
    item.found = true;
    all.push_back(std::move(item));
  }
  return all;
}

arm::UprightKind ObjectMonitor::kind_of(const std::string& label) const {
  const auto found = params_.shapes.find(label);
  return found == params_.shapes.end() ? arm::UprightKind::kBox : found->second;
}

void ObjectMonitor::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  status.summary(diagnostic_msgs::DiagnosticStatus::OK, "running");
  detections_health_.report(status, kDetectionsTopic, params_.timeout_s);
  work_health_.report(status);
  status.add("dropped", messages_.dropped());
  const std::lock_guard lock(mutex_);
  status.add("classes", names_.size());
  status.add("objects", list_.objects().size());
  status.add("objects waiting for objects/confirm or objects/max_objects", waiting_);
  status.add("ignored: invalid pose, size or score", ignored_.broken);
  status.add("ignored: class without a name", ignored_.unknown_class);
  status.add("ignored: below objects/min_score", ignored_.low_score);
  status.add("ignored: above objects/largest_m", ignored_.too_large);
  status.add("ignored: too many in one message", ignored_.too_many);
  status.add("ignored: held or already in the scene", ignored_.claimed);
  status.add("ignored: at the robot", ignored_.ambiguous);
  status.add("ignored: below objects/new_score, at no object", ignored_.doubtful);
  status.add("ignored: inside another object", ignored_.duplicate);
  status.add("ignored: more than objects/max_objects", ignored_.no_room);
}

}  // namespace extperfc::ros_arm
