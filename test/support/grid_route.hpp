#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/path.hpp"

namespace extperfc {

/// Costs around lethal cells as costmap_2d has them, by brute force.
inline void inflate(navigate::CostGrid& grid, const navigate::Inflation& inflation) {
  using namespace navigate;  // NOLINT(google-build-using-namespace)
  const CostGrid bare = grid;
  const int reach = static_cast<int>(std::ceil(inflation.radius_m / grid.resolution_m));
  std::vector<std::pair<Cell, Cost>> stamp;
  for (int row = -reach; row <= reach; ++row)
    for (int column = -reach; column <= reach; ++column) {
      const double distance = grid.resolution_m * std::hypot(row, column);
      if (distance > inflation.radius_m) continue;
      stamp.emplace_back(Cell{column, row}, inflation.cost_at(distance));
    }
  for (int row = 0; row < grid.height; ++row)
    for (int column = 0; column < grid.width; ++column) {
      if (bare.at({column, row}) != kLethalCost) continue;
      for (const auto& entry : stamp) {
        const Cell cell{column + entry.first.column, row + entry.first.row};
        if (!grid.contains(cell) || grid.at(cell) == kUnknownCost) continue;
        grid.at(cell) = std::max(grid.at(cell), entry.second);
      }
    }
  grid.inflation = inflation;
}

/// A path of cells with small costs (Dijkstra), smoothed, heading along it. For tests of what follows paths;
/// it is checked with the footprint, and empty where that touches.
class GridRoute {
 public:
  explicit GridRoute(const navigate::CostGrid& grid) : grid_(grid) {}

  [[nodiscard]] std::optional<navigate::Path> plan(const navigate::Footprint& footprint,
                                                   const Eigen::Vector2d& start,
                                                   const Eigen::Vector2d& goal) {
    const auto from = grid_.cell_of(start);
    const auto to = grid_.cell_of(goal);
    if (!from || !to || !search(*to, *from)) return std::nullopt;
    std::vector<Eigen::Vector2d> points = descend(*from, *to);
    points.front() = start;
    points.back() = goal;
    for (int i = 0; i < 40; ++i) smooth(points);
    const navigate::Path path = with_headings(evenly(points));
    const bool free = std::all_of(path.poses.begin(), path.poses.end(), [&](const Pose2& pose) {
      return contact(grid_, footprint, pose) == navigate::Contact::kFree;
    });
    return free ? std::optional<navigate::Path>(path) : std::nullopt;
  }

 private:
  using Entry = std::pair<double, std::size_t>;

  bool search(navigate::Cell from, navigate::Cell to) {
    cost_.assign(grid_.cells.size(), std::numeric_limits<double>::infinity());
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    cost_[grid_.index(from)] = 0;
    open.push({0, grid_.index(from)});
    while (!open.empty()) {
      const auto [cost, index] = open.top();
      open.pop();
      if (cost > cost_[index]) continue;
      if (index == grid_.index(to)) return true;
      const navigate::Cell at{static_cast<int>(index) % grid_.width, static_cast<int>(index) / grid_.width};
      for (int row = -1; row <= 1; ++row)
        for (int column = -1; column <= 1; ++column) {
          const navigate::Cell next{at.column + column, at.row + row};
          if (!grid_.contains(next) || grid_.at(next) >= navigate::kInscribedCost) continue;
          const double step = std::hypot(row, column) * (1 + 0.06 * grid_.at(next));
          const std::size_t i = grid_.index(next);
          if (cost + step >= cost_[i]) continue;
          cost_[i] = cost + step;
          open.push({cost + step, i});
        }
    }
    return false;
  }

  [[nodiscard]] std::vector<Eigen::Vector2d> descend(navigate::Cell at, navigate::Cell to) const {
    std::vector<Eigen::Vector2d> points{grid_.middle_of(at)};
    while (grid_.index(at) != grid_.index(to)) {
      navigate::Cell best = at;
      for (int row = -1; row <= 1; ++row)
        for (int column = -1; column <= 1; ++column) {
          const navigate::Cell next{at.column + column, at.row + row};
          if (grid_.contains(next) && cost_[grid_.index(next)] < cost_[grid_.index(best)]) best = next;
        }
      at = best;
      points.push_back(grid_.middle_of(at));
    }
    return points;
  }

  static void smooth(std::vector<Eigen::Vector2d>& points) {
    std::vector<Eigen::Vector2d> result = points;
    for (std::size_t i = 1; i + 1 < points.size(); ++i)
      result[i] = 0.25 * points[i - 1] + 0.5 * points[i] + 0.25 * points[i + 1];
    points = std::move(result);
  }

  static std::vector<Eigen::Vector2d> evenly(const std::vector<Eigen::Vector2d>& points) {
    std::vector<Eigen::Vector2d> result{points.front()};
    for (const Eigen::Vector2d& point : points)
      if ((point - result.back()).norm() >= 0.05) result.push_back(point);
    if ((points.back() - result.back()).norm() > 1e-6) result.push_back(points.back());
    return result;
  }

  static navigate::Path with_headings(const std::vector<Eigen::Vector2d>& points) {
    navigate::Path path;
    path.poses.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d along = points[std::min(points.size() - 1, i + 4)] - points[i > 4 ? i - 4 : 0];
      path.poses.push_back({points[i].x(), points[i].y(), std::atan2(along.y(), along.x())});
    }
    return path;
  }

  const navigate::CostGrid& grid_;
  std::vector<double> cost_;
};

}  // namespace extperfc
