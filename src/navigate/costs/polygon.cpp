#include "navigate/costs/polygon.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace extperfc::navigate {

namespace {

using Eigen::Vector2d;

/// Above 0: c is to the left of the line from a to b.
double side(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return cross(b - a, c - a);
}

/// Whether c, on the line through a and b, is between them.
bool is_between(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return (c - a).dot(c - b) <= 0;
}

/// Closed segments.
bool segments_meet(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  const double c_side = side(a, b, c);
  const double d_side = side(a, b, d);
  const double a_side = side(c, d, a);
  const double b_side = side(c, d, b);
  if (((c_side > 0 && d_side < 0) || (c_side < 0 && d_side > 0)) &&
      ((a_side > 0 && b_side < 0) || (a_side < 0 && b_side > 0)))
    return true;
  return (c_side == 0 && is_between(a, b, c)) || (d_side == 0 && is_between(a, b, d)) ||
         (a_side == 0 && is_between(c, d, a)) || (b_side == 0 && is_between(c, d, b));
}

/// Whether the edges before and behind a corner lie on each other.
bool folds_back(const Vector2d& before, const Vector2d& corner, const Vector2d& behind) {
  return side(before, corner, behind) == 0 && (corner - before).dot(behind - corner) < 0;
}

/// Ear clipping over the corners that are left.
class EarClipper {
 public:
  explicit EarClipper(const Polygon& polygon) : polygon_(polygon), left_(polygon.size()) {
    std::iota(left_.begin(), left_.end(), std::size_t{0});
  }

  [[nodiscard]] std::vector<Polygon> triangles() {
    std::vector<Polygon> result;
    result.reserve(polygon_.size());
    while (left_.size() >= 3) {
      const std::size_t i = next_ear();
      if (bend(i) > 0) result.push_back({before(i), at(i), behind(i)});
      left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(i));
    }
    return result;
  }

 private:
  [[nodiscard]] const Vector2d& at(std::size_t i) const { return polygon_[left_[i]]; }
  [[nodiscard]] const Vector2d& before(std::size_t i) const {
    return at((i + left_.size() - 1) % left_.size());
  }
  [[nodiscard]] const Vector2d& behind(std::size_t i) const { return at((i + 1) % left_.size()); }
  [[nodiscard]] double bend(std::size_t i) const { return side(before(i), at(i), behind(i)); }

  /// A corner on a straight edge, else an ear. Where rounding leaves neither, the sharpest corner.
  [[nodiscard]] std::size_t next_ear() const {
    std::size_t sharpest = 0;
    for (std::size_t i = 0; i < left_.size(); ++i) {
      if (bend(i) == 0 || is_ear(i)) return i;
      if (bend(i) > bend(sharpest)) sharpest = i;
    }
    return sharpest;
  }

  [[nodiscard]] bool is_ear(std::size_t i) const {
    if (bend(i) < 0) return false;
    for (std::size_t k = 0; k < left_.size(); ++k) {
      const std::size_t ahead = (k + left_.size() - i) % left_.size();
      const bool is_corner = ahead <= 1 || ahead == left_.size() - 1;
      if (!is_corner && bend(k) <= 0 && side(before(i), at(i), at(k)) >= 0 &&
          side(at(i), behind(i), at(k)) >= 0 && side(behind(i), before(i), at(k)) >= 0)
        return false;
    }
    return true;
  }

  const Polygon& polygon_;
  std::vector<std::size_t> left_;
};

}  // namespace

double signed_area_m2(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    twice += cross(polygon[i] - polygon[0], polygon[(i + 1) % polygon.size()] - polygon[0]);
  return twice / 2;
}

bool is_simple(const Polygon& polygon) {
  const std::size_t n = polygon.size();
  const auto corner = [&](std::size_t i) -> const Vector2d& { return polygon[i % n]; };
  for (std::size_t i = 0; i < n; ++i) {
    if (folds_back(corner(i), corner(i + 1), corner(i + 2))) return false;
    const std::size_t end = i == 0 ? n - 1 : n;  // the last edge is the first one's neighbour
    for (std::size_t k = i + 2; k < end; ++k)
      if (segments_meet(corner(i), corner(i + 1), corner(k), corner(k + 1))) return false;
  }
  return true;
}

bool is_convex(const Polygon& polygon) {
  const std::size_t n = polygon.size();
  for (std::size_t i = 0; i < n; ++i)
    if (side(polygon[i], polygon[(i + 1) % n], polygon[(i + 2) % n]) < 0) return false;
  return true;
}

bool contains(const Polygon& polygon, const Vector2d& point_m) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d& a = polygon[i];
    const Vector2d& b = polygon[(i + 1) % polygon.size()];
    if ((a.y() > point_m.y()) == (b.y() > point_m.y())) continue;
    if ((side(a, b, point_m) > 0) == (b.y() > a.y())) inside = !inside;
  }
  return inside;
}

double distance_to_edges_m(const Polygon& polygon, const Vector2d& point_m) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d& a = polygon[i];
    const Vector2d edge = polygon[(i + 1) % polygon.size()] - a;
    const double along = std::clamp((point_m - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (point_m - a - along * edge).norm());
  }
  return nearest;
}

Polygon convex_hull(Polygon points_m) {
  std::sort(points_m.begin(), points_m.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  points_m.erase(std::unique(points_m.begin(), points_m.end()), points_m.end());
  // Andrew's monotone chain: the lower side from left to right, the upper one back.
  Polygon hull;
  hull.reserve(points_m.size() + 1);
  const auto add = [&hull](const Vector2d& point, std::size_t fixed) {
    while (hull.size() > fixed && side(hull[hull.size() - 2], hull.back(), point) <= 0) hull.pop_back();
    hull.push_back(point);
  };
  for (const auto& point : points_m) add(point, 1);
  const std::size_t lower = hull.size();
  for (std::size_t i = points_m.size(); i-- > 1;) add(points_m[i - 1], lower);
  if (hull.size() > 1) hull.pop_back();
  return hull;
}

std::vector<Polygon> convex_parts(const Polygon& polygon) {
  if (is_convex(polygon)) return {polygon};
  return EarClipper(polygon).triangles();
}

Result<Polygon> make_polygon(Polygon corners_m, std::size_t max_corners) {
  const auto refuse = [](const std::string& why) { return fail(ErrorCode::kInvalidArgument, why); };
  if (!std::all_of(corners_m.begin(), corners_m.end(), [](const Vector2d& c) { return c.allFinite(); }))
    return refuse("its corners must be finite");
  corners_m.erase(std::unique(corners_m.begin(), corners_m.end()), corners_m.end());
  if (corners_m.size() > 1 && corners_m.front() == corners_m.back()) corners_m.pop_back();
  if (corners_m.size() < 3 || corners_m.size() > max_corners)
    return refuse("it must have 3 to " + std::to_string(max_corners) + " different corners, not " +
                  std::to_string(corners_m.size()));
  const double area_m2 = signed_area_m2(corners_m);
  if (!is_simple(corners_m)) return refuse("its edges must not cross or touch");
  if (!(std::abs(area_m2) >= kSmallestArea_m2)) return refuse("its area must be 1e-4 m^2 or more");
  if (area_m2 < 0) std::reverse(corners_m.begin(), corners_m.end());
  return corners_m;
}

}  // namespace extperfc::navigate
