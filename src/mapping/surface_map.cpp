#include "mapping/surface_map.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::mapping {

namespace {

constexpr float kSameSide = 0.6F;      // cosine between normals of one surface
constexpr float kMaxWeight = 60.0F;    // limits how slowly a cell follows new scans
constexpr int kDirectoryMargin = 8;    // tiles; so that the directory is not widened for every ray
constexpr float kMaxPointM = 5000.0F;  // points beyond are not of this robot's world

bool goes_with(const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
  const bool either_unknown = a.squaredNorm() == 0.0F || b.squaredNorm() == 0.0F;
  return either_unknown || a.dot(b) > kSameSide;
}

}  // namespace

void SurfaceMap::clear() {
  directory_.clear();
  tiles_.clear();
  seen_.clear();
  columns_ = rows_ = 0;
}

void SurfaceMap::add(const ScanPoints& points, const Pose2& map_T_base) {
  Eigen::Matrix2f rotation;
  const auto c = static_cast<float>(std::cos(map_T_base.yaw));
  const auto s = static_cast<float>(std::sin(map_T_base.yaw));
  rotation << c, -s, s, c;
  const Eigen::Vector2f shift(static_cast<float>(map_T_base.x), static_cast<float>(map_T_base.y));
  for (const SurfacePoint& point : points.surface) {
    const Eigen::Vector2f position = rotation * point.position + shift;
    if (!(position.cwiseAbs().maxCoeff() < kMaxPointM)) continue;
    const Eigen::Vector2f normal = rotation * point.normal;
    Surface& surface = make(cell_index(position.x()), cell_index(position.y()));
    if (!goes_with(surface.normal, normal)) {
      // The side that was seen more often stays, the other one wears it down.
      if (surface.weight > 1) {
        surface.weight -= 1;
        continue;
      }
      surface = {};
    }
    const float blend_in = 1.0F / std::min(surface.weight + 1, kMaxWeight);
    surface.mean += blend_in * (position - surface.mean);
    const Eigen::Vector2f blend = surface.normal * std::min(surface.weight, kMaxWeight) + normal;
    surface.normal =
        blend.squaredNorm() > 1e-6F ? Eigen::Vector2f(blend.normalized()) : Eigen::Vector2f::Zero();
    surface.weight = std::min(surface.weight + 1, kMaxWeight);
  }
}

// Row by row, from the point's own outwards, until no cell of the next rows can be nearer than what was
// found.
const SurfaceMap::Surface* SurfaceMap::nearest(const Eigen::Vector2f& point, const Eigen::Vector2f& normal,
                                               int reach_cells) const {
  const int column = cell_index(point.x());
  const int row = cell_index(point.y());
  const float reach = static_cast<float>(reach_cells) * kCellM;
  const Surface* best = nullptr;
  float best_squared = reach * reach;
  const auto consider = [&](const Surface& surface) {
    const float squared = (surface.mean - point).squaredNorm();
    if (squared >= best_squared || !goes_with(surface.normal, normal)) return;
    best = &surface;
    best_squared = squared;
  };
  const float above_rim = point.y() - static_cast<float>(row) * kCellM;
  // Cells and means are rounded.
  constexpr float kRoundingM = 1e-3F;
  const auto too_far = [&](int rows_away, float to_rim) {
    const float gap = static_cast<float>(rows_away - 1) * kCellM + to_rim - kRoundingM;
    return gap > 0 && gap * gap >= best_squared;
  };
  visit_row(column - reach_cells, column + reach_cells, row, consider);
  for (int away = 1; away <= reach_cells; ++away) {
    const bool no_lower = too_far(away, above_rim);
    const bool no_upper = too_far(away, kCellM - above_rim);
    if (no_lower && no_upper) break;
    if (!no_lower) visit_row(column - reach_cells, column + reach_cells, row - away, consider);
    if (!no_upper) visit_row(column - reach_cells, column + reach_cells, row + away, consider);
  }
  return best;
}

SurfaceMap::Surface& SurfaceMap::make(int column, int row) {
  widen(column >> kTileBits, row >> kTileBits);
  const int tile_column = (column >> kTileBits) - first_column_;
  const int tile_row = (row >> kTileBits) - first_row_;
  const int entry = tile_row * columns_ + tile_column;
  std::int32_t& tile = directory_[static_cast<std::size_t>(entry)];
  if (tile < 0) {
    tile = static_cast<std::int32_t>(tiles_.size());
    tiles_.emplace_back();
    seen_.push_back(0);
  }
  const auto cell = static_cast<std::size_t>(place_in_tile(column, row));
  seen_[static_cast<std::size_t>(tile)] |= std::uint64_t{1} << cell;
  return tiles_[static_cast<std::size_t>(tile)][cell];
}

void SurfaceMap::widen(int tile_column, int tile_row) {
  const bool inside = columns_ > 0 && tile_column >= first_column_ && tile_row >= first_row_ &&
                      tile_column < first_column_ + columns_ && tile_row < first_row_ + rows_;
  if (inside) return;
  const int left = columns_ == 0 ? tile_column : std::min(first_column_, tile_column);
  const int bottom = columns_ == 0 ? tile_row : std::min(first_row_, tile_row);
  const int right = columns_ == 0 ? tile_column + 1 : std::max(first_column_ + columns_, tile_column + 1);
  const int top = columns_ == 0 ? tile_row + 1 : std::max(first_row_ + rows_, tile_row + 1);
  const int new_first_column = left - kDirectoryMargin;
  const int new_first_row = bottom - kDirectoryMargin;
  const int new_columns = right - left + 2 * kDirectoryMargin;
  const int new_rows = top - bottom + 2 * kDirectoryMargin;
  std::vector<std::int32_t> wider(static_cast<std::size_t>(new_columns) * static_cast<std::size_t>(new_rows),
                                  -1);
  for (int row = 0; row < rows_; ++row)
    std::copy_n(directory_.begin() + static_cast<std::ptrdiff_t>(row) * columns_, columns_,
                wider.begin() + static_cast<std::ptrdiff_t>(row + first_row_ - new_first_row) * new_columns +
                    (first_column_ - new_first_column));
  directory_ = std::move(wider);
  first_column_ = new_first_column;
  first_row_ = new_first_row;
  columns_ = new_columns;
  rows_ = new_rows;
}

}  // namespace extperfc::mapping
