#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <tf2_ros/transform_broadcaster.h>

#include "extperfc/base/latest_slot.hpp"
#include "extperfc/sources/recording.hpp"

#include "ros/params/source_params.hpp"

namespace extperfc::ros_sources {

/// Plays a recording as an RGB-D camera would publish it; shared by the nodelets that differ only in what
/// they open. Images travel as pointers inside one manager; `color last` and `depth last` in diagnostics are
/// stamp and address of what was published, which every subscriber in the manager reports too.
///
/// Publishes (all with one stamp):
///   camera/color/image_raw                     sensor_msgs/Image
///   camera/color/camera_info                   sensor_msgs/CameraInfo
///   camera/aligned_depth_to_color/image_raw    sensor_msgs/Image, 16UC1 [mm]
///   camera/aligned_depth_to_color/camera_info  sensor_msgs/CameraInfo
///   /tf                                        tf2_msgs/TFMessage: world_frame -> frame_id, when the
///                                              recording has its camera's poses
/// Threads: one that reads ahead by one frame and keeps the rate.
class RecordingPlayer {
 public:
  RecordingPlayer(ros::NodeHandle handle, ros_params::SourceParams params,
                  std::unique_ptr<sources::Recording> recording);
  ~RecordingPlayer();
  RecordingPlayer(const RecordingPlayer&) = delete;
  RecordingPlayer& operator=(const RecordingPlayer&) = delete;

  void report(diagnostic_updater::DiagnosticStatusWrapper& status) const;

 private:
  struct Messages {
    sensor_msgs::ImagePtr color;
    sensor_msgs::ImagePtr depth;
    std::optional<geometry_msgs::Transform> world_T_optical;
    double recorded_s{0};
  };

  void play();
  bool wait_for_listener();
  bool sleep_until(ros::WallTime when);
  std::optional<Messages> read(std::size_t index);
  void publish(const Messages& messages);
  void remember(const Messages& messages);
  CameraModel camera_of(const sensor_msgs::Image& image);
  [[nodiscard]] double period_to(const Messages& previous, const Messages& next) const;

  ros_params::SourceParams params_;
  std::unique_ptr<sources::Recording> recording_;
  std::optional<CameraModel> camera_;
  ros::Publisher color_publisher_;
  ros::Publisher color_info_publisher_;
  ros::Publisher depth_publisher_;
  ros::Publisher depth_info_publisher_;
  tf2_ros::TransformBroadcaster tf_broadcaster_;

  LatestSlot<bool> stop_;  ///< never filled: closing it ends the thread's waits
  std::atomic<bool> stopping_{false};
  std::atomic<bool> finished_{false};
  std::atomic<std::uint64_t> played_{0};
  std::atomic<std::uint64_t> unreadable_{0};

  mutable std::mutex last_mutex_;
  Messages last_;  ///< what was published last; kept, so that its address stays its own until the next

  std::thread thread_;
};

}  // namespace extperfc::ros_sources
