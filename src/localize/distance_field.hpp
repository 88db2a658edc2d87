#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "extperfc/world/occupancy_grid.hpp"

namespace extperfc::localize {

/// Percent from which a cell of a map is an obstacle, and up to which it is free (map_server's thresholds).
constexpr std::int8_t kOccupiedFrom = 65;
constexpr std::int8_t kFreeUpTo = 19;

/// For every cell of a map, and for a margin around it, the distance from its middle to that of the nearest
/// obstacle, in one byte.
///
/// Coordinates are in cells of the field: the map's lower left corner lies at (margin, margin). The outermost
/// cells have no obstacle near; points beyond the field belong to them.
class DistanceField {
 public:
  /// Distances are exact up to `max_distance_m` and rounded to a 255th of it; beyond they are that.
  /// O(cells) (Meijster, Roerdink, Hesselink 2000: distance transforms in linear time).
  DistanceField(const OccupancyGrid& map, double max_distance_m);

  [[nodiscard]] int stride() const { return stride_; }
  [[nodiscard]] float margin() const { return static_cast<float>(margin_); }
  [[nodiscard]] const std::uint8_t* bytes() const { return bytes_.data(); }
  [[nodiscard]] float cells_per_m() const { return cells_per_m_; }
  /// Largest coordinates [cells] that still belong to the field.
  [[nodiscard]] float last_column() const { return static_cast<float>(stride_) - 0.5F; }
  [[nodiscard]] float last_row() const { return static_cast<float>(rows_) - 0.5F; }
  /// What a byte stands for [m].
  [[nodiscard]] double metres(std::uint8_t byte) const { return byte * step_m_; }
  /// At a point of the map's own axes: metres from its lower left corner.
  [[nodiscard]] std::uint8_t at(float x_m, float y_m) const;

 private:
  [[nodiscard]] std::vector<std::uint16_t> column_distances(const OccupancyGrid& map, int reach) const;
  void fill(const OccupancyGrid& map, int reach);
  void clear_rim();

  int margin_{0};  ///< cells
  int stride_{0};
  int rows_{0};
  float cells_per_m_{1};
  double step_m_{0};
  std::vector<std::uint8_t> bytes_;
};

}  // namespace extperfc::localize
