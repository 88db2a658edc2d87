#include "localize/distance_field.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::localize {

namespace {

/// Cells of margin: end points that odometry carries beyond a map which ends at its walls still see them.
int margin_of(const OccupancyGrid& map, double max_distance_m) {
  constexpr double kWidest_m = 1;
  constexpr double kMaxCells = 100;
  return static_cast<int>(
             std::min(std::ceil(std::min(max_distance_m, kWidest_m) / map.resolution_m), kMaxCells)) +
         1;
}

/// The lower envelope of the parabolas (x - i)^2 + height[i]^2 over one row.
class Envelope {
 public:
  explicit Envelope(std::size_t width) : apex_(width), from_(width) {}

  /// Calls `result(column, squared distance)` for every column.
  template <typename Sink>
  void run(const std::uint16_t* height, std::int64_t width, Sink result) {
    std::int64_t top = 0;
    apex_[0] = 0;
    from_[0] = 0;
    for (std::int64_t u = 1; u < width; ++u) {
      while (top >= 0 && value(height, apex_[at(top)], from_[at(top)]) > value(height, u, from_[at(top)]))
        --top;
      const std::int64_t start = top < 0 ? 0 : crossing(height, apex_[at(top)], u) + 1;
      if (start >= width) continue;
      ++top;
      apex_[at(top)] = u;
      from_[at(top)] = start;
    }
    for (std::int64_t u = width - 1; u >= 0; --u) {
      result(u, value(height, apex_[at(top)], u));
      if (u == from_[at(top)] && top > 0) --top;
    }
  }

 private:
  static std::size_t at(std::int64_t i) { return static_cast<std::size_t>(i); }
  static std::int64_t square(std::int64_t v) { return v * v; }
  static std::int64_t value(const std::uint16_t* height, std::int64_t apex, std::int64_t x) {
    return square(x - apex) + square(height[apex]);
  }
  /// Last column where the parabola at i is not above the one at u > i.
  static std::int64_t crossing(const std::uint16_t* height, std::int64_t i, std::int64_t u) {
    const std::int64_t numerator = square(u) - square(i) + square(height[u]) - square(height[i]);
    const std::int64_t denominator = 2 * (u - i);
    return numerator >= 0 ? numerator / denominator : -((-numerator + denominator - 1) / denominator);
  }

  std::vector<std::int64_t> apex_;
  std::vector<std::int64_t> from_;
};

}  // namespace

DistanceField::DistanceField(const OccupancyGrid& map, double max_distance_m)
    : margin_(margin_of(map, max_distance_m)),
      stride_(static_cast<int>(map.width) + 2 * margin_),
      rows_(static_cast<int>(map.height) + 2 * margin_),
      cells_per_m_(static_cast<float>(1 / map.resolution_m)),
      step_m_(max_distance_m / 255),
      bytes_(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(rows_)) {
  constexpr double kMaxCells = 30000;
  fill(map, static_cast<int>(std::min(std::ceil(max_distance_m / map.resolution_m) + 1, kMaxCells)));
  clear_rim();
}

/// Cells to the nearest obstacle of the same column, `reach` where there is none so near.
std::vector<std::uint16_t> DistanceField::column_distances(const OccupancyGrid& map, int reach) const {
  const auto stride = static_cast<std::size_t>(stride_);
  const auto rows = static_cast<std::size_t>(rows_);
  const auto margin = static_cast<std::size_t>(margin_);
  std::vector<std::uint16_t> distance(bytes_.size(), static_cast<std::uint16_t>(reach));
  for (std::size_t row = 0; row < map.height; ++row)
    for (std::size_t column = 0; column < map.width; ++column)
      if (map.at(column, row) >= kOccupiedFrom) distance[(row + margin) * stride + column + margin] = 0;
  const auto pass = [&](std::size_t row, std::size_t neighbour) {
    for (std::size_t column = 0; column < stride; ++column) {
      std::uint16_t& here = distance[row * stride + column];
      here = std::min<std::uint16_t>(here,
                                     static_cast<std::uint16_t>(distance[neighbour * stride + column] + 1));
    }
  };
  for (std::size_t row = 1; row < rows; ++row) pass(row, row - 1);
  for (std::size_t row = rows - 1; row-- > 0;) pass(row, row + 1);
  return distance;
}

void DistanceField::fill(const OccupancyGrid& map, int reach) {
  const auto columns = column_distances(map, reach);
  const auto stride = static_cast<std::size_t>(stride_);
  Envelope envelope(stride);
  const double bytes_per_cell = map.resolution_m / step_m_;
  for (std::size_t row = 0; row < static_cast<std::size_t>(rows_); ++row) {
    std::uint8_t* out = &bytes_[row * stride];
    envelope.run(&columns[row * stride], stride_, [&](std::int64_t column, std::int64_t squared) {
      const double byte = std::sqrt(static_cast<double>(squared)) * bytes_per_cell;
      out[column] = static_cast<std::uint8_t>(std::min(255.0, std::round(byte)));
    });
  }
}

void DistanceField::clear_rim() {
  const auto stride = static_cast<std::size_t>(stride_);
  const auto row_of = [&](int row) { return bytes_.begin() + static_cast<std::ptrdiff_t>(row) * stride_; };
  std::fill_n(row_of(0), stride, std::uint8_t{255});
  std::fill_n(row_of(rows_ - 1), stride, std::uint8_t{255});
  for (int row = 0; row < rows_; ++row) row_of(row)[0] = row_of(row)[stride_ - 1] = 255;
}

std::uint8_t DistanceField::at(float x_m, float y_m) const {
  const float column = std::clamp(x_m * cells_per_m_ + margin(), 0.0F, last_column());
  const float row = std::clamp(y_m * cells_per_m_ + margin(), 0.0F, last_row());
  return bytes_[static_cast<std::size_t>(row) * static_cast<std::size_t>(stride_) +
                static_cast<std::size_t>(column)];
}

}  // namespace extperfc::localize
