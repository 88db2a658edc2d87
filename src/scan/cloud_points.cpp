#include "scan/cloud_points.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

namespace extperfc::scan {

namespace {

constexpr bool kHostIsBigEndian = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;

template <typename T, bool kSwap>
float number_at(const std::uint8_t* at) {
  T value;
  if constexpr (kSwap) {
    std::array<std::uint8_t, sizeof(T)> bytes;
    std::reverse_copy(at, at + sizeof(T), bytes.begin());
    std::memcpy(&value, bytes.data(), sizeof(T));
  } else {
    std::memcpy(&value, at, sizeof(T));
  }
  return static_cast<float>(value);
}

using Reader = float (*)(const std::uint8_t*);

template <bool kSwap>
Reader reader_of(NumberType type) {
  switch (type) {
    case NumberType::kInt8:
      return number_at<std::int8_t, kSwap>;
    case NumberType::kUint8:
      return number_at<std::uint8_t, kSwap>;
    case NumberType::kInt16:
      return number_at<std::int16_t, kSwap>;
    case NumberType::kUint16:
      return number_at<std::uint16_t, kSwap>;
    case NumberType::kInt32:
      return number_at<std::int32_t, kSwap>;
    case NumberType::kUint32:
      return number_at<std::uint32_t, kSwap>;
    case NumberType::kFloat32:
      return number_at<float, kSwap>;
    case NumberType::kFloat64:
      return number_at<double, kSwap>;
  }
  return nullptr;
}

/// A field that any layout may have: one indirect call per number.
struct AnyField {
  AnyField(const CloudView& cloud, const CloudField& field)
      : offset(field.offset),
        read(cloud.big_endian == kHostIsBigEndian ? reader_of<false>(field.type)
                                                  : reader_of<true>(field.type)) {}
  float operator()(const std::uint8_t* point) const { return read(point + offset); }
  std::size_t offset;
  Reader read;
};

/// What nearly every driver sends: 32-bit floats in the host's byte order.
struct FloatField {
  FloatField(const CloudView&, const CloudField& field) : offset(field.offset) {}
  float operator()(const std::uint8_t* point) const { return number_at<float, false>(point + offset); }
  std::size_t offset;
};

template <typename Visit>
void for_each_point(const CloudView& cloud, Visit visit) {
  for (std::size_t row = 0; row < cloud.height; ++row) {
    const std::uint8_t* point = cloud.data + row * cloud.row_step;
    for (std::size_t column = 0; column < cloud.width; ++column, point += cloud.point_step) visit(point);
  }
}

/// Returns the number of points that were wanted.
template <typename Field, typename Wanted>
std::size_t read_into(const CloudView& cloud, Wanted wanted, CloudPoints& points) {
  const Field x(cloud, cloud.x);
  const Field y(cloud, cloud.y);
  const Field z(cloud, cloud.z);
  std::optional<AnyField> intensity;
  if (!points.intensity.empty()) intensity.emplace(cloud, *cloud.intensity);
  std::size_t i = 0;
  for_each_point(cloud, [&](const std::uint8_t* point) {
    if (!wanted(point)) return;
    points.x[i] = x(point);
    points.y[i] = y(point);
    points.z[i] = z(point);
    if (intensity) points.intensity[i] = (*intensity)(point);
    ++i;
  });
  return i;
}

template <typename Field>
std::size_t read_with(const CloudView& cloud, const RingSet* rings, CloudPoints& points) {
  if (!rings)
    return read_into<Field>(
        cloud, [](const std::uint8_t*) { return true; }, points);
  const AnyField ring(cloud, *cloud.ring);
  const auto selected = [&](const std::uint8_t* point) {
    const float number = ring(point);
    return number >= 0 && number < static_cast<float>(rings->size()) &&
           rings->test(static_cast<std::size_t>(number));
  };
  return read_into<Field>(cloud, selected, points);
}

void transform(const Pose& target_T_cloud, CloudPoints& points) {
  const Eigen::Matrix3f r = target_T_cloud.linear().cast<float>();
  const Eigen::Vector3f t = target_T_cloud.translation().cast<float>();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float x = points.x[i];
    const float y = points.y[i];
    const float z = points.z[i];
    points.x[i] = r(0, 0) * x + r(0, 1) * y + r(0, 2) * z + t.x();
    points.y[i] = r(1, 0) * x + r(1, 1) * y + r(1, 2) * z + t.y();
    points.z[i] = r(2, 0) * x + r(2, 1) * y + r(2, 2) * z + t.z();
  }
}

bool is_plain_float(const CloudView& cloud) {
  return cloud.big_endian == kHostIsBigEndian && cloud.x.type == NumberType::kFloat32 &&
         cloud.y.type == NumberType::kFloat32 && cloud.z.type == NumberType::kFloat32;
}

}  // namespace

void CloudPoints::resize(std::size_t points, bool with_intensity) {
  for (auto* values : {&x, &y, &z}) values->resize(points);
  intensity.resize(with_intensity ? points : 0);
}

void read_points(const CloudView& cloud, const Pose& target_T_cloud, const ReadOptions& options,
                 CloudPoints& points) {
  const bool with_intensity = options.intensity && cloud.intensity;
  points.resize(cloud.size(), with_intensity);
  const std::size_t kept = is_plain_float(cloud) ? read_with<FloatField>(cloud, options.rings, points)
                                                 : read_with<AnyField>(cloud, options.rings, points);
  points.resize(kept, with_intensity);
  transform(target_T_cloud, points);
}

}  // namespace extperfc::scan
