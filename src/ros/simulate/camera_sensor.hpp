#pragma once

#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>

#include "ros/params/simulator_params.hpp"
#include "ros/simulate/sensor.hpp"
#include "ros/simulate/sensor_faults.hpp"
#include "ros/simulate/truth_classes.hpp"

namespace extperfc::ros_simulate {

/// The RGB-D camera, as the RealSense's driver with depth aligned to colour shows it. Faults spoil the
/// images, not the truth, and while the camera is frozen the truth is that of its image.
///
/// Publishes (one stamp, in camera_color_optical_frame; while there are subscribers):
///   camera/color/image_raw                     sensor_msgs/Image, rgb8
///   camera/color/camera_info                   sensor_msgs/CameraInfo
///   camera/aligned_depth_to_color/image_raw    sensor_msgs/Image, 16UC1 [mm] or 32FC1 [m]
///   camera/aligned_depth_to_color/camera_info  sensor_msgs/CameraInfo
///   sim/truth/labels                           sensor_msgs/Image, 16UC1: index of what each pixel shows into
///                                              ~instances
///   sim/truth/detections                       vision_msgs/Detection2DArray: visible boxes of objects that
///                                              have a class
class CameraSensor : public Sensor {
 public:
  /// Errors: the robot has no camera frame.
  [[nodiscard]] static Result<std::unique_ptr<CameraSensor>> make(
      const ros::NodeHandle& handle, const ros_params::CameraInterfaceParams& params, const RobotModel& robot,
      std::uint64_t seed, const TruthClasses& classes);

  [[nodiscard]] const char* name() const override { return "camera"; }
  [[nodiscard]] double rate_hz() const override { return params_.rate_hz; }
  [[nodiscard]] bool wanted() const override;
  bool measure(simulate::SensorRig& rig, const SensorJob& job) override;
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> details() const override;

 private:
  CameraSensor(const ros::NodeHandle& handle, const ros_params::CameraInterfaceParams& params, int link,
               std::uint64_t seed, const TruthClasses& classes);
  [[nodiscard]] bool images_wanted() const;
  void publish_truth(simulate::SensorRig& rig, const std_msgs::Header& header);
  void publish_images(const std_msgs::Header& header);
  [[nodiscard]] sensor_msgs::ImagePtr depth_message(const std_msgs::Header& header) const;

  const ros_params::CameraInterfaceParams params_;
  const int link_;
  const TruthClasses classes_;
  image_transport::ImageTransport transport_;
  image_transport::Publisher color_publisher_;
  image_transport::Publisher depth_publisher_;
  image_transport::Publisher labels_publisher_;
  ros::Publisher color_info_publisher_;
  ros::Publisher depth_info_publisher_;
  ros::Publisher detections_publisher_;

  CameraFaults faults_;
  simulate::CameraImages images_;
  std::uint64_t rendered_{0};  ///< guarded by last_mutex_

  mutable std::mutex last_mutex_;
  sensor_msgs::ImageConstPtr last_color_;  ///< kept, so that its address stays its own until the next
  sensor_msgs::ImageConstPtr last_depth_;
};

}  // namespace extperfc::ros_simulate
