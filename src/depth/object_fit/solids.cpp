#include "depth/object_fit/solids.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace extperfc::depth {
namespace {

constexpr int kYaws = 6;                          // starts of a cube over a quarter rotation
constexpr double kQuarter = 1.57079632679489662;  // [rad]

double sphere_distance(const Numbers& sphere, const Eigen::Vector3d& point) {
  return (point - Eigen::Vector3d(sphere[0], sphere[1], sphere[2])).norm() - sphere[2];
}

double cone_distance(const Numbers& cone, const Eigen::Vector3d& point) {
  const double radius = cone[2];
  const double height = cone[3];
  const double from_axis = std::hypot(point.x() - cone[0], point.y() - cone[1]);
  // Of the side's line from the rim (radius, 0) to the tip (0, height); above the tip, of the tip.
  const double slant = std::hypot(radius, height);
  const double along = ((radius - from_axis) * radius + point.z() * height) / slant;
  if (along > slant) return std::hypot(from_axis, point.z() - height);
  return (from_axis * height + point.z() * radius - radius * height) / slant;
}

double cube_distance(const Numbers& cube, const Eigen::Vector3d& point) {
  const double half = 0.5 * cube[2];
  const double c = std::cos(cube[3]);
  const double s = std::sin(cube[3]);
  const double dx = point.x() - cube[0];
  const double dy = point.y() - cube[1];
  // The face that it stands on is never seen: the cube goes on below.
  const Eigen::Vector3d beyond(std::abs(c * dx + s * dy) - half, std::abs(c * dy - s * dx) - half,
                               point.z() - cube[2]);
  const double inside = std::min(0.0, beyond.maxCoeff());
  return beyond.cwiseMax(0.0).norm() + inside;
}

/// Middle of the points above a height, in the plane.
Eigen::Vector2d middle_above(const std::vector<Eigen::Vector3d>& points, double height) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (const auto& point : points) {
    if (point.z() < height) continue;
    sum += point.head<2>();
    ++count;
  }
  return sum / std::max(1, count);
}

/// Height that a fraction of the points stays below.
double height_of(const std::vector<Eigen::Vector3d>& points, double fraction) {
  std::vector<double> heights;
  heights.reserve(points.size());
  for (const auto& point : points) heights.push_back(point.z());
  const auto place =
      heights.begin() + static_cast<std::ptrdiff_t>(fraction * static_cast<double>(heights.size() - 1));
  std::nth_element(heights.begin(), place, heights.end());
  return *place;
}

Numbers numbers_of(std::initializer_list<double> values) {
  Numbers numbers(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), numbers.data());
  return numbers;
}

}  // namespace

double half_width(const std::vector<Eigen::Vector3d>& points) {
  const auto [low, high] = std::minmax_element(points.begin(), points.end(),
                                               [](const auto& a, const auto& b) { return a.y() < b.y(); });
  return 0.5 * (high->y() - low->y());
}

int number_count(FitShape shape) {
  return shape == FitShape::kSphere ? 3 : 4;
}

double distance(FitShape shape, const Numbers& numbers, const Eigen::Vector3d& point) {
  switch (shape) {
    case FitShape::kSphere:
      return sphere_distance(numbers, point);
    case FitShape::kCone:
      return cone_distance(numbers, point);
    case FitShape::kCube:
      break;
  }
  return cube_distance(numbers, point);
}

Eigen::Vector3d size_of(FitShape shape, const Numbers& numbers) {
  switch (shape) {
    case FitShape::kSphere:
      return Eigen::Vector3d::Constant(2 * numbers[2]);
    case FitShape::kCone:
      return {2 * numbers[2], 2 * numbers[2], numbers[3]};
    case FitShape::kCube:
      break;
  }
  return Eigen::Vector3d::Constant(numbers[2]);
}

std::vector<Numbers> starts(FitShape shape, const std::vector<Eigen::Vector3d>& points) {
  const double top = height_of(points, 0.97);
  const Eigen::Vector2d middle = middle_above(points, 0.8 * top);
  if (shape == FitShape::kSphere) return {numbers_of({middle.x(), middle.y(), 0.5 * top})};
  if (shape == FitShape::kCone) return {numbers_of({middle.x(), middle.y(), half_width(points), 1.05 * top})};
  std::vector<Numbers> all;
  all.reserve(kYaws);
  for (int i = 0; i < kYaws; ++i)
    all.push_back(numbers_of({middle.x(), middle.y(), top, i * kQuarter / kYaws}));
  return all;
}

}  // namespace extperfc::depth
