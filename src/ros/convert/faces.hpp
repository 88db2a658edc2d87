#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <extperfc/FaceArray.h>
#include <visualization_msgs/MarkerArray.h>

#include "extperfc/face/face_detector.hpp"
#include "extperfc/face/gallery.hpp"

#include "ros/convert/image.hpp"

namespace extperfc::ros_convert {

/// A face with what is known about it.
struct NamedFace {
  face::DetectedFace face;
  face::Identity identity;
  std::optional<Eigen::Vector3d> position_m;  ///< in the frame of the array
};

[[nodiscard]] FaceArrayPtr to_message(const std::vector<NamedFace>& faces, const std_msgs::Header& header);

/// For rviz: one ball and, above it, one name per face with a position; older markers vanish after
/// `lifetime_s`.
[[nodiscard]] visualization_msgs::MarkerArray to_markers(const FaceArray& faces, double lifetime_s);

/// A bgr8 copy of the image with boxes and names, and the similarity of known faces or the score of others.
/// Errors: those of annotate().
[[nodiscard]] Result<sensor_msgs::ImagePtr> annotate(const SharedImage& image,
                                                     const std::vector<NamedFace>& faces);

}  // namespace extperfc::ros_convert
