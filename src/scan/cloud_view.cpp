#include "extperfc/scan/cloud_view.hpp"

#include <string>
#include <utility>

#include "scan/field_reader.hpp"

namespace extperfc::scan {

std::size_t bytes_of(NumberType type) {
  switch (type) {
    case NumberType::kInt8:
    case NumberType::kUint8:
      return 1;
    case NumberType::kInt16:
    case NumberType::kUint16:
      return 2;
    case NumberType::kInt32:
    case NumberType::kUint32:
    case NumberType::kFloat32:
      return 4;
    case NumberType::kFloat64:
      return 8;
  }
  return 0;
}

namespace {

/// a * b > limit, without overflow.
bool product_exceeds(std::size_t a, std::size_t b, std::size_t limit) {
  return b != 0 && a > limit / b;
}

Result<void> inside_point(const CloudView& cloud, const char* name, const CloudField& field) {
  const std::size_t length = bytes_of(field.type);
  if (length <= cloud.point_step && field.offset <= cloud.point_step - length) return {};
  return fail(ErrorCode::kCorrupt, std::string("field ") + name + " ends behind the point: offset " +
                                       std::to_string(field.offset) + " of " +
                                       std::to_string(cloud.point_step) + " bytes");
}

}  // namespace

Result<void> validate(const CloudView& cloud) {
  if (cloud.width == 0 || cloud.height == 0) return {};
  for (const auto& [name, field] : {std::pair{"x", &cloud.x}, {"y", &cloud.y}, {"z", &cloud.z}})
    if (auto inside = inside_point(cloud, name, *field); !inside) return inside;
  for (const auto& [name, field] : {std::pair{"intensity", &cloud.intensity}, {"ring", &cloud.ring}})
    if (*field)
      if (auto inside = inside_point(cloud, name, **field); !inside) return inside;
  if (cloud.time)
    if (auto inside = inside_point(cloud, "time", cloud.time->field); !inside) return inside;
  if (product_exceeds(cloud.width, cloud.point_step, cloud.row_step))
    return fail(ErrorCode::kCorrupt,
                std::to_string(cloud.width) + " points of " + std::to_string(cloud.point_step) +
                    " bytes do not fit into a row of " + std::to_string(cloud.row_step) + " bytes");
  // The last row's padding may be missing.
  const std::size_t last_row = cloud.width * cloud.point_step;
  if (cloud.bytes < last_row || product_exceeds(cloud.height - 1, cloud.row_step, cloud.bytes - last_row))
    return fail(ErrorCode::kCorrupt, std::to_string(cloud.height) + " rows of " +
                                         std::to_string(cloud.row_step) + " bytes announced, but there are " +
                                         std::to_string(cloud.bytes) + " bytes of data");
  return {};
}

Result<std::vector<Eigen::Vector3f>> points_of(const CloudView& cloud) {
  if (auto valid = validate(cloud); !valid) return tl::unexpected(valid.error());
  std::vector<Eigen::Vector3f> points;
  if (cloud.size() == 0) return points;
  points.reserve(cloud.size());
  const AnyField x(cloud, cloud.x);
  const AnyField y(cloud, cloud.y);
  const AnyField z(cloud, cloud.z);
  for_each_point(cloud, [&](const std::uint8_t* point) {
    points.push_back(Eigen::Vector3d(x(point), y(point), z(point)).cast<float>());
  });
  return points;
}

}  // namespace extperfc::scan
