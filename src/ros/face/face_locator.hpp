#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include "extperfc/base/error.hpp"
#include "extperfc/world/camera_model.hpp"
#include "extperfc/world/detection.hpp"

#include "ros/face/depth_frames.hpp"
#include "ros/params/faces_params.hpp"

namespace extperfc::ros_face {

/// Positions of boxes in a colour image, from the aligned depth image of its stamp. Inputs may come in other
/// threads than locate().
class FaceLocator {
 public:
  explicit FaceLocator(ros_params::FacesParams params);

  void on_depth(const sensor_msgs::ImageConstPtr& image) { depth_.put(image); }
  void on_info(const sensor_msgs::CameraInfoConstPtr& info);

  /// The point of the visible surface behind the middle of each box [m], in target_frame or, without one, in
  /// the optical frame; empty where the depth is not known. Errors: kNotFound without a depth image of this
  /// stamp, camera info or transform; kUnsupported and kInvalidArgument for inputs that do not fit together.
  [[nodiscard]] Result<std::vector<std::optional<Eigen::Vector3d>>> locate(const std_msgs::Header& header,
                                                                           const std::vector<Box2>& boxes);

  /// Ends a wait in locate().
  void close() { depth_.close(); }

 private:
  [[nodiscard]] Result<CameraModel> camera_for(const sensor_msgs::Image& depth);
  [[nodiscard]] Result<Eigen::Isometry3d> transform_at(const std_msgs::Header& header) const;

  const ros_params::FacesParams params_;
  DepthFrames depth_;
  std::unique_ptr<tf2_ros::Buffer> tf_buffer_;
  std::unique_ptr<tf2_ros::TransformListener> tf_listener_;
  std::mutex info_mutex_;
  sensor_msgs::CameraInfoConstPtr info_;
};

}  // namespace extperfc::ros_face
