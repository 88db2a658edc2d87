#pragma once

#include <vector>

#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Header.h>

#include "extperfc/simulate/sensor_rig.hpp"

namespace extperfc::ros_convert {

/// A sweep in the layout of velodyne_pointcloud: x y z intensity (float32), ring (uint16), time (float32), 22
/// bytes a point. The header's stamp is the end of the sweep; `duration_s` is its length, so that the
/// message's times, which count from the stamp, are not positive.
[[nodiscard]] sensor_msgs::PointCloud2Ptr to_message(const std::vector<simulate::LidarPoint>& points,
                                                     double duration_s, const std_msgs::Header& header);

}  // namespace extperfc::ros_convert
