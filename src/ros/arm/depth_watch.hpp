#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
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
#include "extperfc/arm/robot_arms.hpp"
#include "extperfc/arm/voxel_news.hpp"
#include "extperfc/base/latest_slot.hpp"

#include "ros/arm/frame_finder.hpp"
#include "ros/arm/scene_keeper.hpp"
#include "ros/arm/stamped_joints.hpp"
#include "ros/health/stream_health.hpp"
#include "ros/params/arm_params.hpp"

namespace extperfc::arm_node {

/// Keeps what a depth camera sees in the scene, as its object SceneKeeper::kSeenName.
///
/// Subscribes:
///   camera/aligned_depth_to_color/image_raw     sensor_msgs/Image 16UC1 [mm] or 32FC1 [m]
///   camera/aligned_depth_to_color/camera_info   sensor_msgs/CameraInfo, of the picture's size
///   robot/joint_states                          sensor_msgs/JointState: the robot is taken out of a picture
///                                               as it stood at the picture's stamp
/// Publishes, while somebody listens:
///   arm/depth_voxels                            visualization_msgs/Marker: the voxels in the frame of the
///                                               robot's root, coloured by height, after every picture
/// Parameters: ros_params::DepthWatchParams
/// Frames: the picture's frame and world_frame to the root link at the picture's stamp. When the root moves
/// in
///   world_frame by more than a voxel, what was seen before is forgotten. A robot whose tf has no world_frame
///   counts as standing still.
/// Diagnostics: rates, latency, points, voxels and boxes; ERROR while pictures cannot be used.
/// Threads: callbacks store; one worker computes. The newest picture replaces one that waits. Lock order:
///   this before the scene.
class DepthWatch {
 public:
  struct Uses {
    const arm::RobotArms& arms;
    const FrameFinder& frames;
    SceneKeeper& scene;
    std::string world_frame;
    std::function<void()> changed;  ///< called by the worker and by clear() when the scene's version grew
  };

  /// Errors: parameters that do not fit each other, a robot without collision shapes that can be read.
  [[nodiscard]] static Result<std::unique_ptr<DepthWatch>> make(Uses uses,
                                                                const ros_params::DepthWatchParams& params);
  ~DepthWatch();
  DepthWatch(const DepthWatch&) = delete;
  DepthWatch& operator=(const DepthWatch&) = delete;

  /// Once: subscribes, and works from then on.
  void start(ros::NodeHandle handle);

  /// Forgets all voxels; those that the next picture sees come again.
  void clear();
  /// To be called when things came into the scene or moved there: voxels on them are forgotten at once, so
  /// that a thing seen before it was known is not in the way of the fingers that shall hold it.
  void scene_changed();
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  // Events instead of plain messages, because they know their publisher.
  using PictureEvent = ros::MessageEvent<const sensor_msgs::Image>;
  using InfoEvent = ros::MessageEvent<const sensor_msgs::CameraInfo>;
  static constexpr const char* kPictureTopic = "camera/aligned_depth_to_color/image_raw";
  static constexpr const char* kInfoTopic = "camera/aligned_depth_to_color/camera_info";
  static constexpr const char* kVoxelsTopic = "arm/depth_voxels";

  /// What belongs to a picture.
  struct View {
    CameraModel camera;
    Pose root_T_camera;
    arm::JointVector positions;
    std::optional<Pose> world_T_root;
  };

  DepthWatch(Uses uses, const ros_params::DepthWatchParams& params, std::unique_ptr<StampedJoints> joints,
             arm::DepthObstacles obstacles);
  void on_picture(const PictureEvent& event);
  void on_info(const InfoEvent& event);

  void process(const sensor_msgs::ImageConstPtr& picture);
  [[nodiscard]] Result<View> view_of(const std_msgs::Header& header);
  [[nodiscard]] std::optional<Pose> world_T_root(const ros::Time& stamp);
  /// Forgets what does not belong to this picture's place and time; under mutex_.
  void begin(const View& view, double time_s);
  /// Under mutex_; true when the scene's version grew.
  [[nodiscard]] Result<bool> update(const ImageView& picture, const View& view, double time_s);
  void show_voxels();

  const Uses uses_;
  const ros_params::DepthWatchParams params_;
  health::InputHealth picture_health_{"depth"};
  health::InputHealth info_health_{"camera info"};
  health::WorkHealth work_health_;
  const std::unique_ptr<StampedJoints> joints_;

  std::mutex input_mutex_;  ///< guards what follows
  sensor_msgs::CameraInfoConstPtr info_;
  ros::Time taken_;  ///< stamp of the picture that was let in last
  std::uint64_t passed_over_{0};

  ros::WallTime no_world_;  ///< when tf did not have world_frame; the worker's own

  std::mutex mutex_;  ///< guards what follows
  arm::DepthObstacles obstacles_;
  arm::VoxelNews news_;
  std::optional<Pose> origin_T_root_;  ///< in world_frame, of the voxels
  std::optional<double> time_s_;       ///< of the latest picture
  arm::DepthUpdate latest_;
  std::uint64_t moves_{0};  ///< how often the robot's moving made all voxels void

  ros::Publisher voxels_publisher_;
  LatestSlot<sensor_msgs::ImageConstPtr> pictures_;
  std::thread worker_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace extperfc::arm_node
