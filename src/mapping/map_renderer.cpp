#include "mapping/map_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

namespace extperfc::mapping {

namespace {

constexpr double kMovedCells = 0.4;  // of a key frame, before it is redrawn
constexpr double kRedrawnRad = 0.004;
constexpr double kFarthestM = 5000.0;  // larger coordinates are invalid

std::uint64_t key_of(int tile_column, int tile_row) {
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(tile_column)) << 32U) |
         static_cast<std::uint32_t>(tile_row);
}

/// A ray on its path from cell to cell of a tile (Amanatides and Woo 1987).
struct RayWalk {
  int x;  ///< within the tile
  int y;
  int right;
  int up;
  double next_column;  ///< fraction of the ray up to the next one
  double next_row;
  double per_column;
  double per_row;
  int left;  ///< steps

  /// Up to the tile's rim or the ray's end.
  template <int kSide, typename Counts>
  void count_passes(Counts& counts, std::uint32_t one) {
    do {  // the direction of the next step is unpredictable: no branches
      auto& passes = counts[static_cast<std::size_t>(y) * kSide + static_cast<std::size_t>(x)].passes;
      passes = static_cast<std::decay_t<decltype(passes)>>(passes + one);
      const bool sideways = next_column < next_row;
      x += sideways ? right : 0;
      y += sideways ? 0 : up;
      next_column += sideways ? per_column : 0.0;
      next_row += sideways ? 0.0 : per_row;
    } while (--left > 0 && ((x | y) & ~(kSide - 1)) == 0);
  }
};

}  // namespace

MapRenderer::MapRenderer(double resolution_m, double occupied_threshold)
    : resolution_m_(resolution_m), occupied_threshold_(occupied_threshold), image_(resolution_m) {}

bool MapRenderer::update(const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses,
                         std::size_t max_cells) {
  std::size_t cells = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const bool is_new = i >= drawn_.size();
    if (!is_new) {
      const double away = std::hypot(poses[i].x - drawn_[i].x, poses[i].y - drawn_[i].y);
      if (away < kMovedCells * resolution_m_ &&
          std::abs(wrap_angle(poses[i].yaw - drawn_[i].yaw)) < kRedrawnRad)
        continue;
    }
    if (cells >= max_cells) return false;
    if (is_new)
      drawn_.emplace_back();
    else
      cells += draw(frames[i].points, drawn_[i], -1);
    cells += draw(frames[i].points, poses[i], +1);
    drawn_[i] = poses[i];
  }
  return true;
}

std::size_t MapRenderer::forget(std::size_t frame, const ScanPoints& points) {
  return frame < drawn_.size() ? draw(points, drawn_[frame], -1) : 0;
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

/// Every cell that the line touches from its start up to the cell before its end.
std::size_t MapRenderer::draw_ray(const Eigen::Vector2d& from, const Eigen::Vector2d& to, bool hit,
                                  int sign) {
  if (!(from.cwiseAbs().maxCoeff() < kFarthestM && to.cwiseAbs().maxCoeff() < kFarthestM)) return 0;
  int column = static_cast<int>(std::floor(from.x() / resolution_m_));
  int row = static_cast<int>(std::floor(from.y() / resolution_m_));
  const int end_column = static_cast<int>(std::floor(to.x() / resolution_m_));
  const int end_row = static_cast<int>(std::floor(to.y() / resolution_m_));
  const Eigen::Vector2d ray = to - from;
  const int right = ray.x() > 0 ? 1 : -1;
  const int up = ray.y() > 0 ? 1 : -1;
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const auto first_border = [&](double along, int cell, int step, double start) {
    return along != 0 ? ((cell + (step > 0 ? 1 : 0)) * resolution_m_ - start) / along : kNever;
  };
  const int steps = std::abs(end_column - column) + std::abs(end_row - row);
  const auto one = static_cast<std::uint32_t>(sign);  // -1 wraps round
  RayWalk walk{0,
               0,
               right,
               up,
               first_border(ray.x(), column, right, from.x()),
               first_border(ray.y(), row, up, from.y()),
               ray.x() != 0 ? std::abs(resolution_m_ / ray.x()) : kNever,
               ray.y() != 0 ? std::abs(resolution_m_ / ray.y()) : kNever,
               steps};
  while (walk.left > 0) {
    Tile& holder = tile(column >> kTileBits, row >> kTileBits);
    walk.x = column & kTileMask;
    walk.y = row & kTileMask;
    const int tile_column = column - walk.x;
    const int tile_row = row - walk.y;
    holder.add_ray(sign);
    if (holder.few)
      walk.count_passes<kTileCells>(*holder.few, one);
    else
      walk.count_passes<kTileCells>(*holder.many, one);
    holder.release();
    column = tile_column + walk.x;
    row = tile_row + walk.y;
  }
  Tile& last = tile(end_column >> kTileBits, end_row >> kTileBits);
  last.add_ray(sign);
  const auto count_end = [&](auto& counts) {
    auto& end = counts[static_cast<std::size_t>(end_row & kTileMask) * kTileCells +
                       static_cast<std::size_t>(end_column & kTileMask)];
    auto& number = hit ? end.hits : end.passes;
    number = static_cast<std::decay_t<decltype(number)>>(number + one);
  };
  if (last.few)
    count_end(*last.few);
  else
    count_end(*last.many);
  last.release();
  return static_cast<std::size_t>(steps) + 1;
}

MapRenderer::Tile& MapRenderer::tile(int tile_column, int tile_row) {
  if (last_tile_ && tile_column == last_tile_column_ && tile_row == last_tile_row_) return *last_tile_;
  auto& entry = tiles_[key_of(tile_column, tile_row)];
  if (!entry) {
    entry = std::make_unique<Tile>();
    entry->column = tile_column;
    entry->row = tile_row;
    const bool first = tiles_.size() == 1;
    left_tile_ = first ? tile_column : std::min(left_tile_, tile_column);
    right_tile_ = first ? tile_column : std::max(right_tile_, tile_column);
    bottom_tile_ = first ? tile_row : std::min(bottom_tile_, tile_row);
    top_tile_ = first ? tile_row : std::max(top_tile_, tile_row);
  }
  last_tile_ = entry.get();
  last_tile_column_ = tile_column;
  last_tile_row_ = tile_row;
  if (!std::exchange(last_tile_->changed, true)) changed_tiles_.push_back(last_tile_);
  return *last_tile_;
}

void MapRenderer::Tile::add_ray(int sign) {
  rays += sign;
  if (!in_use()) few = std::make_unique<Counts<std::uint8_t>>();
  if (rays <= kFewRays || many) return;
  many = std::make_unique<Counts<std::uint32_t>>();
  std::transform(few->begin(), few->end(), many->begin(), [](const Count<std::uint8_t>& count) {
    return Count<std::uint32_t>{count.hits, count.passes};
  });
  few.reset();
}

void MapRenderer::Tile::release() {
  if (rays != 0) return;
  few.reset();
  many.reset();
}

std::shared_ptr<const OccupancyGrid> MapRenderer::map(const MapBounds& bounds) {
  last_tile_ = nullptr;  // so that the next drawing marks its tile again
  if (!changed_tiles_.empty() && image_.open(extent(), bounds.copied_cells)) draw_changed_tiles(bounds.tiles);
  complete_ = changed_tiles_.empty();
  return image_.show();
}

std::size_t MapRenderer::counts_size() const {
  std::size_t size = 0;
  for (const auto& [key, tile] : tiles_) {
    if (tile->few) size += sizeof(*tile->few);
    if (tile->many) size += sizeof(*tile->many);
  }
  return size;
}

MapImage::Extent MapRenderer::extent() const {
  return {left_tile_ * kTileCells, bottom_tile_ * kTileCells, (right_tile_ - left_tile_ + 1) * kTileCells,
          (top_tile_ - bottom_tile_ + 1) * kTileCells};
}

/// Tiles outside of the image wait until it has grown.
void MapRenderer::draw_changed_tiles(std::size_t max_tiles) {
  const MapImage::Extent& drawn = image_.extent();
  auto waiting = changed_tiles_.begin();
  auto next = waiting;
  for (; next != changed_tiles_.end() && max_tiles > 0; ++next) {
    Tile& tile = **next;
    const int column = tile.column * kTileCells - drawn.column;
    const int row = tile.row * kTileCells - drawn.row;
    if (column < 0 || column >= drawn.width || row < 0 || row >= drawn.height) {
      *waiting++ = &tile;
      continue;
    }
    draw_tile(tile);
    tile.changed = false;
    --max_tiles;
  }
  changed_tiles_.erase(waiting, next);
}

void MapRenderer::draw_tile(const Tile& tile) {
  for (int row = 0; row < kTileCells; ++row) {
    std::int8_t* cells = image_.cells_at(tile.column * kTileCells, tile.row * kTileCells + row);
    if (tile.few)
      draw_cells(*tile.few, row, cells);
    else if (tile.many)
      draw_cells(*tile.many, row, cells);
    else
      std::fill_n(cells, kTileCells, OccupancyGrid::kUnknown);
  }
}

template <typename Number>
void MapRenderer::draw_cells(const Counts<Number>& counts, int row, std::int8_t* cells) const {
  const std::size_t first = static_cast<std::size_t>(row) * kTileCells;
  std::transform(&counts[first], &counts[first] + kTileCells, cells, [&](const Count<Number>& count) {
    const double seen = static_cast<double>(count.hits) + count.passes;
    const std::int8_t known =
        count.hits > occupied_threshold_ * seen ? OccupancyGrid::kOccupied : OccupancyGrid::kFree;
    return seen == 0 ? OccupancyGrid::kUnknown : known;
  });
}

}  // namespace extperfc::mapping
