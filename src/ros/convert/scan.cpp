#include "ros/convert/scan.hpp"

#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

namespace extperfc::ros_convert {

namespace {

using sensor_msgs::PointField;

std::optional<scan::NumberType> number_type(std::uint8_t datatype) {
  switch (datatype) {
    case PointField::INT8:
      return scan::NumberType::kInt8;
    case PointField::UINT8:
      return scan::NumberType::kUint8;
    case PointField::INT16:
      return scan::NumberType::kInt16;
    case PointField::UINT16:
      return scan::NumberType::kUint16;
    case PointField::INT32:
      return scan::NumberType::kInt32;
    case PointField::UINT32:
      return scan::NumberType::kUint32;
    case PointField::FLOAT32:
      return scan::NumberType::kFloat32;
    case PointField::FLOAT64:
      return scan::NumberType::kFloat64;
    default:
      return std::nullopt;
  }
}

/// Empty when the cloud has no such field.
Result<std::optional<scan::CloudField>> find_field(const sensor_msgs::PointCloud2& message,
                                                   const std::string& name) {
  for (const auto& field : message.fields) {
    if (field.name != name) continue;
    const auto type = number_type(field.datatype);
    if (!type)
      return fail(ErrorCode::kUnsupported, "field '" + name + "' has the unknown type " +
                                               std::to_string(field.datatype) +
                                               "; see sensor_msgs/PointField");
    if (field.count > 1)  // some drivers write 0 for one
      return fail(ErrorCode::kUnsupported, "field '" + name + "' has " + std::to_string(field.count) +
                                               " numbers per point, one is needed");
    return scan::CloudField{field.offset, *type};
  }
  return std::nullopt;
}

std::string field_names(const sensor_msgs::PointCloud2& message) {
  std::string names;
  for (const auto& field : message.fields) names += (names.empty() ? "" : ", ") + field.name;
  return names.empty() ? "none" : names;
}

Result<scan::CloudField> need_field(const sensor_msgs::PointCloud2& message, const std::string& name) {
  const auto field = find_field(message, name);
  if (!field) return tl::unexpected(field.error());
  if (*field) return **field;
  return fail(ErrorCode::kNotFound,
              "the cloud has no field '" + name + "'; its fields: " + field_names(message));
}

Result<std::optional<scan::CloudField>> intensity_field(const sensor_msgs::PointCloud2& message) {
  auto field = find_field(message, "intensity");
  return field && !*field ? find_field(message, "i") : field;
}

/// `time` [s] (velodyne_pointcloud), `t` [ns] (Ouster), `timestamp` [s] (Hesai, RoboSense). Whole numbers are
/// nanoseconds, others seconds. Absolute times, which only 64 bits hold, count from the stamp.
Result<std::optional<scan::TimeField>> time_field(const sensor_msgs::PointCloud2& message) {
  for (const char* name : {"time", "t", "timestamp"}) {
    const auto field = find_field(message, name);
    if (!field) return tl::unexpected(field.error());
    if (!*field) continue;
    const auto type = (*field)->type;
    if (type == scan::NumberType::kFloat32) return scan::TimeField{**field, 1.0, 0.0};
    if (type == scan::NumberType::kUint32 || type == scan::NumberType::kInt32)
      return scan::TimeField{**field, 1e-9, 0.0};
    if (type != scan::NumberType::kFloat64) continue;
    constexpr double kAbsolute = 1e3;  // [s]
    double first = 0;
    if ((*field)->offset + sizeof first <= message.data.size() && message.is_bigendian == 0)
      std::memcpy(&first, message.data.data() + (*field)->offset, sizeof first);
    return scan::TimeField{**field, 1.0, std::abs(first) > kAbsolute ? message.header.stamp.toSec() : 0.0};
  }
  return std::nullopt;
}

}  // namespace

Result<scan::CloudView> to_cloud_view(const sensor_msgs::PointCloud2& message) {
  scan::CloudView cloud;
  cloud.data = message.data.data();
  cloud.bytes = message.data.size();
  cloud.width = message.width;
  cloud.height = message.height;
  cloud.point_step = message.point_step;
  cloud.row_step = message.row_step;
  cloud.big_endian = message.is_bigendian != 0;
  if (cloud.size() == 0) return cloud;  // an empty cloud often has no fields either
  for (auto [name, field] : {std::pair{"x", &cloud.x}, {"y", &cloud.y}, {"z", &cloud.z}}) {
    const auto found = need_field(message, name);
    if (!found) return tl::unexpected(found.error());
    *field = *found;
  }
  const auto intensity = intensity_field(message);
  if (!intensity) return tl::unexpected(intensity.error());
  cloud.intensity = *intensity;
  const auto ring = find_field(message, "ring");
  if (!ring) return tl::unexpected(ring.error());
  cloud.ring = *ring;
  const auto time = time_field(message);
  if (!time) return tl::unexpected(time.error());
  cloud.time = *time;
  return cloud;
}

sensor_msgs::LaserScan to_message(const scan::PlanarScan& scan, const ScanFacts& facts,
                                  const std_msgs::Header& header) {
  sensor_msgs::LaserScan message;
  message.header = header;
  message.angle_min = static_cast<float>(scan.angle_min);
  message.angle_max = static_cast<float>(scan.angle_max);
  message.angle_increment = static_cast<float>(scan.angle_increment);
  message.time_increment = 0.0F;  // a ray's nearest point may come from anywhere in the sweep
  message.scan_time = static_cast<float>(facts.scan_time_s);
  message.range_min = static_cast<float>(facts.range_min_m);
  message.range_max = static_cast<float>(facts.range_max_m);
  message.ranges = scan.ranges;
  message.intensities = scan.intensities;
  return message;
}

}  // namespace extperfc::ros_convert
