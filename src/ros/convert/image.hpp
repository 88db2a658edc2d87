#pragma once

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include "extperfc/base/error.hpp"
#include "extperfc/world/camera_model.hpp"
#include "extperfc/world/image_view.hpp"

namespace extperfc::ros_convert {

/// A message's pixels as the core sees them. `holder` keeps the message alive; no pixel is copied unless the
/// message's byte order differs from this machine's (16-bit and float images of a big-endian sender).
struct SharedImage {
  cv_bridge::CvImageConstPtr holder;
  ImageView view;
};

/// Wraps a message with cv_bridge's toCvShare.
/// Errors: kUnsupported for an encoding that the core does not know (named, with the list of those it knows),
/// kInvalidArgument for an empty image or fewer bytes than its size says.
[[nodiscard]] Result<SharedImage> share_image(const sensor_msgs::ImageConstPtr& message);

/// Intrinsics of a colour camera and of the depth aligned to it: K and D for raw images. Accepts the
/// distortion models plumb_bob (up to 5 coefficients) and none; others only with all coefficients zero
/// (kUnsupported).
[[nodiscard]] Result<CameraModel> to_camera_model(const sensor_msgs::CameraInfo& info);

[[nodiscard]] sensor_msgs::CameraInfo to_camera_info(const CameraModel& camera,
                                                     const std_msgs::Header& header);

}  // namespace extperfc::ros_convert
