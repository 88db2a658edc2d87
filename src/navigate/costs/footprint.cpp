#include "extperfc/navigate/footprint.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "extperfc/base/demand.hpp"
#include "extperfc/base/math.hpp"

#include "navigate/costs/polygon.hpp"

namespace extperfc::navigate {

namespace {

using Eigen::Vector2d;

constexpr std::size_t kMaxCorners = 100;
constexpr double kMaxRadius = 10;  // [m]
constexpr double kOnEdge = 1e-9;   // [m]
constexpr double kMitreLimit = 2;  // times the margin
constexpr int kCircleCorners = 16;

bool holds_origin(const Polygon& polygon) {
  const Vector2d origin = Vector2d::Zero();
  return contains(polygon, origin) || distance_to_edges_m(polygon, origin) <= kOnEdge;
}

/// Where the moved edges before and behind a corner end and begin; the same point unless it is cut off.
struct MovedCorner {
  Vector2d end;
  Vector2d begin;
};

/// `before` and `behind` are the directions of the edges, unit vectors.
MovedCorner move_corner(const Vector2d& corner, const Vector2d& before, const Vector2d& behind,
                        double margin_m) {
  const Vector2d normal_before(before.y(), -before.x());
  const Vector2d normal_behind(behind.y(), -behind.x());
  const double cos_angle = before.dot(behind);
  const bool opens = (cross(before, behind) > 0) == (margin_m > 0);
  const double cos_half = std::sqrt(std::max(0.0, (1 + cos_angle) / 2));
  if (!opens || cos_half * kMitreLimit >= 1) {
    const Vector2d mitred = corner + margin_m / (1 + cos_angle) * (normal_before + normal_behind);
    return {mitred, mitred};
  }
  // Both edges go on until they are kMitreLimit margins from the corner, measured along the bisector.
  const double sin_half = std::sqrt(std::max(0.0, (1 - cos_angle) / 2));
  const double beyond_m = std::abs(margin_m) * (kMitreLimit - cos_half) / sin_half;
  return {corner + margin_m * normal_before + beyond_m * before,
          corner + margin_m * normal_behind - beyond_m * behind};
}

/// Empty when an edge vanishes or edges meet.
std::optional<Polygon> moved_edges(const Polygon& polygon, double margin_m) {
  const std::size_t n = polygon.size();
  std::vector<Vector2d> directions(n);  // of the edge behind each corner
  for (std::size_t i = 0; i < n; ++i) directions[i] = (polygon[(i + 1) % n] - polygon[i]).normalized();
  std::vector<MovedCorner> corners(n);
  for (std::size_t i = 0; i < n; ++i)
    corners[i] = move_corner(polygon[i], directions[(i + n - 1) % n], directions[i], margin_m);
  Polygon moved;
  moved.reserve(2 * n);
  for (std::size_t i = 0; i < n; ++i) {
    if (!((corners[(i + 1) % n].end - corners[i].begin).dot(directions[i]) > 0)) return std::nullopt;
    moved.push_back(corners[i].end);
    if (corners[i].begin != corners[i].end) moved.push_back(corners[i].begin);
  }
  if (!is_simple(moved) || signed_area_m2(moved) < kSmallestArea_m2) return std::nullopt;
  return moved;
}

std::optional<Polygon> shrunk(const Polygon& polygon, double margin_m) {
  auto moved = moved_edges(polygon, margin_m);
  if (moved && !holds_origin(*moved)) moved.reset();
  return moved;
}

}  // namespace

Footprint::Footprint(std::vector<Vector2d> corners_m)
    : corners_m_(std::move(corners_m)),
      parts_m_(convex_parts(corners_m_)),
      inscribed_radius_m_(distance_to_edges_m(corners_m_, Vector2d::Zero())) {
  for (const auto& corner : corners_m_)
    circumscribed_radius_m_ = std::max(circumscribed_radius_m_, corner.norm());
}

Result<Footprint> Footprint::make(std::vector<Vector2d> corners_m) {
  auto polygon = make_polygon(std::move(corners_m), kMaxCorners);
  if (!polygon) return fail(polygon.error().code, "footprint: " + polygon.error().message);
  if (!holds_origin(*polygon))
    return fail(ErrorCode::kInvalidArgument, "footprint: it must hold the base's origin (0, 0)");
  Footprint footprint(std::move(*polygon));
  if (footprint.circumscribed_radius_m() > kMaxRadius)
    return fail(ErrorCode::kInvalidArgument,
                "footprint: its corners must be within 10 m of the base's origin");
  return footprint;
}

Footprint Footprint::circle(double radius_m) {
  constexpr double kMinRadius = 0.01;
  demand(radius_m >= kMinRadius && radius_m <= 0.98 * kMaxRadius,
         "radius of a footprint must be 0.01 to 9.8 m");
  const double corner_m = radius_m / std::cos(kPi / kCircleCorners);
  Polygon corners;
  corners.reserve(kCircleCorners);
  for (int i = 0; i < kCircleCorners; ++i) {
    const double angle = kTwoPi * (i + 0.5) / kCircleCorners;
    corners.emplace_back(corner_m * std::cos(angle), corner_m * std::sin(angle));
  }
  return Footprint(std::move(corners));
}

Footprint Footprint::padded(double margin_m) const {
  if (margin_m == 0) return *this;
  if (margin_m > 0) {
    if (auto moved = moved_edges(corners_m_, margin_m)) return Footprint(std::move(*moved));
    const Polygon hull = convex_hull(corners_m_);
    return Footprint(moved_edges(hull, margin_m).value_or(hull));
  }
  if (auto moved = shrunk(corners_m_, margin_m)) return Footprint(std::move(*moved));
  constexpr int kHalvings = 40;
  Polygon best = corners_m_;
  double valid_m = 0;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle_m = (valid_m + margin_m) / 2;
    if (auto moved = shrunk(corners_m_, middle_m)) {
      best = std::move(*moved);
      valid_m = middle_m;
    } else {
      margin_m = middle_m;
    }
  }
  return Footprint(std::move(best));
}

Footprint Footprint::extended(const std::vector<Vector2d>& points_m) const {
  Polygon all = corners_m_;
  std::copy_if(points_m.begin(), points_m.end(), std::back_inserter(all),
               [](const Vector2d& point) { return point.allFinite(); });
  return Footprint(convex_hull(std::move(all)));
}

}  // namespace extperfc::navigate
