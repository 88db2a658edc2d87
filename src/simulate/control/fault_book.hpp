#pragma once

#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/robot_io.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::simulate {

/// Faults that are active, each until its time is over. At most one per kind and target.
class FaultBook {
 public:
  explicit FaultBook(const RobotModel& robot) : robot_(&robot) {}

  [[nodiscard]] Result<void> set(const Fault& fault, double now_s);
  /// Drops what is over.
  void expire(double now_s);
  [[nodiscard]] const std::vector<Fault>& active() const { return active_; }
  [[nodiscard]] bool joint_is_stuck(const std::string& joint) const;
  /// Fraction of the motion that wheel 0..3 loses.
  [[nodiscard]] double wheel_slip(int wheel) const;

 private:
  [[nodiscard]] Result<void> check(const Fault& fault) const;
  [[nodiscard]] Result<void> check_target(const Fault& fault) const;
  void erase(FaultKind kind, const std::string* target);

  const RobotModel* robot_;
  std::vector<Fault> active_;
  std::vector<double> until_s_;  // of each active one; infinity: until it is ended
};

}  // namespace extperfc::simulate
