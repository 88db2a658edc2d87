#include "arm/collision/sphere_cover.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace extperfc::arm {
namespace {

constexpr int kMaxBalls = 64;
constexpr double kThickRatio = 0.4;  // excess that a thick part may have, of its smallest half width
constexpr double kFlatRatio = 0.5;   // a cylinder with less half height than this times its radius is flat
constexpr double kFiner = 0.95;

/// Half lengths of the cells when a box is cut into equal cells, near cubes of half length `target`.
Eigen::Vector3d cell_half(const Eigen::Vector3d& half, double target, std::array<int, 3>& counts) {
  Eigen::Vector3d cell;
  for (int axis = 0; axis < 3; ++axis) {
    counts[axis] = std::max(1, static_cast<int>(std::ceil(half[axis] / target)));
    cell[axis] = half[axis] / counts[axis];
  }
  return cell;
}

std::vector<Ball> balls_of_cells(const ConvexPart& part, double target) {
  std::array<int, 3> counts{};
  const Eigen::Vector3d cell = cell_half(part.half, target, counts);
  std::vector<Ball> balls;
  for (int x = 0; x < counts[0]; ++x)
    for (int y = 0; y < counts[1]; ++y)
      for (int z = 0; z < counts[2]; ++z) {
        const Eigen::Vector3d centre =
            Eigen::Vector3d(2 * x + 1, 2 * y + 1, 2 * z + 1).cwiseProduct(cell) - part.half;
        if (distance_bound(part, centre) < cell.norm()) balls.push_back({centre, cell.norm()});
      }
  return balls;
}

std::vector<Ball> cut_box(const ConvexPart& part, double excess_m) {
  const double allowed = std::max(excess_m, kThickRatio * part.half.minCoeff());
  double target = part.half.maxCoeff();
  std::vector<Ball> balls = balls_of_cells(part, target);
  for (;; target *= kFiner) {
    std::array<int, 3> counts{};
    const Eigen::Vector3d cell = cell_half(part.half, target, counts);
    std::vector<Ball> finer = balls_of_cells(part, target);
    if (finer.size() > kMaxBalls) return balls;
    balls = std::move(finer);
    if (cell.norm() - cell.minCoeff() <= allowed) return balls;
  }
}

std::vector<Ball> cut_cylinder(const ConvexPart& part, double excess_m) {
  const double radius = part.half.x(), half = part.half.z();
  const double widest = std::sqrt(excess_m * (2 * radius + excess_m));  // half height of a slice
  const int count = std::min(kMaxBalls, static_cast<int>(std::ceil(half / widest)));
  std::vector<Ball> balls;
  balls.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    balls.push_back({{0, 0, half * ((2 * i + 1.0) / count - 1)}, std::hypot(radius, half / count)});
  return balls;
}

}  // namespace

std::vector<Ball> sphere_cover(const ConvexPart& part, double excess_m) {
  if (part.kind == PartKind::kSphere) return {{Eigen::Vector3d::Zero(), part.half.x()}};
  const bool rod = part.kind == PartKind::kCylinder && part.half.z() >= kFlatRatio * part.half.x();
  return rod ? cut_cylinder(part, excess_m) : cut_box(part, excess_m);
}

}  // namespace extperfc::arm
