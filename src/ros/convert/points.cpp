#include "ros/convert/points.hpp"

#include <sensor_msgs/point_cloud2_iterator.h>

namespace extperfc::ros_convert {

sensor_msgs::PointCloud2 to_message(const std::vector<Eigen::Vector3f>& points,
                                    const Eigen::Isometry3d& target_T_points,
                                    const std_msgs::Header& header) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header = header;
  cloud.is_dense = 1U;
  sensor_msgs::PointCloud2Modifier modifier(cloud);
  modifier.setPointCloud2Fields(3, "x", 1, sensor_msgs::PointField::FLOAT32, "y", 1,
                                sensor_msgs::PointField::FLOAT32, "z", 1, sensor_msgs::PointField::FLOAT32);
  modifier.resize(points.size());
  const Eigen::Isometry3f transform = target_T_points.cast<float>();
  sensor_msgs::PointCloud2Iterator<float> place(cloud, "x");
  for (const auto& point : points) {
    Eigen::Map<Eigen::Vector3f> xyz(&*place);
    xyz = transform * point;
    ++place;
  }
  return cloud;
}

}  // namespace extperfc::ros_convert
