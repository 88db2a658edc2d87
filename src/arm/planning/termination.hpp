#pragma once

#include "extperfc/arm/motion_planner.hpp"
#include "extperfc/base/stopwatch.hpp"

namespace extperfc::arm {

/// What ends a call: its caller, or its time. Asked by the calling thread alone.
class Termination {
 public:
  Termination(const PlanRequest& request, double timeout_s) : request_(request), timeout_s_(timeout_s) {}

  /// Asks the caller.
  [[nodiscard]] bool cancelled() {
    return cancelled_ = cancelled_ || (request_.cancelled && request_.cancelled());
  }
  [[nodiscard]] bool over() { return cancelled() || watch_.seconds() > timeout_s_; }
  [[nodiscard]] double seconds() const { return watch_.seconds(); }

  /// Why there is no path, after over(): kCancelled, else kTimeout.
  [[nodiscard]] PlanCode code() const { return cancelled_ ? PlanCode::kCancelled : PlanCode::kTimeout; }
  [[nodiscard]] std::string message(int max_states) const {
    return cancelled_ ? "cancelled"
                      : "no path within " + std::to_string(timeout_s_) + " s and " +
                            std::to_string(max_states) + " states";
  }

 private:
  const PlanRequest& request_;
  double timeout_s_;
  bool cancelled_{false};
  Stopwatch watch_;
};

}  // namespace extperfc::arm
