#include "ros/face/face_locator.hpp"

#include <utility>

#include <tf2_eigen/tf2_eigen.h>

#include "extperfc/depth/box_depth.hpp"

#include "ros/convert/image.hpp"

namespace extperfc::ros_face {

namespace {

std::string size_text(std::uint32_t width, std::uint32_t height) {
  return std::to_string(width) + " x " + std::to_string(height) + " pixels";
}

}  // namespace

FaceLocator::FaceLocator(ros_params::FacesParams params)
    : params_(std::move(params)), depth_(static_cast<std::size_t>(params_.depth_queue)) {
  if (params_.target_frame.empty()) return;
  tf_buffer_ = std::make_unique<tf2_ros::Buffer>();
  tf_listener_ = std::make_unique<tf2_ros::TransformListener>(*tf_buffer_);
}

void FaceLocator::on_info(const sensor_msgs::CameraInfoConstPtr& info) {
  const std::lock_guard lock(info_mutex_);
  info_ = info;
}

Result<std::vector<std::optional<Eigen::Vector3d>>> FaceLocator::locate(const std_msgs::Header& header,
                                                                        const std::vector<Box2>& boxes) {
  const auto message = depth_.find(header.stamp, params_.stamp_tolerance_s, params_.depth_wait_s);
  if (!message)
    return fail(ErrorCode::kNotFound,
                "no depth image has the stamp of the image: is depth published, by the same camera driver? "
                "Set use_depth to false if not");
  const auto depth = ros_convert::share_image(message);
  if (!depth) return tl::unexpected(Error{depth.error().code, "depth: " + depth.error().message});
  if (!is_depth(depth->view.format))
    return fail(ErrorCode::kUnsupported,
                "depth: encoding '" + message->encoding + "' is not depth; use 16UC1 [mm] or 32FC1 [m]");
  const auto camera = camera_for(*message);
  if (!camera) return tl::unexpected(camera.error());
  const auto target_T_optical = transform_at(header);
  if (!target_T_optical) return tl::unexpected(target_T_optical.error());
  std::vector<std::optional<Eigen::Vector3d>> positions;
  for (const auto& box : boxes) {
    auto& position = positions.emplace_back();
    if (const auto found = depth::estimate_depth(depth->view, box, params_.estimate))
      position = *target_T_optical * depth::locate(*camera, box, *found).surface;
  }
  return positions;
}

Result<CameraModel> FaceLocator::camera_for(const sensor_msgs::Image& depth) {
  sensor_msgs::CameraInfoConstPtr info;
  {
    const std::lock_guard lock(info_mutex_);
    info = info_;
  }
  if (!info) return fail(ErrorCode::kNotFound, "no camera info yet: positions need intrinsics");
  if (info->width != depth.width || info->height != depth.height)
    return fail(ErrorCode::kInvalidArgument,
                "camera info is for " + size_text(info->width, info->height) + ", but the depth image has " +
                    size_text(depth.width, depth.height) +
                    ": use depth aligned to colour, and the colour camera's info");
  return ros_convert::to_camera_model(*info);
}

Result<Eigen::Isometry3d> FaceLocator::transform_at(const std_msgs::Header& header) const {
  if (params_.target_frame.empty()) return Eigen::Isometry3d::Identity();
  try {
    return tf2::transformToEigen(tf_buffer_->lookupTransform(
        params_.target_frame, header.frame_id, header.stamp, ros::Duration(params_.transform_timeout_s)));
  } catch (const tf2::TransformException&) {
    return fail(ErrorCode::kNotFound, "no transform from " + header.frame_id + " to " + params_.target_frame +
                                          " at the image's stamp; is tf published?");
  }
}

}  // namespace extperfc::ros_face
