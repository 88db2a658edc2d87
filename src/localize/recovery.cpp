#include "localize/recovery.hpp"

#include <algorithm>

namespace extperfc::localize {

void Recovery::reset() {
  slow_ = kPrior;
  fast_ = kPrior;
  updates_ = kPriorUpdates;
}

void Recovery::add(double likelihood) {
  updates_ += 1;
  slow_ += std::max(alpha_slow_, 1 / updates_) * (likelihood - slow_);
  fast_ += std::max(alpha_fast_, 1 / updates_) * (likelihood - fast_);
}

double Recovery::fraction() const {
  constexpr double kNoise = 0.1;
  if (alpha_slow_ <= 0 || alpha_fast_ <= 0) return 0;
  const double fraction = 1 - fast_ / slow_;
  return fraction < kNoise ? 0 : std::min(fraction, 1.0);
}

}  // namespace extperfc::localize
