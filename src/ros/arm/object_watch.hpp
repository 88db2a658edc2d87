#pragma once

#include <cstdint>
#include <functional>
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
#include "extperfc/arm/robot_arms.hpp"
#include "extperfc/base/latest_slot.hpp"

#include "ros/arm/frame_finder.hpp"
#include "ros/arm/scene_keeper.hpp"
#include "ros/arm/stamped_joints.hpp"
#include "ros/health/stream_health.hpp"
#include "ros/params/arm_params.hpp"

namespace extperfc::arm_node {

/// Keeps the objects that a detector finds in the scene, each as <class>_<n> with its class as the label.
///
/// Subscribes:
///   detections_3d   vision_msgs/Detection3DArray: bbox.center and bbox.size count, and the hypothesis with
///   the
///                   highest score
///   vision_info     vision_msgs/VisionInfo: database_location names the parameter with the class names
///   robot/joint_states   sensor_msgs/JointState: where the robot was at the detections' stamp
/// Parameters: ros_params::ObjectWatchParams
/// Frames: the detections' frame and world_frame to the root link at the detections' stamp. A robot whose tf
///   has no world_frame counts as standing still. What stands is upright: see arm::stand_up().
/// A detection within 10 mm of the robot is taken for a part of the robot, or of a thing that it hides: it
///   neither makes nor moves an object, but the one that it may be stays.
/// What hands hold, what they grasp for (SceneKeeper::hold) and what callers of arm/apply_scene put into the
/// scene
///   stays as it is; detections of the same class near it, or near the hand that holds it, are ignored.
/// Diagnostics: rate, latency, objects, what was ignored and why; ERROR while detections cannot be used.
/// Threads: callbacks store; one worker computes. The newest message replaces one that waits. Lock order:
/// this
///   before the scene.
class ObjectWatch {
 public:
  struct Uses {
    const arm::RobotArms& arms;
    const FrameFinder& frames;
    SceneKeeper& scene;
    std::string world_frame;
    std::function<void()> changed;  ///< called by the worker when the scene's version grew
  };

  /// Errors: parameters out of their ranges, a robot without collision shapes that can be read.
  [[nodiscard]] static Result<std::unique_ptr<ObjectWatch>> make(Uses uses,
                                                                 const ros_params::ObjectWatchParams& params);
  ~ObjectWatch();
  ObjectWatch(const ObjectWatch&) = delete;
  ObjectWatch& operator=(const ObjectWatch&) = delete;

  /// Once: subscribes, and works from then on.
  void start(ros::NodeHandle handle);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  // Events instead of plain messages, because they know their publisher.
  using DetectionsEvent = ros::MessageEvent<const vision_msgs::Detection3DArray>;
  static constexpr const char* kDetectionsTopic = "detections_3d";
  static constexpr const char* kInfoTopic = "vision_info";

  /// What belongs to a message.
  struct View {
    std::string frame;  ///< that objects stand still in
    Pose frame_T_root{Pose::Identity()};
    Pose frame_T_detections{Pose::Identity()};
  };
  /// Detections that came to nothing since the start.
  struct Ignored {
    std::uint64_t broken{0}, unknown_class{0}, low_score{0}, too_large{0}, too_many{0}, claimed{0}, vague{0},
        doubled{0}, no_room{0};
  };

  ObjectWatch(Uses uses, const ros_params::ObjectWatchParams& params, std::unique_ptr<StampedJoints> joints,
              arm::ObjectList list)
      : uses_(std::move(uses)), params_(params), joints_(std::move(joints)), list_(std::move(list)) {}
  void on_detections(const DetectionsEvent& event);
  void on_info(const vision_msgs::VisionInfoConstPtr& message);

  void process(const vision_msgs::Detection3DArray& message);
  /// True when the scene's version grew.
  [[nodiscard]] Result<bool> update(const vision_msgs::Detection3DArray& message);
  [[nodiscard]] Result<View> view_of(const std_msgs::Header& header);
  [[nodiscard]] Result<std::vector<std::string>> class_names();
  [[nodiscard]] std::vector<arm::ObjectSighting> sightings_of(const vision_msgs::Detection3DArray& message,
                                                              const std::vector<std::string>& names,
                                                              const View& view, Ignored& ignored) const;
  /// Those at the robot are.
  void mark_vague(std::vector<arm::ObjectSighting>& sightings, const View& view,
                  const arm::JointVector& positions) const;
  [[nodiscard]] Result<std::vector<arm::SceneThing>> things(const View& view, const ros::Time& stamp) const;
  [[nodiscard]] std::vector<SceneItem> items(const std::string& frame) const;
  [[nodiscard]] arm::StandingKind kind_of(const std::string& label) const;

  const Uses uses_;
  const ros_params::ObjectWatchParams params_;
  health::InputHealth detections_health_{"detections"};
  health::WorkHealth work_health_;
  const std::unique_ptr<StampedJoints> joints_;

  ros::WallTime no_world_;  ///< when tf did not have world_frame; the worker's own

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

}  // namespace extperfc::arm_node
