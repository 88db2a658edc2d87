#include "navigate/global/path_shape.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace extperfc::navigate {

namespace {

constexpr double kDenseStep_m = 0.1;
constexpr double kMaxStep_rad = 0.2;
constexpr double kBend_rad = 0.19;        // a differential base rotates in place at sharper corners
constexpr double kHeadingLength_m = 0.5;  // over which a holonomic base comes to head along its path

/// Moves one corner in eight directions, by steps that halve, while the cost of both its segments falls.
bool move_corner(CellSpace& cells, const Eigen::Vector2d& before, Eigen::Vector2d& corner,
                 const Eigen::Vector2d& after) {
  bool moved = false;
  double cost = cells.line_cost(before, corner) + cells.line_cost(corner, after);
  for (double step = 1; step > 0.05; step *= 0.5)
    for (int direction = 0; direction < 8; ++direction) {
      const Eigen::Vector2d moved_to =
          corner + step * Eigen::Vector2d(std::cos(direction * M_PI_4), std::sin(direction * M_PI_4));
      const double first = cells.line_cost(before, moved_to, cost);
      if (!(first < cost)) continue;
      const double both = first + cells.line_cost(moved_to, after, cost - first);
      if (!(both < cost - 1e-4)) continue;
      corner = moved_to;
      cost = both;
      moved = true;
    }
  return moved;
}

bool remove_corners(CellSpace& cells, Polyline& line) {
  bool removed = false;
  Polyline kept{line.front()};
  for (std::size_t i = 1; i + 1 < line.size(); ++i) {
    const double over = cells.line_cost(kept.back(), line[i]) + cells.line_cost(line[i], line[i + 1]);
    if (cells.line_cost(kept.back(), line[i + 1]) <= over + 1e-9)
      removed = true;
    else
      kept.push_back(line[i]);
  }
  kept.push_back(line.back());
  line = std::move(kept);
  return removed;
}

Polyline split_evenly(const Polyline& line, double spacing) {
  Polyline points{line.front()};
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Eigen::Vector2d& from = line[i - 1];
    const int parts = std::max(1, static_cast<int>(std::ceil((line[i] - from).norm() / spacing)));
    for (int k = 1; k < parts; ++k) points.emplace_back(from + (line[i] - from) * k / parts);
    points.push_back(line[i]);
  }
  return points;
}

double direction_of(const Eigen::Vector2d& step) {
  return std::atan2(step.y(), step.x());
}

/// Directions of the path at each point, over about 0.2 m to both sides, without jumps of 2 pi.
std::vector<double> directions(const std::vector<Eigen::Vector2d>& points, double first) {
  std::vector<double> out(points.size(), first);
  double last = first;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t before = i < 2 ? 0 : i - 2;
    const std::size_t after = std::min(i + 2, points.size() - 1);
    const Eigen::Vector2d step = points[after] - points[before];
    if (step.norm() > 1e-9) last += wrap_angle(direction_of(step) - last);
    out[i] = last;
  }
  return out;
}

/// Minimizes sum(weight * (yaw - wanted)^2 * d) + sum(length^2 * (change of yaw)^2 / d), d: the distance
/// between points, with both ends fixed: a tridiagonal system, solved by Thomas' algorithm.
std::vector<double> follow(const std::vector<double>& wanted, const std::vector<double>& distance_m,
                           double first, double last, double weight) {
  const std::size_t n = wanted.size();
  std::vector<double> upper(n, 0);
  std::vector<double> yaw(n, first);
  const auto stiffness = [&](std::size_t i) {  // between i and i + 1
    return kHeadingLength_m * kHeadingLength_m / std::max(distance_m[i], 1e-3);
  };
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double pull = weight * 0.5 * (distance_m[i - 1] + distance_m[i]);
    const double before = stiffness(i - 1);
    const double after = stiffness(i);
    const double diagonal = before + after + pull - before * upper[i - 1];
    upper[i] = after / diagonal;
    yaw[i] = (pull * wanted[i] + before * yaw[i - 1]) / diagonal;
  }
  yaw[n - 1] = last;
  for (std::size_t i = n - 1; i-- > 1;) yaw[i] += upper[i] * yaw[i + 1];
  return yaw;
}

std::vector<Pose2> head_softly(const std::vector<Eigen::Vector2d>& points, const Pose2& start,
                               const Pose2& goal, double heading_weight) {
  std::vector<double> distance_m(points.size(), 0);
  double length_m = 0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    length_m += distance_m[i] = (points[i + 1] - points[i]).norm();
  const std::vector<double> wanted = directions(points, start.yaw);
  const double weight = heading_weight * std::min(1.0, length_m / (3 * kHeadingLength_m));
  const double near = weight > 0 ? wanted.back() : start.yaw;
  const double last = near + wrap_angle(goal.yaw - near);
  const std::vector<double> yaw = follow(wanted, distance_m, start.yaw, last, weight);
  std::vector<Pose2> poses;
  poses.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    poses.push_back({points[i].x(), points[i].y(), wrap_angle(yaw[i])});
  return poses;
}

std::vector<Pose2> head_along(const std::vector<Eigen::Vector2d>& points, const Pose2& start,
                              const Pose2& goal) {
  std::vector<Pose2> poses{start};
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Eigen::Vector2d step = points[i + 1] - points[i];
    if (step.norm() < 1e-9) continue;
    const double yaw = direction_of(step);
    const double bend = std::abs(wrap_angle(yaw - poses.back().yaw));
    if (bend > kBend_rad || i == 0) poses.push_back({points[i].x(), points[i].y(), yaw});
    poses.push_back({points[i + 1].x(), points[i + 1].y(), yaw});
  }
  poses.push_back(goal);
  return poses;
}

}  // namespace

double cost_along(CellSpace& cells, const Polyline& line) {
  double cost = 0;
  for (std::size_t i = 1; i < line.size(); ++i) cost += cells.line_cost(line[i - 1], line[i]);
  return cost;
}

std::optional<Eigen::Vector2d> first_blocked(CellSpace& cells, const Polyline& line) {
  for (const Eigen::Vector2d& point : split_evenly(line, 0.25))
    if (cells.weight(static_cast<int>(std::floor(point.x())), static_cast<int>(std::floor(point.y()))) == 0)
      return point;
  return std::nullopt;
}

Polyline pull(CellSpace& cells, Polyline line) {
  constexpr int kMaxRounds = 12;
  for (int round = 0; round < kMaxRounds; ++round) {
    bool changed = remove_corners(cells, line);
    for (std::size_t i = 1; i + 1 < line.size(); ++i)
      changed = move_corner(cells, line[i - 1], line[i], line[i + 1]) || changed;
    if (!changed) break;
  }
  return line;
}

Polyline smooth(CellSpace& cells, const Polyline& line, double spacing) {
  constexpr int kRounds = 30;
  constexpr double kRate = 0.1;  // below 1/8 the descent is stable
  constexpr double kMaxRise = 1.01;
  Polyline points = split_evenly(line, spacing);
  std::vector<double> limit(points.size(), 0);
  for (std::size_t i = 1; i + 1 < points.size(); ++i)
    limit[i] =
        kMaxRise * (cells.line_cost(points[i - 1], points[i]) + cells.line_cost(points[i], points[i + 1]));
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t i = 2; i + 2 < points.size(); ++i) {
      const Eigen::Vector2d change =
          kRate * (4 * (points[i - 1] + points[i + 1]) - 6 * points[i] - points[i - 2] - points[i + 2]);
      if (change.squaredNorm() < 1e-6) continue;
      const Eigen::Vector2d moved = points[i] + change;
      const double first = cells.line_cost(points[i - 1], moved, limit[i]);
      if (first + cells.line_cost(moved, points[i + 1], limit[i]) <= limit[i]) points[i] = moved;
    }
  return points;
}

std::vector<Pose2> add_headings(const std::vector<Eigen::Vector2d>& points_m, const Pose2& start,
                                const Pose2& goal, const GridPlannerParams& params) {
  std::vector<Pose2> poses = params.base == BaseKind::kHolonomic
                                 ? head_softly(points_m, start, goal, params.heading_weight)
                                 : head_along(points_m, start, goal);
  poses.front() = start;
  poses.back() = goal;
  return densify(poses);
}

std::vector<Pose2> densify(const std::vector<Pose2>& poses) {
  constexpr double kRounding = 0.999;
  std::vector<Pose2> out;
  out.reserve(2 * poses.size());
  out.push_back(poses.front());
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Pose2 from = poses[i - 1];
    const Pose2 to = poses[i];
    const double yaw = wrap_angle(to.yaw - from.yaw);
    const double parts = std::max(std::hypot(to.x - from.x, to.y - from.y) / (kRounding * kDenseStep_m),
                                  std::abs(yaw) / (kRounding * kMaxStep_rad));
    const int count = std::max(1, static_cast<int>(std::ceil(parts)));
    for (int k = 1; k < count; ++k) {
      const double part = static_cast<double>(k) / count;
      out.push_back({from.x + part * (to.x - from.x), from.y + part * (to.y - from.y),
                     wrap_angle(from.yaw + part * yaw)});
    }
    out.push_back(to);
  }
  return out;
}

}  // namespace extperfc::navigate
