#pragma once

#include <cstring>
#include <string>
#include <vector>

#include <boost/make_shared.hpp>
#include <sensor_msgs/PointCloud2.h>

namespace extperfc::ros_test {

struct CloudPoint {
  float x, y, z, intensity;
  std::uint16_t ring, padding;
};

inline void add_field(sensor_msgs::PointCloud2& message, const std::string& name, std::size_t offset,
                      std::uint8_t datatype) {
  sensor_msgs::PointField field;
  field.name = name;
  field.offset = static_cast<std::uint32_t>(offset);
  field.datatype = datatype;
  field.count = 1;
  message.fields.push_back(field);
}

/// An unorganised cloud in frame `velodyne`, as a lidar's driver sends it.
[[nodiscard]] inline sensor_msgs::PointCloud2Ptr cloud_message(const std::vector<CloudPoint>& points,
                                                               const ros::Time& stamp) {
  using sensor_msgs::PointField;
  auto message = boost::make_shared<sensor_msgs::PointCloud2>();
  message->header.stamp = stamp;
  message->header.frame_id = "velodyne";
  message->width = static_cast<std::uint32_t>(points.size());
  message->height = 1;
  message->point_step = sizeof(CloudPoint);
  message->row_step = message->width * message->point_step;
  add_field(*message, "x", offsetof(CloudPoint, x), PointField::FLOAT32);
  add_field(*message, "y", offsetof(CloudPoint, y), PointField::FLOAT32);
  add_field(*message, "z", offsetof(CloudPoint, z), PointField::FLOAT32);
  add_field(*message, "intensity", offsetof(CloudPoint, intensity), PointField::FLOAT32);
  add_field(*message, "ring", offsetof(CloudPoint, ring), PointField::UINT16);
  message->data.resize(message->row_step);
  if (!points.empty()) std::memcpy(message->data.data(), points.data(), message->data.size());
  return message;
}

/// The same cloud with a field `time` [s] since the stamp, one value per point.
inline void add_times(sensor_msgs::PointCloud2& message, const std::vector<float>& times) {
  const std::size_t step = message.point_step + sizeof(float);
  std::vector<std::uint8_t> data(step * message.width);
  for (std::size_t i = 0; i < message.width; ++i) {
    std::memcpy(&data[i * step], &message.data[i * message.point_step], message.point_step);
    std::memcpy(&data[i * step + message.point_step], &times.at(i), sizeof(float));
  }
  add_field(message, "time", message.point_step, sensor_msgs::PointField::FLOAT32);
  message.point_step = static_cast<std::uint32_t>(step);
  message.row_step = message.point_step * message.width;
  message.data = std::move(data);
}

}  // namespace extperfc::ros_test
