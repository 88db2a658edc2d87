#include "arm/grasping/chord.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace extperfc::arm {
namespace {

using MaybeChord = std::optional<Chord>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

MaybeChord both(const MaybeChord& a, const MaybeChord& b) {
  if (!a || !b) return std::nullopt;
  const Chord common{std::max(a->from, b->from), std::min(a->to, b->to)};
  if (common.from > common.to) return std::nullopt;
  return common;
}

/// |point + t * direction| <= half, along one axis.
MaybeChord slab(double point, double direction, double half) {
  if (direction == 0)
    return std::abs(point) <= half ? MaybeChord(Chord{-kInfinity, kInfinity}) : std::nullopt;
  const double a = (-half - point) / direction, b = (half - point) / direction;
  return Chord{std::min(a, b), std::max(a, b)};
}

/// a t^2 + 2 b t + c <= 0 for a > 0.
MaybeChord between_roots(double a, double b, double c) {
  const double inside = b * b - a * c;
  if (inside < 0) return std::nullopt;
  const double root = std::sqrt(inside);
  return Chord{(-b - root) / a, (-b + root) / a};
}

MaybeChord round_wall(const ConvexPart& part, const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
  const double a = d.head<2>().squaredNorm(), c = p.head<2>().squaredNorm() - part.half.x() * part.half.x();
  if (a < 1e-20) return c <= 0 ? MaybeChord(Chord{-kInfinity, kInfinity}) : std::nullopt;
  return between_roots(a, p.head<2>().dot(d.head<2>()), c);
}

/// x^2 + y^2 <= (k w)^2 with w = top - z >= 0.
MaybeChord cone_wall(const ConvexPart& part, const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
  const double top = part.half.z(), k = part.half.x() / (2 * top), w = top - p.z();
  double a = d.head<2>().squaredNorm() - k * k * d.z() * d.z();
  const double b = p.head<2>().dot(d.head<2>()) + k * k * w * d.z();
  const double c = p.head<2>().squaredNorm() - k * k * w * w;
  if (a > 1e-12) return between_roots(a, b, c);
  // Steeper than the wall: the line enters the lower cone once and leaves through the base.
  a = std::min(a, -1e-12);
  const double inside = b * b - a * c;
  const double root = std::sqrt(std::max(inside, 0.0));
  const double low = (-b + root) / a, high = (-b - root) / a;
  return d.z() > 0 ? MaybeChord(Chord{-kInfinity, low}) : MaybeChord(Chord{high, kInfinity});
}

}  // namespace

MaybeChord chord(const ConvexPart& part, const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
  const auto along_z = slab(p.z(), d.z(), part.half.z());
  switch (part.kind) {
    case PartKind::kBox:
      return both(along_z, both(slab(p.x(), d.x(), part.half.x()), slab(p.y(), d.y(), part.half.y())));
    case PartKind::kCylinder:
      return both(along_z, round_wall(part, p, d));
    case PartKind::kSphere:
      return between_roots(1, p.dot(d), p.squaredNorm() - part.half.x() * part.half.x());
    case PartKind::kCone:
      return both(along_z, cone_wall(part, p, d));
    case PartKind::kHull:
      break;
  }
  return std::nullopt;
}

Eigen::Vector3d outward_normal(const ConvexPart& part, const Eigen::Vector3d& p) {
  const double across = p.head<2>().norm();
  const Eigen::Vector3d out =
      across > 0 ? Eigen::Vector3d(p.x() / across, p.y() / across, 0) : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d level(0, 0, p.z() < 0 ? -1 : 1);
  switch (part.kind) {
    case PartKind::kSphere:
      return p.norm() > 0 ? Eigen::Vector3d(p.normalized()) : Eigen::Vector3d::UnitZ();
    case PartKind::kCylinder:
      return part.half.x() - across <= part.half.z() - std::abs(p.z()) ? out : level;
    case PartKind::kCone: {
      const double slope = std::hypot(2 * part.half.z(), part.half.x());
      const double wall =
          (2 * part.half.z() * across + part.half.x() * (p.z() - part.half.z())) / slope;  // not positive
      if (-wall > p.z() + part.half.z()) return -Eigen::Vector3d::UnitZ();
      return (2 * part.half.z() * out + part.half.x() * Eigen::Vector3d::UnitZ()) / slope;
    }
    case PartKind::kBox:
    case PartKind::kHull:
      break;
  }
  Eigen::Index axis = 0;
  (p.cwiseAbs() - part.half).maxCoeff(&axis);
  return (p[axis] < 0 ? -1 : 1) * Eigen::Vector3d::Unit(axis);
}

}  // namespace extperfc::arm
