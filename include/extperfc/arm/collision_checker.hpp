#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/arm/collision_model.hpp"
#include "extperfc/arm/collision_world.hpp"
#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/base/error.hpp"

namespace extperfc::arm {

class Checks;

struct CollisionCheckerParams {
  /// motion_free() gives up on a piece of a motion that is shorter than this (Euclidean length of the joint
  /// displacement) and still not proven free; 1e-5 to 0.1 rad.
  double min_step_rad{1e-3};
  /// Ask the spheres first. Without them every pair goes to GJK; results are the same, only slower.
  bool spheres{true};
};

/// Two names (links or objects) and their distance [m]; negative: depth of the penetration.
struct Contact {
  std::string first;
  std::string second;
  double distance_m{0};
};

struct CollisionCounters {
  std::uint64_t states{0};          ///< states asked for
  std::uint64_t motions{0};         ///< motions asked for
  std::uint64_t sphere_batches{0};  ///< calls of the sphere kernel
  std::uint64_t exact_pairs{0};     ///< pairs of shapes that GJK saw
};

/// Collision checks of one robot in one world.
///
/// Two layers. Spheres that enclose every moving shape are tested in batches, in single precision with the
/// rounding added to their radii: what they call free is free. The pairs of shapes that they do not clear are
/// decided by GJK in double precision; a pair counts as free only when the axis that GJK returns proves a gap
/// of more than 1e-6 m by the support functions of both shapes. GJK goes on until it has such an axis within
/// 1e-7 m of the distance, so what is free is found free, and no state of a motion that was proven is found
/// in contact.
///
/// Joint limits are not checked. Not thread-safe, each thread makes its own or a clone(); the same calls give
/// the same results. All JointVectors have model.joint_count() values, else std::invalid_argument is thrown;
/// so it is when contact() or nearest() gets a value that is not finite.
class CollisionChecker {
 public:
  /// Errors: an object attached to a link that the robot lacks, an object named like a link, a parameter out
  /// of its range. O(shapes^2); some 0.1 ms for two arms and 15 objects.
  [[nodiscard]] static Result<CollisionChecker> make(const CollisionModel& model, const CollisionWorld& world,
                                                     const CollisionCheckerParams& params = {});
  CollisionChecker(CollisionChecker&&) noexcept;
  CollisionChecker& operator=(CollisionChecker&&) noexcept;
  ~CollisionChecker();
  /// For another thread.
  [[nodiscard]] CollisionChecker clone() const;

  /// True when nothing touches that must not. A value that is not finite is never free.
  [[nodiscard]] bool is_free(const JointVector& positions);
  /// The same for many states, in batches.
  [[nodiscard]] std::vector<bool> are_free(const std::vector<JointVector>& states);
  /// Spheres alone: true means free, false means unknown.
  [[nodiscard]] std::vector<bool> spheres_free(const std::vector<JointVector>& states);
  /// GJK alone: the first pair that touches or is nearer than its padding; std::nullopt when there is none.
  [[nodiscard]] std::optional<Contact> contact(const JointVector& positions);
  /// GJK alone: the nearest pair with its distance, to 1e-7 m, or penetration by Bullet's EPA (padding is
  /// subtracted); std::nullopt when no pair is checked.
  [[nodiscard]] std::optional<Contact> nearest(const JointVector& positions);

  /// True only when every state of the straight segment from `from` to `to` in joint space, ends included, is
  /// proven free. False: a collision, or a clearance too small to prove within min_step_rad.
  ///
  /// Proof for an interval of half length h (in path parameter) about its middle m, joint rates q' constant:
  /// a point x of a body moves as x(t) = x(m) + x'(m) t + e, |e| <= A t^2 / 2, with A the sum over pairs of
  /// moving joints of |q'_j| |q'_k| times the largest distance of the body from the later joint's axis. For a
  /// separating plane with normal n at m, the gap at t is at least its value under the motion linear in t,
  /// which is smallest at t = -h or h, minus A h^2 / 2 of both bodies.
  ///
  /// With `deviation_rad` the proof covers every state within that distance (Euclidean, of the joint values;
  /// 0 or more) of the segment, so that a curve near it is proven too: each point of a body gets a margin of
  /// deviation_rad times the root of the sum of its squared largest distances from the joints' axes.
  [[nodiscard]] bool motion_free(const JointVector& from, const JointVector& to, double deviation_rad = 0);
  /// Largest proven fraction in [0, 1] of the segment, counted from `from`; 1 when motion_free(). -1 when
  /// `from` itself is not proven free.
  [[nodiscard]] double free_fraction(const JointVector& from, const JointVector& to);

  [[nodiscard]] const CollisionModel& model() const;
  [[nodiscard]] const CollisionWorld& world() const;
  [[nodiscard]] const CollisionCounters& counters() const;

 private:
  explicit CollisionChecker(std::unique_ptr<Checks> checks);
  std::unique_ptr<Checks> checks_;
};

}  // namespace extperfc::arm
