#include "mapping/map_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace extperfc::mapping {

namespace {

constexpr double kMovedCells = 0.4;  // of a key frame, before it is drawn anew
constexpr double kMovedRad = 0.004;
constexpr double kFarthestM = 5000.0;  // coordinates beyond are not of this robot's world

std::uint64_t key_of(int tile_column, int tile_row) {
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(tile_column)) << 32U) |
         static_cast<std::uint32_t>(tile_row);
}

void change(std::uint32_t& count, int sign) {
  count = sign > 0 ? count + 1 : count - 1;
}

}  // namespace

MapRenderer::MapRenderer(double resolution_m, double occupied_threshold)
    : resolution_m_(resolution_m), occupied_threshold_(occupied_threshold) {
  grid_.resolution_m = resolution_m;
}

bool MapRenderer::update(const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses,
                         std::size_t most_cells) {
  std::size_t cells = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const bool is_new = i >= drawn_.size();
    if (!is_new) {
      const double away = std::hypot(poses[i].x - drawn_[i].x, poses[i].y - drawn_[i].y);
      if (away < kMovedCells * resolution_m_ &&
          std::abs(wrap_angle(poses[i].yaw - drawn_[i].yaw)) < kMovedRad)
        continue;
    }
    if (cells >= most_cells) return false;
    if (is_new)
      drawn_.emplace_back();
    else
      cells += draw(frames[i].points, drawn_[i], -1);
    cells += draw(frames[i].points, poses[i], +1);
    drawn_[i] = poses[i];
  }
  return true;
}

std::size_t MapRenderer::draw(const ScanPoints& points, const Pose2& map_T_base, int sign) {
  const double c = std::cos(map_T_base.yaw);
  const double s = std::sin(map_T_base.yaw);
  const auto to_map = [&](const Eigen::Vector2f& p) {
    const Eigen::Vector2d q = p.cast<double>();
    return Eigen::Vector2d(map_T_base.x + c * q.x() - s * q.y(), map_T_base.y + s * q.x() + c * q.y());
  };
  const Eigen::Vector2d from = to_map(points.scanner);
  std::size_t cells = 0;
  for (const SurfacePoint& point : points.surface)
    cells += draw_ray(from, to_map(point.position), true, sign);
  for (const Eigen::Vector2f& end : points.clear) cells += draw_ray(from, to_map(end), false, sign);
  return cells;
}

/// Every cell that the line touches from its start up to the cell before its end (Amanatides and Woo 1987).
std::size_t MapRenderer::draw_ray(const Eigen::Vector2d& from, const Eigen::Vector2d& to, bool hit,
                                  int sign) {
  if (!(from.cwiseAbs().maxCoeff() < kFarthestM && to.cwiseAbs().maxCoeff() < kFarthestM)) return 0;
  int column = static_cast<int>(std::floor(from.x() / resolution_m_));
  int row = static_cast<int>(std::floor(from.y() / resolution_m_));
  const int end_column = static_cast<int>(std::floor(to.x() / resolution_m_));
  const int end_row = static_cast<int>(std::floor(to.y() / resolution_m_));
  const Eigen::Vector2d way = to - from;
  const int right = way.x() > 0 ? 1 : -1;
  const int up = way.y() > 0 ? 1 : -1;
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double per_column = way.x() != 0 ? std::abs(resolution_m_ / way.x()) : kNever;
  const double per_row = way.y() != 0 ? std::abs(resolution_m_ / way.y()) : kNever;
  double next_column =
      way.x() != 0 ? ((column + (right > 0 ? 1 : 0)) * resolution_m_ - from.x()) / way.x() : kNever;
  double next_row = way.y() != 0 ? ((row + (up > 0 ? 1 : 0)) * resolution_m_ - from.y()) / way.y() : kNever;
  const int steps = std::abs(end_column - column) + std::abs(end_row - row);
  for (int i = 0; i < steps; ++i) {
    change(cell(column, row).passes, sign);
    if (next_column < next_row) {
      column += right;
      next_column += per_column;
    } else {
      row += up;
      next_row += per_row;
    }
  }
  Count& end = cell(end_column, end_row);
  change(hit ? end.hits : end.passes, sign);
  return static_cast<std::size_t>(steps) + 1;
}

MapRenderer::Tile& MapRenderer::tile(int tile_column, int tile_row) {
  if (last_tile_ && tile_column == last_tile_column_ && tile_row == last_tile_row_) return *last_tile_;
  auto& entry = tiles_[key_of(tile_column, tile_row)];
  if (!entry) {
    entry = std::make_unique<Tile>();
    const bool first = tiles_.size() == 1;
    left_tile_ = first ? tile_column : std::min(left_tile_, tile_column);
    right_tile_ = first ? tile_column : std::max(right_tile_, tile_column);
    bottom_tile_ = first ? tile_row : std::min(bottom_tile_, tile_row);
    top_tile_ = first ? tile_row : std::max(top_tile_, tile_row);
  }
  last_tile_ = entry.get();
  last_tile_column_ = tile_column;
  last_tile_row_ = tile_row;
  last_tile_->changed = true;
  return *last_tile_;
}

MapRenderer::Count& MapRenderer::cell(int column, int row) {
  constexpr int kMask = kTileCells - 1;
  Tile& holder = tile(column >> kTileBits, row >> kTileBits);
  const int index = (row & kMask) * kTileCells + (column & kMask);
  return holder.counts[static_cast<std::size_t>(index)];
}

std::int8_t MapRenderer::value(const Count& count) const {
  const std::uint32_t seen = count.hits + count.passes;
  if (seen == 0) return OccupancyGrid::kUnknown;
  return count.hits > occupied_threshold_ * seen ? OccupancyGrid::kOccupied : OccupancyGrid::kFree;
}

std::shared_ptr<const OccupancyGrid> MapRenderer::map(std::size_t most_tiles) {
  last_tile_ = nullptr;  // so that the next drawing marks its tile again
  fit_grid();
  std::size_t copied = 0;
  complete_ = true;
  for (const auto& [key, tile] : tiles_) {
    if (!tile->changed) continue;
    if (copied == most_tiles) {
      complete_ = false;
      break;
    }
    copy_tile(static_cast<int>(static_cast<std::int32_t>(key >> 32U)),
              static_cast<int>(static_cast<std::int32_t>(key & 0xFFFFFFFFU)), *tile);
    tile->changed = false;
    ++copied;
  }
  return std::make_shared<const OccupancyGrid>(grid_);
}

/// Makes the grid cover all tiles; what it held moves with it.
void MapRenderer::fit_grid() {
  if (tiles_.empty()) return;
  const auto width = static_cast<std::size_t>(right_tile_ - left_tile_ + 1) << kTileBits;
  const auto height = static_cast<std::size_t>(top_tile_ - bottom_tile_ + 1) << kTileBits;
  if (width == grid_.width && height == grid_.height && left_tile_ == first_tile_column_ &&
      bottom_tile_ == first_tile_row_)
    return;
  std::vector<std::int8_t> wider(width * height, OccupancyGrid::kUnknown);
  const auto right = static_cast<std::size_t>(first_tile_column_ - left_tile_) << kTileBits;
  const auto up = static_cast<std::size_t>(first_tile_row_ - bottom_tile_) << kTileBits;
  for (std::size_t row = 0; row < grid_.height; ++row)
    std::copy_n(grid_.cells.begin() + static_cast<std::ptrdiff_t>(row * grid_.width), grid_.width,
                wider.begin() + static_cast<std::ptrdiff_t>((row + up) * width + right));
  first_tile_column_ = left_tile_;
  first_tile_row_ = bottom_tile_;
  grid_.width = width;
  grid_.height = height;
  grid_.origin = {left_tile_ * kTileCells * resolution_m_, bottom_tile_ * kTileCells * resolution_m_, 0};
  grid_.cells = std::move(wider);
}

void MapRenderer::copy_tile(int tile_column, int tile_row, const Tile& from) {
  const auto column = static_cast<std::size_t>(tile_column - first_tile_column_) << kTileBits;
  const auto row = static_cast<std::size_t>(tile_row - first_tile_row_) << kTileBits;
  constexpr auto kSide = static_cast<std::size_t>(kTileCells);
  for (std::size_t r = 0; r < kSide; ++r)
    for (std::size_t c = 0; c < kSide; ++c)
      grid_.cells[(row + r) * grid_.width + column + c] = value(from.counts[r * kSide + c]);
}

}  // namespace extperfc::mapping
