#pragma once

#include <vector>

#include <Eigen/Geometry>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Header.h>

namespace extperfc::ros_convert {

/// Points as a cloud of one row with x y z [m, float32], in the frame of `header`.
[[nodiscard]] sensor_msgs::PointCloud2 to_message(const std::vector<Eigen::Vector3f>& points,
                                                  const Eigen::Isometry3d& target_T_points,
                                                  const std_msgs::Header& header);

}  // namespace extperfc::ros_convert
