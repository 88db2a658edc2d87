#pragma once

#include <atomic>
#include <optional>

#include "extperfc/base/stopwatch.hpp"
#include "extperfc/navigate/nav_error.hpp"

namespace extperfc::navigate {

/// Says when a plan must end: cancelled, or out of time. Searches ask it every few hundred microseconds.
class PlanClock {
 public:
  PlanClock(const std::atomic<bool>* cancel, double max_time_s) : cancel_(cancel), max_time_s_(max_time_s) {}

  /// kCancelled or kPlanTimeout; empty while the plan may go on.
  [[nodiscard]] std::optional<NavCode> ended() const {
    if (cancel_ != nullptr && cancel_->load(std::memory_order_relaxed)) return NavCode::kCancelled;
    if (watch_.seconds() > max_time_s_) return NavCode::kPlanTimeout;
    return std::nullopt;
  }

 private:
  const std::atomic<bool>* cancel_;
  double max_time_s_;
  Stopwatch watch_;
};

}  // namespace extperfc::navigate
