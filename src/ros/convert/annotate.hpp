#pragma once

#include <string>
#include <vector>

#include <sensor_msgs/Image.h>

#include "extperfc/world/detection.hpp"

#include "ros/convert/image.hpp"

namespace extperfc::ros_convert {

/// A bgr8 copy of the image with boxes, class names and scores drawn in. Throws nothing; kUnsupported when
/// the image's encoding has no conversion to bgr8.
[[nodiscard]] Result<sensor_msgs::ImagePtr> annotate(const SharedImage& image, const Detections& detections,
                                                     const std::vector<std::string>& class_names);

}  // namespace extperfc::ros_convert
