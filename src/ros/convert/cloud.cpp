#include "ros/convert/cloud.hpp"

#include <cstring>

#include <boost/make_shared.hpp>

namespace extperfc::ros_convert {

namespace {

using sensor_msgs::PointField;

struct Field {
  const char* name;
  std::uint32_t offset;
  std::uint8_t type;
};
constexpr Field kFields[] = {{"x", 0, PointField::FLOAT32},    {"y", 4, PointField::FLOAT32},
                             {"z", 8, PointField::FLOAT32},    {"intensity", 12, PointField::FLOAT32},
                             {"ring", 16, PointField::UINT16}, {"time", 18, PointField::FLOAT32}};
constexpr std::uint32_t kPointBytes = 22;

}  // namespace

sensor_msgs::PointCloud2Ptr to_message(const std::vector<simulate::LidarPoint>& points, double duration_s,
                                       const std_msgs::Header& header) {
  auto cloud = boost::make_shared<sensor_msgs::PointCloud2>();
  cloud->header = header;
  cloud->height = 1;
  cloud->width = static_cast<std::uint32_t>(points.size());
  cloud->point_step = kPointBytes;
  cloud->row_step = kPointBytes * cloud->width;
  cloud->is_dense = 1;
  for (const auto& [name, offset, type] : kFields) {
    PointField field;
    field.name = name;
    field.offset = offset;
    field.datatype = type;
    field.count = 1;
    cloud->fields.push_back(field);
  }
  cloud->data.resize(cloud->row_step);
  std::uint8_t* out = cloud->data.data();
  for (const auto& point : points) {
    const float values[] = {point.x, point.y, point.z, point.intensity};
    const float time = point.time - static_cast<float>(duration_s);
    std::memcpy(out, values, sizeof values);
    std::memcpy(out + 16, &point.ring, sizeof point.ring);
    std::memcpy(out + 18, &time, sizeof time);
    out += kPointBytes;
  }
  return cloud;
}

}  // namespace extperfc::ros_convert
