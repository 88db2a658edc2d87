#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <diagnostic_updater/DiagnosticStatusWrapper.h>
#include <ros/node_handle.h>
#include <vision_msgs/Detection3DArray.h>
#include <vision_msgs/VisionInfo.h>

#include "extperfc/arm/object_list.hpp"
#include "extperfc/base/latest_slot.hpp"

#include "ros/arm/scene_monitor.hpp"
#include "ros/arm/stamped_joints.hpp"
#include "ros/health/stream_health.hpp"
#include "ros/params/arm_params.hpp"

namespace extperfc::ros_arm {

/// Adds the objects that a detector finds to the planning scene, each as <class>_<n> with its class as the
/// label.
///
/// Subscribes (with objects/enabled):
///   detections_3d   vision_msgs/Detection3DArray: uses bbox.center, bbox.size and the hypothesis with
///                   the highest score
///   vision_info     vision_msgs/VisionInfo: database_location names the parameter with the class names
///   robot/joint_states   sensor_msgs/JointState: posture of the robot at the detections' stamp
/// Parameters: the group objects of config/arm.yaml
/// Frames: the detections' frame and world_frame to the root link at the detections' stamp. A robot whose tf
///   has no world_frame is assumed to stand still. Objects stand upright: see arm::make_upright().
/// A detection within 30 mm of the robot is ambiguous: it may show the robot itself or a partly hidden
///   object. It neither adds nor moves an object, but it prevents a matching object from expiring.
/// Objects that a gripper holds or is about to grasp (PlanningScene::hold) and objects added by
///   arm/apply_scene stay unchanged; detections of the same class near them, or near the gripper that holds
///   them, are ignored.
/// Diagnostics: rate, latency, objects, what was ignored and why; ERROR while detections cannot be used.
/// Threads: callbacks store the input; one worker computes. The latest message replaces a waiting one. Lock
///   order: this object before the scene.
class ObjectMonitor {
 public:
  /// Errors: parameters out of their ranges, a robot without collision shapes that can be read.
  [[nodiscard]] static Result<std::unique_ptr<ObjectMonitor>> make(
      SceneMonitorContext context, const ros_params::ObjectMonitorParams& params);
  ~ObjectMonitor();
  ObjectMonitor(const ObjectMonitor&) = delete;
  ObjectMonitor& operator=(const ObjectMonitor&) = delete;

  /// Subscribes and starts to work. Call once.
  void start(ros::NodeHandle handle);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  // Events instead of plain messages, because they contain the publisher.
  using DetectionsEvent = ros::MessageEvent<const vision_msgs::Detection3DArray>;
  static constexpr const char* kDetectionsTopic = "detections_3d";
  static constexpr const char* kInfoTopic = "vision_info";

  /// Frames at the stamp of a message.
  struct View {
    std::string frame;  ///< in which objects stand still
    Pose frame_T_root{Pose::Identity()};
    Pose frame_T_detections{Pose::Identity()};
  };
  /// Ignored detections since the start, by reason.
  struct Ignored {
    std::uint64_t broken{0}, unknown_class{0}, low_score{0}, too_large{0}, too_many{0}, claimed{0},
        ambiguous{0}, doubtful{0}, duplicate{0}, no_room{0};
  };

  ObjectMonitor(SceneMonitorContext context, const ros_params::ObjectMonitorParams& params,
                std::unique_ptr<StampedJoints> joints, arm::ObjectList list)
      : context_(std::move(context)),
        params_(params),
        joints_(std::move(joints)),
        world_frame_(context_.transforms, context_.world_frame),
        list_(std::move(list)) {}
  void on_detections(const DetectionsEvent& event);
  void on_info(const vision_msgs::VisionInfoConstPtr& message);

  void process(const vision_msgs::Detection3DArray& message);
  /// True when the scene's version increased.
  [[nodiscard]] Result<bool> update(const vision_msgs::Detection3DArray& message);
  [[nodiscard]] Result<View> view_of(const std_msgs::Header& header);
  [[nodiscard]] Result<std::vector<std::string>> class_names();
  [[nodiscard]] std::vector<arm::ObjectDetection> detections_of(const vision_msgs::Detection3DArray& message,
                                                                const std::vector<std::string>& names,
                                                                const View& view, Ignored& ignored) const;
  /// Marks the detections that overlap the robot.
  void mark_ambiguous(std::vector<arm::ObjectDetection>& detections, const View& view,
                      const arm::JointVector& positions) const;
  [[nodiscard]] Result<std::vector<arm::KnownObject>> known_objects(const View& view,
                                                                    const ros::Time& stamp) const;
  [[nodiscard]] std::vector<CollisionObject> items(const std::string& frame) const;
  [[nodiscard]] arm::UprightKind kind_of(const std::string& label) const;

  const SceneMonitorContext context_;  ///< `changed` is called by the worker
  const ros_params::ObjectMonitorParams params_;
  ros_health::InputHealth detections_health_{"detections"};
  ros_health::WorkHealth work_health_;
  const std::unique_ptr<StampedJoints> joints_;

  WorldFrame world_frame_;  ///< used by the worker only

  std::mutex mutex_;  ///< guards what follows
  arm::ObjectList list_;
  std::string frame_;  ///< of the list
  std::vector<std::string> names_;
  std::string names_from_;  ///< the parameter
  Ignored ignored_;
  int waiting_{0};

  LatestSlot<vision_msgs::Detection3DArrayConstPtr> messages_;
  std::thread worker_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace extperfc::ros_arm
