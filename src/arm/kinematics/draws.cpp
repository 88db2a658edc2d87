#include "arm/kinematics/draws.hpp"

#include <array>

namespace extperfc::arm {
namespace {

/// By fixed-point iteration of g = (1 + g)^(1 / (n + 1)), which more than halves the error each time.
double step_of(int n) {
  constexpr int kRounds = 60;
  double g = 1;
  for (int i = 0; i < kRounds; ++i) g = std::pow(1 + g, 1.0 / (n + 1));
  return 1 / g;
}

}  // namespace

double spread_step(int n) {
  static const auto steps = [] {
    std::array<double, kMaxJoints> all{};
    for (int i = 0; i < kMaxJoints; ++i) all[static_cast<std::size_t>(i)] = step_of(i + 1);
    return all;
  }();
  return steps.at(static_cast<std::size_t>(n - 1));
}

}  // namespace extperfc::arm
