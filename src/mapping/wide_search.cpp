#include "mapping/wide_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace extperfc::mapping {

namespace {

constexpr std::size_t kProbes = 80;  // points of the scan that are looked up
constexpr double kYawStepRad = 0.03;
constexpr int kTopLevel = SearchPyramid::kLevels - 1;
constexpr std::size_t kMaxCells = 4000 * 4000;  // of a pyramid's level: 400 m

struct CellPoint {
  int column;
  int row;
};

/// The points of a scan rotated to one of the angles searched, in cells, from the window's lower left corner.
using RotatedScan = std::vector<CellPoint>;

int cell_of(double coordinate_m) {
  return static_cast<int>(std::floor(coordinate_m / static_cast<double>(SearchPyramid::kCellM)));
}

struct Node {
  double bound;
  int level;
  int angle;
  int column;  ///< shift in cells
  int row;
  bool operator<(const Node& other) const {
    return bound != other.bound ? bound < other.bound : level > other.level;
  }
};

std::vector<RotatedScan> rotate_scan(const ScanPoints& points, const SearchWindow& window, int yaw_steps) {
  const std::size_t stride = 1 + points.surface.size() / kProbes;
  std::vector<RotatedScan> scans;
  for (int i = -yaw_steps; i <= yaw_steps; ++i) {
    const double yaw = window.centre.yaw + i * kYawStepRad;
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    RotatedScan& scan = scans.emplace_back();
    for (std::size_t k = 0; k < points.surface.size(); k += stride) {
      const auto p = points.surface[k].position.cast<double>().eval();
      scan.push_back({cell_of(window.centre.x - window.half_width_m + c * p.x() - s * p.y()),
                      cell_of(window.centre.y - window.half_width_m + s * p.x() + c * p.y())});
    }
  }
  return scans;
}

double bound_of(const SearchPyramid& pyramid, const RotatedScan& scan, int level, int column, int row) {
  int hits = 0;
  for (const CellPoint& point : scan)
    hits += pyramid.set(level, point.column + column, point.row + row) ? 1 : 0;
  return static_cast<double>(hits) / static_cast<double>(scan.size());
}

}  // namespace

SearchPyramid::SearchPyramid(const SurfaceMap& map) {
  int right = std::numeric_limits<int>::min();
  int top = right;
  first_column_ = first_row_ = std::numeric_limits<int>::max();
  map.visit([&](const SurfaceMap::Surface& surface) {
    first_column_ = std::min(first_column_, cell_of(static_cast<double>(surface.mean.x())));
    first_row_ = std::min(first_row_, cell_of(static_cast<double>(surface.mean.y())));
    right = std::max(right, cell_of(static_cast<double>(surface.mean.x())));
    top = std::max(top, cell_of(static_cast<double>(surface.mean.y())));
  });
  levels_.resize(kLevels);
  if (right < first_column_) {
    first_column_ = first_row_ = 0;
    return;
  }
  constexpr int kMargin = 1 << kTopLevel;  // shifts to the left and downward reach the map from outside
  first_column_ -= kMargin;
  first_row_ -= kMargin;
  columns_ = right - first_column_ + 3;
  rows_ = top - first_row_ + 3;
  const auto cells = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  if (cells > kMaxCells) {
    columns_ = rows_ = 0;
    return;
  }
  std::vector<std::uint8_t> level(cells, 0);
  const auto width = static_cast<std::size_t>(columns_);
  map.visit([&](const SurfaceMap::Surface& surface) {
    const auto c = static_cast<std::size_t>(cell_of(static_cast<double>(surface.mean.x())) - first_column_);
    const auto r = static_cast<std::size_t>(cell_of(static_cast<double>(surface.mean.y())) - first_row_);
    for (std::size_t dr = r - 1; dr <= r + 1; ++dr)  // the margin keeps this inside
      for (std::size_t dc = c - 1; dc <= c + 1; ++dc) level[dr * width + dc] = 1;
  });
  for (int l = 0; l < kLevels; ++l) {
    if (l > 0) {
      const std::size_t reach = std::size_t{1} << (l - 1);
      for (std::size_t r = 0; r < static_cast<std::size_t>(rows_); ++r)
        for (std::size_t c = 0; c + reach < width; ++c)
          level[r * width + c] =
              static_cast<std::uint8_t>(level[r * width + c] | level[r * width + c + reach]);
      for (std::size_t r = 0; r + reach < static_cast<std::size_t>(rows_); ++r)
        for (std::size_t c = 0; c < width; ++c)
          level[r * width + c] =
              static_cast<std::uint8_t>(level[r * width + c] | level[(r + reach) * width + c]);
    }
    auto& bits = levels_[static_cast<std::size_t>(l)];
    bits.assign((cells + 63) / 64, 0);
    for (std::size_t i = 0; i < cells; ++i)
      if (level[i] != 0) bits[i / 64] |= std::uint64_t{1} << (i % 64);
  }
}

namespace {

bool is_new_peak(const std::vector<FoundPose>& found, const Pose2& pose, const PeakOptions& options) {
  return std::none_of(found.begin(), found.end(), [&](const FoundPose& other) {
    return std::hypot(other.pose.x - pose.x, other.pose.y - pose.y) < options.apart_m &&
           std::abs(wrap_angle(other.pose.yaw - pose.yaw)) < options.apart_rad;
  });
}

}  // namespace

SearchWindow on_grid(const SearchWindow& window) {
  const auto step_m = static_cast<double>(SearchPyramid::kCellM);
  const auto to_grid = [](double value, double step) { return step * std::round(value / step); };
  return {{to_grid(window.centre.x, step_m), to_grid(window.centre.y, step_m),
           to_grid(window.centre.yaw, kYawStepRad)},
          step_m * std::ceil(window.half_width_m / step_m + 0.5),
          kYawStepRad * std::ceil(window.half_yaw_rad / kYawStepRad + 0.5)};
}

std::vector<FoundPose> search_peaks(const SearchPyramid& pyramid, const ScanPoints& points,
                                    const SearchWindow& window, double min_score, int max_nodes,
                                    const PeakOptions& options) {
  std::vector<FoundPose> found;
  if (points.surface.empty()) return found;
  const int yaw_steps = std::max(0, static_cast<int>(std::ceil(window.half_yaw_rad / kYawStepRad)));
  const auto scans = rotate_scan(points, window, yaw_steps);
  const int width = std::max(1, cell_of(2 * window.half_width_m));
  std::priority_queue<Node> open;
  int nodes = 0;
  constexpr int kTopStep = 1 << kTopLevel;
  const auto offer = [&](int level, int angle, int column, int row) {
    if (column > width || row > width) return;
    const double bound = bound_of(pyramid, scans[static_cast<std::size_t>(angle)], level, column, row);
    ++nodes;
    if (bound >= min_score) open.push({bound, level, angle, column, row});
  };
  for (int angle = 0; angle <= 2 * yaw_steps; ++angle)
    for (int column = 0; column <= width; column += kTopStep)
      for (int row = 0; row <= width; row += kTopStep) offer(kTopLevel, angle, column, row);
  while (!open.empty() && nodes < max_nodes) {
    const Node node = open.top();
    open.pop();
    if (!found.empty() && node.bound < found.front().score - options.within_best) break;
    if (node.level == 0) {
      const double step = static_cast<double>(SearchPyramid::kCellM);
      const Pose2 pose{window.centre.x - window.half_width_m + node.column * step,
                       window.centre.y - window.half_width_m + node.row * step,
                       wrap_angle(window.centre.yaw + (node.angle - yaw_steps) * kYawStepRad)};
      if (is_new_peak(found, pose, options)) found.push_back({pose, node.bound});
      if (found.size() == options.count) break;
      continue;
    }
    const int half = 1 << (node.level - 1);
    for (int dc = 0; dc <= half; dc += half)
      for (int dr = 0; dr <= half; dr += half)
        offer(node.level - 1, node.angle, node.column + dc, node.row + dr);
  }
  return found;
}

std::optional<FoundPose> search_wide(const SearchPyramid& pyramid, const ScanPoints& points,
                                     const SearchWindow& window, double min_score, int max_nodes) {
  const auto found = search_peaks(pyramid, points, window, min_score, max_nodes, {});
  if (found.empty()) return std::nullopt;
  return found.front();
}

}  // namespace extperfc::mapping
