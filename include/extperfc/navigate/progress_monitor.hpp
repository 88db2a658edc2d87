#pragma once

#include <optional>

namespace extperfc::navigate {

/// Whether the robot comes nearer to its goal. Distances are along the path, to the goal.
class ProgressMonitor {
 public:
  /// A new goal.
  void reset();
  /// Time begins anew, after a recovery.
  void restart(double now_s) { since_s_ = now_s; }
  /// Time that does not count: the robot had to stand.
  void leave_out(double seconds) { since_s_ += seconds; }
  /// Another path: its length is the new measure. Paths that grow again and again are no progress: after
  /// kMaxDetours of them the time goes on.
  void path_changed(double rest_m, double now_s);
  /// `rest_m`: of the path. True when it fell by step_m, or by half near the goal: the robot came nearer.
  bool update(double rest_m, double step_m, double now_s);

  /// How long the robot has not come nearer [s].
  [[nodiscard]] double stuck_s(double now_s) const { return now_s - since_s_; }
  /// True once after the robot came nearer than it ever was, by a step.
  [[nodiscard]] bool take_advance();

 private:
  static constexpr int kMaxDetours = 20;

  double since_s_{0};
  double mark_m_{0};  ///< the least of this path that counted
  std::optional<double> record_m_;
  bool advanced_{false};
  int detours_{0};
};

}  // namespace extperfc::navigate
