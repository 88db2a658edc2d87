#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"

namespace extperfc::scan {

enum class NumberType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

[[nodiscard]] std::size_t bytes_of(NumberType type);

/// Offset and type of one number of every point.
struct CloudField {
  std::size_t offset{0};  ///< from the start of the point [byte]
  NumberType type{NumberType::kFloat32};
};

/// When every point was measured. Seconds since the cloud's stamp are `value * unit_s - origin_s`.
struct TimeField {
  CloudField field;
  double unit_s{1.0};    ///< 1 for seconds, 1e-9 for nanoseconds
  double origin_s{0.0};  ///< the stamp itself where the field holds absolute times, else 0
};

/// A non-owning view of a point cloud, laid out as in sensor_msgs/PointCloud2. Organised clouds have
/// several rows, unorganised ones a single row. Rows may be padded; no alignment is needed.
struct CloudView {
  const std::uint8_t* data{nullptr};
  std::size_t bytes{0};
  std::size_t width{0};       ///< points per row
  std::size_t height{0};      ///< rows
  std::size_t point_step{0};  ///< from point to point [byte]
  std::size_t row_step{0};    ///< from row to row [byte]
  bool big_endian{false};
  CloudField x, y, z;                   ///< [m]
  std::optional<CloudField> intensity;  ///< in the sensor's own unit
  std::optional<CloudField> ring;       ///< number of the laser
  std::optional<TimeField> time;        ///< of the measurement, against the cloud's stamp

  [[nodiscard]] std::size_t size() const { return width * height; }
};

/// Error when points or fields would lie outside of the data.
[[nodiscard]] Result<void> validate(const CloudView& cloud);

/// All points [m], row by row; NaN where the cloud has NaN. Errors as of validate().
[[nodiscard]] Result<std::vector<Eigen::Vector3f>> points_of(const CloudView& cloud);

}  // namespace extperfc::scan
