#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <diagnostic_updater/DiagnosticStatusWrapper.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include "extperfc/arm/depth_obstacles.hpp"
#include "extperfc/arm/voxel_change_detector.hpp"
#include "extperfc/base/latest_slot.hpp"

#include "ros/arm/scene_monitor.hpp"
#include "ros/arm/stamped_joints.hpp"
#include "ros/health/stream_health.hpp"
#include "ros/params/arm_params.hpp"

namespace extperfc::ros_arm {

/// Adds what a depth camera sees to the planning scene, as the object PlanningScene::kSeenName.
///
/// Subscribes (with depth/enabled):
///   camera/aligned_depth_to_color/image_raw     sensor_msgs/Image 16UC1 [mm] or 32FC1 [m]
///   camera/aligned_depth_to_color/camera_info   sensor_msgs/CameraInfo of the same image size
///   robot/joint_states                          sensor_msgs/JointState: removes the robot from an image, in
///                                               its posture at the image's stamp
/// Publishes:
///   arm/depth_voxels                            visualization_msgs/Marker, while it has subscribers: the voxels in the frame of the
///                                               robot's root, coloured by height, after every image
/// Parameters: the group depth of config/arm.yaml
/// Frames: the image's frame and world_frame to the root link at the image's stamp. When the root moves in
///   world_frame by more than a voxel, all voxels are cleared. Without world_frame in tf the robot is assumed
///   to stand still.
/// Diagnostics: rates, latency, points, voxels and boxes; ERROR while images cannot be used.
/// Threads: callbacks store the input; one worker computes. The latest image replaces a waiting one. Lock
///   order: this object before the scene.
class DepthObstacleMonitor {
 public:
  /// Errors: parameters that do not fit each other, a robot without collision shapes that can be read.
  [[nodiscard]] static Result<std::unique_ptr<DepthObstacleMonitor>> make(
      SceneMonitorContext context, const ros_params::DepthObstacleMonitorParams& params);
  ~DepthObstacleMonitor();
  DepthObstacleMonitor(const DepthObstacleMonitor&) = delete;
  DepthObstacleMonitor& operator=(const DepthObstacleMonitor&) = delete;

  /// Subscribes and starts to work. Call once.
  void start(ros::NodeHandle handle);

  /// Clears all voxels; the next image adds those that it shows again.
  void clear();
  /// Call when objects were added to the scene or moved: voxels on them are cleared at once. Otherwise the
  /// voxels of an object that was seen before it was known would block the fingers that grasp it.
  void scene_changed();
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  // Events instead of plain messages, because they contain the publisher.
  using ImageEvent = ros::MessageEvent<const sensor_msgs::Image>;
  using InfoEvent = ros::MessageEvent<const sensor_msgs::CameraInfo>;
  static constexpr const char* kImageTopic = "camera/aligned_depth_to_color/image_raw";
  static constexpr const char* kInfoTopic = "camera/aligned_depth_to_color/camera_info";
  static constexpr const char* kVoxelsTopic = "arm/depth_voxels";

  /// Camera, poses and joint positions at the stamp of an image.
  struct View {
    CameraModel camera;
    Pose root_T_camera;
    arm::JointVector positions;
    std::optional<Pose> world_T_root;
  };

  DepthObstacleMonitor(SceneMonitorContext context, const ros_params::DepthObstacleMonitorParams& params,
                       std::unique_ptr<StampedJoints> joints, arm::DepthObstacles obstacles);
  void on_image(const ImageEvent& event);
  void on_info(const InfoEvent& event);

  void process(const sensor_msgs::ImageConstPtr& message);
  [[nodiscard]] Result<View> view_of(const std_msgs::Header& header);
  /// Clears voxels of another pose of the robot or an older clock; under mutex_.
  void begin(const View& view, double time_s);
  /// Under mutex_; true when the scene's version increased.
  [[nodiscard]] Result<bool> update(const ImageView& image, const View& view, double time_s);
  void publish_voxels();

  const SceneMonitorContext context_;  ///< `changed` is called by the worker and by clear()
  const ros_params::DepthObstacleMonitorParams params_;
  ros_health::InputHealth image_health_{"depth"};
  ros_health::InputHealth info_health_{"camera info"};
  ros_health::WorkHealth work_health_;
  const std::unique_ptr<StampedJoints> joints_;

  std::mutex input_mutex_;  ///< guards what follows
  sensor_msgs::CameraInfoConstPtr info_;
  ros::Time taken_;  ///< stamp of the image that was accepted last
  std::uint64_t skipped_{0};

  WorldFrame world_frame_;  ///< used by the worker only

  std::mutex mutex_;  ///< guards what follows
  arm::DepthObstacles obstacles_;
  arm::VoxelChangeDetector change_detector_;
  std::optional<Pose> origin_T_root_;  ///< in world_frame, of the voxels
  std::optional<double> time_s_;       ///< of the latest image
  arm::DepthUpdate latest_;
  std::uint64_t moves_{0};  ///< how often motion of the robot cleared all voxels

  ros::Publisher voxels_publisher_;
  LatestSlot<sensor_msgs::ImageConstPtr> images_;
  std::thread worker_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace extperfc::ros_arm
