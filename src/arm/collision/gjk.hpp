#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace extperfc::arm {

/// What is known of the distance between two convex sets A and B.
struct Proximity {
  /// Unit vector with the best lower bound: every point of A lies at least `at_least_m` further along it than
  /// every point of B. What is not positive proves nothing.
  Eigen::Vector3d axis{Eigen::Vector3d::UnitZ()};
  double at_least_m{-std::numeric_limits<double>::infinity()};
  double at_most_m{std::numeric_limits<double>::infinity()};  ///< distance of two points, one of each
};

/// The point of a simplex that is nearest to the origin, kept as a convex combination of one to four corners
/// (Wolfe, "Finding the nearest point in a polytope", 1976).
class NearestSimplex {
 public:
  explicit NearestSimplex(const Eigen::Vector3d& corner) : nearest_(corner) {
    corners_[0] = corner;
    weights_[0] = 1;
  }

  [[nodiscard]] const Eigen::Vector3d& nearest() const { return nearest_; }
  /// Whether a corner stands where `point` is.
  [[nodiscard]] bool has(const Eigen::Vector3d& point) const {
    return std::any_of(corners_.begin(), corners_.begin() + count_,
                       [&](const Eigen::Vector3d& corner) { return corner == point; });
  }
  /// Takes a corner in and moves to the nearest point of the hull. False, when rounding allows no progress or
  /// the hull holds the origin (nearest() is zero then).
  bool add(const Eigen::Vector3d& corner) {
    const double before = nearest_.squaredNorm();
    corners_[count_] = corner;
    weights_[count_++] = 0;
    while (!move_to_affine_minimum()) {
    }
    nearest_.setZero();
    for (int i = 0; i < count_; ++i) nearest_ += weights_[i] * corners_[i];
    if (count_ == 4) nearest_.setZero();
    return count_ < 4 && nearest_.squaredNorm() < before;
  }

 private:
  /// Weights, with sum 1, of the point of the corners' affine hull that is nearest to the origin; false when
  /// the corners are degenerate.
  bool affine_weights(std::array<double, 4>& weights) const {
    constexpr double kDegenerate = 1e-13;
    const Eigen::Vector3d& p = corners_[0];
    const auto edge = [&](int i) { return Eigen::Vector3d(corners_[i] - p); };
    if (count_ == 2) {
      const Eigen::Vector3d a = edge(1);
      weights[1] = -p.dot(a) / a.squaredNorm();
    } else if (count_ == 3) {
      const Eigen::Vector3d a = edge(1), b = edge(2);
      const double aa = a.squaredNorm(), bb = b.squaredNorm(), ab = a.dot(b);
      const double determinant = a.cross(b).squaredNorm();
      if (determinant <= kDegenerate * aa * bb) return false;
      weights[1] = (ab * p.dot(b) - bb * p.dot(a)) / determinant;
      weights[2] = (ab * p.dot(a) - aa * p.dot(b)) / determinant;
    } else {
      const Eigen::Vector3d a = edge(1), b = edge(2), c = edge(3);
      const double determinant = a.dot(b.cross(c));
      if (std::abs(determinant) <= kDegenerate * a.norm() * b.norm() * c.norm()) return false;
      weights[1] = -p.dot(b.cross(c)) / determinant;
      weights[2] = -p.dot(c.cross(a)) / determinant;
      weights[3] = -p.dot(a.cross(b)) / determinant;
    }
    weights[0] = 1;
    for (int i = 1; i < count_; ++i) weights[0] -= weights[i];
    return true;
  }

  /// Moves towards that point; true when it lies within the corners. Else the first corner whose weight
  /// becomes zero on the path there is given up.
  bool move_to_affine_minimum() {
    if (count_ == 1) {
      weights_[0] = 1;
      return true;
    }
    std::array<double, 4> wanted{};
    if (!affine_weights(wanted)) {
      remove(static_cast<int>(std::min_element(weights_.begin(), weights_.begin() + count_ - 1) -
                              weights_.begin()));
      return false;
    }
    int first = -1;
    double step = 1;
    for (int i = 0; i < count_; ++i) {
      if (wanted[i] > 0) continue;
      const double reach = weights_[i] <= 0 ? 0 : weights_[i] / (weights_[i] - wanted[i]);
      if (first < 0 || reach < step) {
        first = i;
        step = reach;
      }
    }
    for (int i = 0; i < count_; ++i) weights_[i] += step * (wanted[i] - weights_[i]);
    if (first < 0) return true;
    remove(first);
    return false;
  }

  void remove(int index) {
    --count_;
    for (int i = index; i < count_; ++i) {
      corners_[i] = corners_[i + 1];
      weights_[i] = weights_[i + 1];
    }
    double sum = 0;
    for (int i = 0; i < count_; ++i) sum += weights_[i] = std::max(weights_[i], 0.0);
    for (int i = 0; i < count_; ++i) weights_[i] = sum > 0 ? weights_[i] / sum : 1.0 / count_;
  }

  std::array<Eigen::Vector3d, 4> corners_;
  std::array<double, 4> weights_{};
  int count_{1};
  Eigen::Vector3d nearest_;
};

/// Distance of two convex sets by the algorithm of Gilbert, Johnson and Keerthi (1988). Other than usual it
/// is judged by its certificate: it goes on until the support functions along its axis prove a gap that is
/// within kGjkTolerance_m and `relative_tolerance` of the distance, or until the sets are known to touch. So
/// axes that look right but separate nothing, as they come out for cylinders and cones, cannot end it.
///
/// `lowest(d)` returns a point x of A - B with the smallest d . x; d is not normalised. `guess` is a
/// direction to begin with, from B to A; not zero. At most kMaxGjkSteps steps, some 3 for boxes and hulls, 15
/// for round shapes.
constexpr double kGjkTolerance_m = 1e-7;
constexpr int kMaxGjkSteps = 256;

template <typename Lowest>
Proximity gjk(const Lowest& lowest, const Eigen::Vector3d& guess, double relative_tolerance) {
  constexpr double kTouching_m = 1e-12;
  Proximity result;
  const auto look_along = [&](const Eigen::Vector3d& direction) {
    const double length = direction.norm();
    Eigen::Vector3d point = lowest(direction);
    if (const double gap = direction.dot(point) / length; gap > result.at_least_m) {
      result.at_least_m = gap;
      result.axis = direction / length;
    }
    return point;
  };
  NearestSimplex simplex(look_along(guess));
  for (int step = 0; step < kMaxGjkSteps; ++step) {
    result.at_most_m = simplex.nearest().norm();
    const double open_m = result.at_most_m - result.at_least_m;
    if (result.at_most_m <= kTouching_m || open_m <= kGjkTolerance_m + relative_tolerance * result.at_most_m)
      break;
    const Eigen::Vector3d point = look_along(simplex.nearest());
    if (simplex.has(point) || !simplex.add(point)) break;
  }
  result.at_most_m = std::min(result.at_most_m, simplex.nearest().norm());
  return result;
}

}  // namespace extperfc::arm
