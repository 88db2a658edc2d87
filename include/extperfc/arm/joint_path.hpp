#pragma once

#include <cstddef>
#include <vector>

#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/base/error.hpp"

namespace extperfc::arm {

struct JointPathParams {
  /// How far a rounded corner may leave the straight lines between waypoints, Euclidean norm over all joints
  /// [rad], [0, 1]. 0: the motion stops at every corner and stays on the lines.
  double deviation_rad{0.05};
  /// The same for each waypoint by its index in the list given to make(), e.g. after a rounded corner was
  /// found to collide; empty, or one per waypoint, each >= 0. Those of the first and the last do not count.
  std::vector<double> corner_deviation_rad{};
};

/// The path and its derivatives by the path parameter s, one value per joint.
struct PathState {
  JointVector position;   ///< q [rad]
  JointVector tangent;    ///< dq/ds
  JointVector curvature;  ///< d2q/ds2 [1/rad]
};

/// A part of a path with one polynomial: a straight line, or a rounded corner. With x = (s - begin) / length
/// in [0, 1], q' = direction + direction_change (3 x^2 - 2 x^3), so that q'' = 0 at both ends of every piece.
struct PathPiece {
  double begin{0};               ///< s at the start [rad]
  double length{0};              ///< of its range of s [rad], > 0
  JointVector position;          ///< q at the start
  JointVector direction;         ///< q' at the start, a unit vector
  JointVector direction_change;  ///< change of q' along the piece; zero on a straight
  bool straight{true};
  bool stop_after{false};  ///< q' jumps at its end: the motion has to stand there
};

/// State at `offset` in [0, length] behind the piece's start.
[[nodiscard]] PathState evaluate(const PathPiece& piece, double offset);

/// Waypoints joined by straight lines in joint space, corners rounded by polynomials of degree four.
///
/// The parameter s runs like the length of the line through the waypoints. Around a waypoint c, from L before
/// it to L behind it, the direction changes from u to w by the smooth step of PathPiece. That gives
///   q(s) = c + s u + 2 L (w - u) S(x) before the corner (s in [-L, 0]), S(x) = x^3 - x^4 / 2,
/// and the mirror image behind it. As c + s u is the line's point of the same s, the distance from the line
/// is at most 2 L |w - u| S(1/2) = 3/16 L |w - u|, in any norm; L follows from the permitted deviation and
/// from the room on the adjoining lines. A rounded corner lies in the triangle c - L u, c, c + L w: joint
/// limits that the waypoints keep are kept. The path is twice continuously differentiable but where it stops.
///
/// Waypoints nearer than 1e-9 rad to the one before are dropped (the last one stays). A corner that reverses
/// the direction (|w - u| > 1.98, 164 degrees) is stopped at: rounding it would leave the waypoint out and
/// gain nothing. A corner of |w - u| < 1e-9 counts as straight, for any permitted deviation.
class JointPath {
 public:
  /// Errors (kInvalidArgument): no waypoint, no joint, sizes that differ, values that are not finite,
  /// deviations out of range. One waypoint, or several equal ones, make a path of length 0. O(waypoints).
  [[nodiscard]] static Result<JointPath> make(const std::vector<JointVector>& waypoints,
                                              const JointPathParams& params = {});

  [[nodiscard]] Eigen::Index joints() const { return end_.size(); }
  [[nodiscard]] double length() const { return length_; }  ///< largest s [rad]
  /// Largest distance from the lines that a corner really has, Euclidean norm [rad].
  [[nodiscard]] double deviation_rad() const { return deviation_rad_; }
  [[nodiscard]] const std::vector<PathPiece>& pieces() const { return pieces_; }
  [[nodiscard]] const JointVector& start() const { return start_; }
  [[nodiscard]] const JointVector& end() const { return end_; }
  /// At s, held within [0, length()]. O(log pieces).
  [[nodiscard]] PathState at(double s) const;

 private:
  JointPath() = default;

  std::vector<PathPiece> pieces_;
  JointVector start_;
  JointVector end_;
  double length_{0};
  double deviation_rad_{0};
};

}  // namespace extperfc::arm
