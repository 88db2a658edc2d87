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

double Recovery::share() const {
  constexpr double kNoise = 0.1;
  if (alpha_slow_ <= 0 || alpha_fast_ <= 0) return 0;
  const double share = 1 - fast_ / slow_;
  return share < kNoise ? 0 : std::min(share, 1.0);
}

}  // namespace extperfc::localize
