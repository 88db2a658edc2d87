#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "extperfc/scan/cloud_view.hpp"

namespace extperfc::scan {

constexpr bool kHostIsBigEndian = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;

template <typename T, bool kSwap>
T value_at(const std::uint8_t* at) {
  T value;
  if constexpr (kSwap) {
    std::array<std::uint8_t, sizeof(T)> bytes;
    std::reverse_copy(at, at + sizeof(T), bytes.begin());
    std::memcpy(&value, bytes.data(), sizeof(T));
  } else {
    std::memcpy(&value, at, sizeof(T));
  }
  return value;
}

/// A field that any layout may have: one indirect call per number.
class AnyField {
 public:
  AnyField(const CloudView& cloud, const CloudField& field)
      : offset_(field.offset),
        read_(cloud.big_endian == kHostIsBigEndian ? reader_of<false>(field.type)
                                                   : reader_of<true>(field.type)) {}
  double operator()(const std::uint8_t* point) const { return read_(point + offset_); }

 private:
  using Reader = double (*)(const std::uint8_t*);

  template <typename T, bool kSwap>
  static double number_at(const std::uint8_t* at) {
    return static_cast<double>(value_at<T, kSwap>(at));
  }

  template <bool kSwap>
  static Reader reader_of(NumberType type) {
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

  std::size_t offset_;
  Reader read_;
};

/// What nearly every driver sends: 32-bit floats in the host's byte order.
class FloatField {
 public:
  FloatField(const CloudView&, const CloudField& field) : offset_(field.offset) {}
  float operator()(const std::uint8_t* point) const { return value_at<float, false>(point + offset_); }

 private:
  std::size_t offset_;
};

/// Calls visit(point) for every point, row by row.
template <typename Visit>
void for_each_point(const CloudView& cloud, Visit visit) {
  for (std::size_t row = 0; row < cloud.height; ++row) {
    const std::uint8_t* point = cloud.data + row * cloud.row_step;
    for (std::size_t column = 0; column < cloud.width; ++column, point += cloud.point_step) visit(point);
  }
}

}  // namespace extperfc::scan
