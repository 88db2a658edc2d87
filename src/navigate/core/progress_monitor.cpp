#include "extperfc/navigate/progress_monitor.hpp"

#include <algorithm>
#include <utility>

namespace extperfc::navigate {

namespace {

constexpr double kSmallestStepM = 0.02;

}  // namespace

void ProgressMonitor::reset() {
  *this = {};
}

void ProgressMonitor::path_changed(double rest_m, double now_s) {
  const bool longer = rest_m > mark_m_;
  if (longer && ++detours_ > kMaxDetours) return;
  if (longer) since_s_ = now_s;
  mark_m_ = rest_m;
  if (!record_m_) record_m_ = rest_m;
}

bool ProgressMonitor::update(double rest_m, double step_m, double now_s) {
  const bool nearer = rest_m <= mark_m_ - std::max(kSmallestStepM, std::min(step_m, 0.5 * mark_m_));
  if (nearer) {
    mark_m_ = rest_m;
    since_s_ = now_s;
  }
  if (record_m_ && rest_m <= *record_m_ - step_m) {
    record_m_ = rest_m;
    advanced_ = true;
    detours_ = 0;
  }
  return nearer;
}

bool ProgressMonitor::take_advance() {
  return std::exchange(advanced_, false);
}

}  // namespace extperfc::navigate
