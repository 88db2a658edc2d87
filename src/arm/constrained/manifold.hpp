#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/path_constraint.hpp"
#include "extperfc/base/rng.hpp"

namespace extperfc::arm {

using States = std::vector<JointVector>;

/// How finely and how far a manifold is walked on.
struct Steps {
  double step_rad{0.3};    ///< of a step in the tangent space
  double tolerance{5e-5};  ///< of the constraint's error on straight pieces [m] or [rad]
};

/// The states that keep a constraint and the joint limits, with the obstacles among them.
class Manifold {
 public:
  /// The checker must outlive it. Limits are finite.
  Manifold(CollisionChecker& checker, PathConstraint constraint, JointLimits limits, const Steps& steps);

  [[nodiscard]] const PathConstraint& constraint() const { return constraint_; }
  [[nodiscard]] const JointLimits& limits() const { return limits_; }

  /// A random state: uniform within the limits, then projected; nothing when that does not converge.
  [[nodiscard]] std::optional<JointVector> sample(Rng& rng) const;

  struct Walk {
    States states;        ///< behind the first one, a step apart; may be empty
    bool reached{false};  ///< the last one is the target
  };
  /// Towards `to`, until it is reached, `max_rad` were walked, the distance no longer falls or `stop` says
  /// so. Does not look at obstacles.
  [[nodiscard]] Walk walk(const JointVector& from, const JointVector& to, double max_rad,
                          const std::function<bool()>& stop) const;

  /// Projected states between the ends such that every straight piece keeps the tolerance; `to` is the last
  /// one. False when halving does not lead there.
  [[nodiscard]] bool refine(const JointVector& from, const JointVector& to, States* pieces) const;

  /// Pieces along the coarse states, refined and proven free; ends at the first one that is not. Returns how
  /// many coarse states were reached.
  [[nodiscard]] std::size_t prove(const JointVector& from, const States& coarse, States* pieces,
                                  const std::function<bool()>& stop);

  /// Proven pieces from `from` to `to` behind `from`; nothing when that fails or is longer than `max_rad`.
  [[nodiscard]] std::optional<States> connect(const JointVector& from, const JointVector& to, double max_rad,
                                              const std::function<bool()>& stop);

  /// Largest bound of the constraint's error on the polyline.
  [[nodiscard]] double error_bound(const States& path) const;
  /// Whether every piece keeps the tolerance and is proven free.
  [[nodiscard]] bool holds(const JointVector& from, const JointVector& to);

 private:
  [[nodiscard]] bool fine(const JointVector& from, const JointVector& to, bool exact) const;
  bool halve(const JointVector& from, const JointVector& to, bool from_exact, bool to_exact, int depth,
             States* pieces) const;

  CollisionChecker& checker_;
  PathConstraint constraint_;
  JointLimits limits_;
  Steps steps_;
};

}  // namespace extperfc::arm
