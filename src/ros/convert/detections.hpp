#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <std_msgs/Header.h>
#include <vision_msgs/Detection2DArray.h>
#include <vision_msgs/Detection3DArray.h>
#include <visualization_msgs/MarkerArray.h>

#include "extperfc/depth/box_depth.hpp"
#include "extperfc/depth/object_fit.hpp"
#include "extperfc/world/detection.hpp"

namespace extperfc::ros_convert {

/// vision_msgs box: centre and size in pixels, theta 0. One hypothesis each: id = class index, its pose
/// unset.
[[nodiscard]] vision_msgs::Detection2DArray to_message(const Detections& detections,
                                                       const std_msgs::Header& header);

/// Back again. Detections without a hypothesis get class -1 and score 0; the best hypothesis counts.
[[nodiscard]] Detections from_message(const vision_msgs::Detection2DArray& message);

/// One object as vision_msgs/Detection3D in the frame of `header`: bbox.center and results[0].pose are both
/// the object's estimated centre, the second with the covariance of its position; nothing (0) is said about
/// that of the orientation. The orientation is that of the optical frame: a box says nothing about the
/// object's own. `target_T_optical` takes the object into the frame of `header`.
[[nodiscard]] vision_msgs::Detection3D to_message(const Detection& detection, const depth::Object3& object,
                                                  const Eigen::Isometry3d& target_T_optical,
                                                  const std_msgs::Header& header);

/// The same of an object whose shape was fitted: pose, size and covariance are the shape's.
[[nodiscard]] vision_msgs::Detection3D to_message(const Detection& detection, const depth::ObjectFit& object,
                                                  const Eigen::Isometry3d& target_T_optical,
                                                  const std_msgs::Header& header);

/// The measured point of an object's surface, alike: bbox.center and results[0].pose are both this point, the
/// size is 0.
[[nodiscard]] vision_msgs::Detection3D to_surface_message(const Detection& detection,
                                                          const depth::Object3& object,
                                                          const Eigen::Isometry3d& target_T_optical,
                                                          const std_msgs::Header& header);

/// For rviz: one see-through cuboid and one label, with its centre, per object; older markers vanish after
/// `lifetime_s`.
[[nodiscard]] visualization_msgs::MarkerArray to_markers(const vision_msgs::Detection3DArray& objects,
                                                         const std::vector<std::string>& class_names,
                                                         double lifetime_s);

/// A class's name, or its number when the names are not known.
[[nodiscard]] std::string class_name(const std::vector<std::string>& names, std::int64_t index);

}  // namespace extperfc::ros_convert
