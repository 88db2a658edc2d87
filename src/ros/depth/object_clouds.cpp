#include "ros/depth/object_clouds.hpp"

#include <string>
#include <utility>

#include "ros/convert/image.hpp"
#include "ros/convert/points.hpp"

namespace extperfc::ros_depth {

void ObjectClouds::remember(LocatedImage image) {
  const std::lock_guard lock(mutex_);
  images_.push_back(std::move(image));
  if (images_.size() > kept_) images_.pop_front();
}

Result<LocatedImage> ObjectClouds::find(const ros::Time& stamp) const {
  const std::lock_guard lock(mutex_);
  if (images_.empty())
    return fail(ErrorCode::kNotFound,
                "no objects were located yet: detections_3d needs a subscriber, or call detect_once first");
  if (stamp.isZero()) return images_.back();
  for (auto image = images_.rbegin(); image != images_.rend(); ++image)
    if (image->header.stamp == stamp) return *image;
  return fail(ErrorCode::kNotFound, "no detections_3d with stamp " + std::to_string(stamp.toSec()) +
                                        " among the latest " + std::to_string(images_.size()) +
                                        ": ask sooner, or raise cloud_history");
}

Result<sensor_msgs::PointCloud2> ObjectClouds::cloud_of(const ObjectCloud::Request& request) const {
  const auto image = find(request.stamp);
  if (!image) return tl::unexpected(image.error());
  if (request.index >= image->boxes.size())
    return fail(ErrorCode::kNotFound, "no object " + std::to_string(request.index) +
                                          " in detections_3d: it has " + std::to_string(image->boxes.size()));
  const auto depth = ros_convert::share_image(image->depth);
  if (!depth) return tl::unexpected(depth.error());
  std::optional<Eigen::Vector3d> up;
  if (image->target_is_level)
    up = Eigen::Vector3d(image->target_T_optical.linear().transpose() * Eigen::Vector3d::UnitZ());
  const auto cloud =
      depth::object_cloud(depth->view, image->camera, image->boxes[request.index], image->params, up);
  if (!cloud) return tl::unexpected(cloud.error());
  return ros_convert::to_message(cloud->points, image->target_T_optical, image->header);
}

}  // namespace extperfc::ros_depth
