#pragma once

#include <cstddef>
#include <deque>
#include <mutex>
#include <vector>

#include <Eigen/Geometry>
#include <extperfc/ObjectCloud.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>

#include "extperfc/base/error.hpp"
#include "extperfc/depth/object_cloud.hpp"

namespace extperfc::ros_depth {

/// An image whose objects were located.
struct LocatedImage {
  std_msgs::Header header;  ///< of detections_3d
  sensor_msgs::ImageConstPtr depth;
  CameraModel camera;
  Eigen::Isometry3d target_T_optical{Eigen::Isometry3d::Identity()};
  bool target_is_level{false};  ///< z of the target frame points up
  std::vector<Box2> boxes;      ///< of the objects in detections_3d, in its order
  depth::BoxDepthParams params;
};

/// Remembers the latest located images, and cuts clouds of single objects out of them. Any number of threads.
class ObjectClouds {
 public:
  explicit ObjectClouds(std::size_t kept) : kept_(kept) {}

  void remember(LocatedImage image);

  /// The points of an object, in the frame of its detections_3d. Errors: kNotFound for a stamp that is not
  /// remembered or an index without an object, and those of depth::object_cloud().
  [[nodiscard]] Result<sensor_msgs::PointCloud2> cloud_of(const ObjectCloud::Request& request) const;

 private:
  [[nodiscard]] Result<LocatedImage> find(const ros::Time& stamp) const;

  std::size_t kept_;
  mutable std::mutex mutex_;
  std::deque<LocatedImage> images_;  // newest last
};

}  // namespace extperfc::ros_depth
