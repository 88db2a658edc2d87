#include "test/benchmark/map/floor_world.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace extperfc::benchmark {
namespace {

constexpr double kCellM = 2.0;
constexpr double kTinyM = 1e-6;
constexpr double kTouchM = 1e-3;  // a wall belongs to every cell that it touches
constexpr double kShortestGlassM = 1.0;
constexpr double kLongestGlassM = 3.0;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::AlignedBox2d box_of(const Eigen::Vector2d& corner, const Eigen::Vector2d& opposite) {
  return {corner.cwiseMin(opposite), corner.cwiseMax(opposite)};
}

}  // namespace

void FloorWorld::add_floor(const Eigen::Vector2d& corner, const Eigen::Vector2d& opposite) {
  floor_.push_back(box_of(corner, opposite));
}

void FloorWorld::add_box(const Eigen::Vector2d& corner, const Eigen::Vector2d& opposite) {
  const auto box = box_of(corner, opposite);
  for (const int along : {0, 1})
    for (const double at : {box.min()[1 - along], box.max()[1 - along]})
      add_wall({along, at, box.min()[along], box.max()[along], false});
}

void FloorWorld::add_wall(const Wall& wall) {
  if (wall.to - wall.from > kTinyM) walls_.push_back(wall);
}

void FloorWorld::close(double glass_fraction, Rng& rng) {
  for (const auto& area : floor_)
    for (const int along : {1, 0})
      for (const bool high : {false, true}) wall_in(area, {along, high}, glass_fraction, rng);
  build_grid();
}

/// Walls along one side, except where another rectangle lies right behind it.
void FloorWorld::wall_in(const Eigen::AlignedBox2d& area, Side side, double glass_fraction, Rng& rng) {
  const int across = 1 - side.along;
  const double at = side.high ? area.max()[across] : area.min()[across];
  const double behind = side.high ? at + kTinyM : at - kTinyM;
  std::vector<std::pair<double, double>> open;
  for (const auto& other : floor_)
    if (&other != &area && other.min()[across] < behind && behind < other.max()[across])
      open.emplace_back(other.min()[side.along], other.max()[side.along]);
  std::sort(open.begin(), open.end());
  const double end = area.max()[side.along];
  open.emplace_back(end, end);
  double from = area.min()[side.along];
  for (const auto& [first, last] : open) {
    if (from >= end) break;
    if (first > from) add_stretch({side.along, at, from, std::min(first, end), false}, glass_fraction, rng);
    from = std::max(from, last);
  }
}

void FloorWorld::add_stretch(Wall wall, double glass_fraction, Rng& rng) {
  if (glass_fraction <= 0) {
    add_wall(wall);
    return;
  }
  const double end = wall.to;
  while (end - wall.from > kTinyM) {
    wall.to = std::min(end, wall.from + rng.uniform(kShortestGlassM, kLongestGlassM));
    wall.glass = rng.chance(glass_fraction);
    add_wall(wall);
    wall.from = wall.to;
  }
}

void FloorWorld::build_grid() {
  Eigen::AlignedBox2d all;
  for (const auto& area : floor_) all.extend(area);
  low_ = all.min() - Eigen::Vector2d::Ones();
  size_ = cell_of(all.max() + Eigen::Vector2d::Ones()) + Eigen::Vector2i::Ones();
  cells_.assign(static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y()), {});
  for (const Wall& wall : walls_) {
    Eigen::Vector2d from;
    Eigen::Vector2d to;
    from[wall.along] = wall.from;
    to[wall.along] = wall.to;
    from[1 - wall.along] = to[1 - wall.along] = wall.at;
    const Eigen::Vector2i first = cell_of(from - Eigen::Vector2d::Constant(kTouchM));
    const Eigen::Vector2i last = cell_of(to + Eigen::Vector2d::Constant(kTouchM));
    for (int row = first.y(); row <= last.y(); ++row)
      for (int column = first.x(); column <= last.x(); ++column)
        if (has_cell({column, row})) cells_[index({column, row})].push_back(wall);
  }
}

Eigen::Vector2i FloorWorld::cell_of(const Eigen::Vector2d& point) const {
  return ((point - low_) / kCellM).array().floor().cast<int>();
}

bool FloorWorld::has_cell(const Eigen::Vector2i& cell) const {
  return (cell.array() >= 0).all() && (cell.array() < size_.array()).all();
}

std::size_t FloorWorld::index(const Eigen::Vector2i& cell) const {
  return static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(size_.x()) +
         static_cast<std::size_t>(cell.x());
}

void FloorWorld::meet(const std::vector<Wall>& walls, const Eigen::Vector2d& from,
                      const Eigen::Vector2d& direction, Hit& nearest) const {
  for (const Wall& wall : walls) {
    const int across = 1 - wall.along;
    const double range =
        (wall.at - from[across]) / direction[across];  // not finite: the ray is parallel to it
    if (!(range > kTinyM && range < nearest.range_m)) continue;
    const double along = from[wall.along] + range * direction[wall.along];
    if (along >= wall.from - kTinyM && along <= wall.to + kTinyM) nearest = {range, wall.glass};
  }
}

/// From cell to cell, as Amanatides and Woo (1987) do.
FloorWorld::Hit FloorWorld::cast(const Eigen::Vector2d& from, double angle_rad, double max_range_m) const {
  const Eigen::Vector2d direction(std::cos(angle_rad), std::sin(angle_rad));
  Eigen::Vector2i cell = cell_of(from);
  Eigen::Vector2i step(0, 0);
  Eigen::Vector2d next(kInfinity, kInfinity);  // distance to the next border across each axis
  Eigen::Vector2d each(kInfinity, kInfinity);  // distance between two borders
  for (const int axis : {0, 1}) {
    if (direction[axis] == 0) continue;
    step[axis] = direction[axis] > 0 ? 1 : -1;
    each[axis] = kCellM / std::abs(direction[axis]);
    const double border = low_[axis] + kCellM * (cell[axis] + (direction[axis] > 0 ? 1 : 0));
    next[axis] = (border - from[axis]) / direction[axis];
  }
  Hit nearest;
  for (double entered = 0; entered < std::min(max_range_m, nearest.range_m) && has_cell(cell);) {
    meet(cells_[index(cell)], from, direction, nearest);
    const int axis = next.x() < next.y() ? 0 : 1;
    entered = next[axis];
    next[axis] += each[axis];
    cell[axis] += step[axis];
  }
  return nearest;
}

bool FloorWorld::is_floor(const Eigen::Vector2d& point, double margin_m) const {
  return std::any_of(floor_.begin(), floor_.end(), [&](const Eigen::AlignedBox2d& area) {
    return ((point - area.min()).array() > margin_m).all() && ((area.max() - point).array() > margin_m).all();
  });
}

}  // namespace extperfc::benchmark
