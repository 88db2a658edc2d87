#include "test/benchmark/navigate/shortest_path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace extperfc::benchmark {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kTiny = 1e-9;

double distance(const ShortestPath::Vertex& a, double x, double y) {
  return std::hypot(a.x - x, a.y - y);
}

}  // namespace

ShortestPath::ShortestPath(const navigate::CostGrid& costs)
    : width_(costs.width), height_(costs.height), resolution_m_(costs.resolution_m) {
  blocked_.reserve(costs.cells.size());
  for (const navigate::Cost cost : costs.cells) blocked_.push_back(cost >= navigate::kInscribedCost ? 1 : 0);
  const auto count = static_cast<std::size_t>(width_ + 1) * static_cast<std::size_t>(height_ + 1);
  corner_.assign(count, 0);
  found_.assign(count, {kInfinite, {0, 0}, false});
  for (int y = 0; y <= height_; ++y)
    for (int x = 0; x <= width_; ++x) {
      const int low_left = blocked(x - 1, y - 1) ? 1 : 0;
      const int low_right = blocked(x, y - 1) ? 1 : 0;
      const int high_left = blocked(x - 1, y) ? 1 : 0;
      const int high_right = blocked(x, y) ? 1 : 0;
      const int sum = low_left + low_right + high_left + high_right;
      corner_[index({x, y})] = sum == 1 || (sum == 2 && low_left == high_right) ? 1 : 0;
    }
}

void ShortestPath::reach(Vertex v, double length, Vertex from) {
  Found& found = found_[index(v)];
  if (found.done || !(length < found.length - kTiny)) return;
  if (found.length == kInfinite) touched_.push_back(index(v));
  found = {length, from, false};
  open_.push_back({length + distance(v, goal_.x, goal_.y), length, v, 0, v.y, 0, 0});
  std::push_heap(open_.begin(), open_.end());
}

/// A part of a row that the root sees, split where it holds corners.
void ShortestPath::add(Vertex root, double reached, int step, int row, double low, double high) {
  if (row < 0 || row > height_ || high < low - kTiny) return;
  const auto push = [&](double from, double to) {
    if (to - from < kTiny) return;
    // The row is crossed where the straight line to the goal, or to its mirror image, crosses it.
    const double goal_y = (goal_.y - row) * step >= 0 ? goal_.y : 2.0 * row - goal_.y;
    const double part = goal_y == root.y ? 0.5 : (row - root.y) / (goal_y - root.y);
    const double across = std::clamp(root.x + part * (goal_.x - root.x), from, to);
    const double bound = reached + distance(root, across, row) + distance(goal_, across, row);
    open_.push_back({bound, reached, root, step, row, from, to});
    std::push_heap(open_.begin(), open_.end());
  };
  double from = low;
  for (int x = static_cast<int>(std::ceil(low - kTiny)); x <= static_cast<int>(std::floor(high + kTiny));
       ++x) {
    if (!is_corner({x, row}) && !(x == goal_.x && row == goal_.y)) continue;
    reach({x, row}, reached + distance(root, x, row), root);
    push(from, x);
    from = x;
  }
  push(from, high);
}

void ShortestPath::look(Vertex root, double reached, int step, double low, double high) {
  const int cells = step > 0 ? root.y : root.y - 1;
  int left = root.x;
  int right = root.x;
  while (left > low && !blocked(left - 1, cells)) --left;
  while (right < high && !blocked(right, cells)) ++right;
  if (left == right) return;
  add(root, reached, step, root.y + step, std::max<double>(low, left), std::min<double>(high, right));
}

/// Along the row to the next corner.
void ShortestPath::slide(Vertex root, double reached, int direction) {
  for (int x = root.x; x + direction >= 0 && x + direction <= width_;) {
    const int column = direction > 0 ? x : x - 1;
    if (blocked(column, root.y) && blocked(column, root.y - 1)) return;
    x += direction;
    const Vertex at{x, root.y};
    if (!is_corner(at) && !(x == goal_.x && root.y == goal_.y)) continue;
    reach(at, reached + std::abs(x - root.x), root);
    return;
  }
}

/// From a corner: towards the blocked cell around which the path bends, from the direction that it came in.
void ShortestPath::look_around(const Entry& entry) {
  const Vertex at = entry.root;
  const Vertex from = found_[index(at)].from;
  const double dx = at.x - from.x;
  const double dy = at.y - from.y;
  if (dx == 0 && dy == 0) {  // the start
    for (const int step : {1, -1}) look(at, entry.reached, step, -1, width_ + 1.0);
    for (const int step : {1, -1}) slide(at, entry.reached, step);
    return;
  }
  for (const int side : {1, -1}) {  // 1: bends to the left
    bool bends = false;
    for (const int qx : {-1, 1})
      for (const int qy : {-1, 1}) {
        if (!blocked(at.x + (qx > 0 ? 0 : -1), at.y + (qy > 0 ? 0 : -1))) continue;
        bends = bends || side * (dx * qy - dy * qx) > 0;
      }
    if (!bends) continue;
    for (const int step : {1, -1}) {  // side * (dx * step - dy * (x - at.x)) >= 0
      double low = -1;
      double high = width_ + 1.0;
      if (dy == 0 && side * dx * step < 0) continue;
      if (dy != 0) (side * dy > 0 ? high : low) = at.x + dx * step / dy;
      look(at, entry.reached, step, low, high);
    }
    for (const int direction : {1, -1})
      if (side * -dy * direction >= 0 && !(dy == 0 && dx * direction < 0))
        slide(at, entry.reached, direction);
  }
}

void ShortestPath::go_on(const Entry& entry) {
  const int cells = entry.step > 0 ? entry.row : entry.row - 1;
  const int middle = static_cast<int>(std::floor(0.5 * (entry.low + entry.high)));
  if (blocked(middle, cells)) return;
  const double growth =
      static_cast<double>(entry.row + entry.step - entry.root.y) / (entry.row - entry.root.y);
  const double low = entry.root.x + (entry.low - entry.root.x) * growth;
  const double high = entry.root.x + (entry.high - entry.root.x) * growth;
  int left = middle;
  int right = middle + 1;
  while (left > low && !blocked(left - 1, cells)) --left;
  while (right < high && !blocked(right, cells)) ++right;
  add(entry.root, entry.reached, entry.step, entry.row + entry.step, std::max<double>(low, left),
      std::min<double>(high, right));
}

double ShortestPath::length_m(Vertex start, Vertex goal) {
  for (const std::size_t at : touched_) found_[at] = {kInfinite, {0, 0}, false};
  touched_.clear();
  open_.clear();
  goal_ = goal;
  reach(start, 0, start);
  while (!open_.empty()) {
    const Entry entry = open_.front();
    std::pop_heap(open_.begin(), open_.end());
    open_.pop_back();
    Found& root = found_[index(entry.root)];
    if (entry.reached > root.length + kTiny) continue;  // a better way to its root is known
    if (entry.step != 0) {
      go_on(entry);
      continue;
    }
    if (root.done) continue;
    root.done = true;
    if (entry.root.x == goal.x && entry.root.y == goal.y) return resolution_m_ * entry.reached;
    look_around(entry);
  }
  return kInfinite;
}

}  // namespace extperfc::benchmark
