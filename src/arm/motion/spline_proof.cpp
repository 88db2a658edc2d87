#include "arm/motion/spline_proof.hpp"

#include <algorithm>
#include <array>

namespace extperfc::arm {

namespace {

constexpr double kMaxDeviation = 1e-3;  ///< parts that leave their chord by more are halved at once [rad]
constexpr double kOnChord = 1e-9;       ///< what leaves the chord by less gains nothing from halving [rad]
constexpr int kPlaces = 6;              ///< halvings of a part that is not free, to find where it begins
constexpr int kMaxDepth = 16;           ///< halvings of a part that bends near something

/// A cubic Bezier curve in joint space.
using Curve = std::array<JointVector, 4>;

Curve curve_between(const TrajectoryPoint& a, const TrajectoryPoint& b) {
  const double third_s = (b.time_s - a.time_s) / 3;
  return {a.position, a.position + third_s * a.velocity, b.position - third_s * b.velocity, b.position};
}

/// Both parts of a curve that is cut at `parameter` (de Casteljau).
std::array<Curve, 2> cut(const Curve& curve, double parameter) {
  const auto between = [parameter](const JointVector& p, const JointVector& q) {
    return JointVector(p + parameter * (q - p));
  };
  const JointVector first = between(curve[0], curve[1]), middle = between(curve[1], curve[2]),
                    last = between(curve[2], curve[3]);
  const JointVector before = between(first, middle), behind = between(middle, last);
  const JointVector at = between(before, behind);
  return {Curve{curve[0], first, before, at}, Curve{at, behind, last, curve[3]}};
}

double distance_to_chord(const Curve& curve, const JointVector& point) {
  const JointVector chord = curve[3] - curve[0];
  const double square = chord.squaredNorm();
  const double along = square > 0 ? std::clamp((point - curve[0]).dot(chord) / square, 0.0, 1.0) : 0.0;
  return (curve[0] + along * chord - point).norm();
}

/// The distance from a convex set is a convex function; the inner points have weights that sum to 3 t (1 -
/// t).
double deviation(const Curve& curve) {
  return 0.75 * std::max(distance_to_chord(curve, curve[1]), distance_to_chord(curve, curve[2]));
}

double proven_part(CollisionChecker& checker, const Curve& curve, int depth) {
  const double off = deviation(curve);
  if (off <= kMaxDeviation && checker.motion_free(curve[0], curve[3], off)) return 1;
  if (depth >= kMaxDepth || (depth >= kPlaces && off <= kOnChord)) return 0;
  const auto [first, second] = cut(curve, 0.5);
  const double before = proven_part(checker, first, depth + 1);
  return before < 1 ? before / 2 : (1 + proven_part(checker, second, depth + 1)) / 2;
}

}  // namespace

double proven_fraction(CollisionChecker& checker, const TrajectoryPoint& a, const TrajectoryPoint& b,
                       double begin) {
  if (begin >= 1) return 1;
  const Curve curve = begin > 0 ? cut(curve_between(a, b), begin)[1] : curve_between(a, b);
  return begin + (1 - begin) * proven_part(checker, curve, 0);
}

}  // namespace extperfc::arm
