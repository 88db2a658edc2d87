#pragma once

#include <optional>

#include "extperfc/arm/jogger.hpp"

#include "arm/cartesian/arm_in_group.hpp"

namespace extperfc::arm {

/// Where an arm is and how fast; one value per joint of the arm.
struct JogState {
  JointVector positions;
  JointVector velocities;
};

/// What is wanted, after everything that slows it down but collisions.
struct JogWish {
  JointVector velocity;
  JogHindrance hindrance{JogHindrance::kNone};
  double scale{1};
  int joint{-1};
};

/// Velocities for commands: no state, no collisions.
class JogVelocity {
 public:
  JogVelocity(const ArmChain& chain, const JoggerParams& params);

  /// `command` fits the arm and is fresh.
  [[nodiscard]] JogWish wish(const JogCommand& command, const JointVector& positions) const;
  [[nodiscard]] const JointVector& max_velocity() const { return max_velocity_; }

 private:
  void follow_twist(const JogCommand& command, const JointVector& positions, JogWish& wish) const;
  void slow_for_limits(const JointVector& positions, JogWish& wish) const;

  ArmChain chain_;
  JoggerParams params_;
  JointVector max_velocity_;
};

/// One step of a motion and the stopping motion after it.
struct JogMove {
  JogState next;
  JointVector stand;  ///< where the arm could stand after it, reaction included
};

/// The moves that the acceleration allows.
class JogBrakes {
 public:
  JogBrakes(double acceleration, double reaction_s) : acceleration_(acceleration), reaction_s_(reaction_s) {}

  /// `fraction` 0: braking along the proven path; 1: the full change to `velocity` that one step allows.
  [[nodiscard]] JogMove move(const JogState& now, const JointVector& velocity, double fraction,
                             double dt_s) const;

 private:
  [[nodiscard]] double time_to_stand(const JointVector& velocity) const {
    return velocity.size() > 0 ? velocity.cwiseAbs().maxCoeff() / acceleration_ : 0.0;
  }

  double acceleration_, reaction_s_;
};

}  // namespace extperfc::arm
