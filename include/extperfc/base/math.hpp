#pragma once

namespace extperfc {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kTwoPi = 2 * kPi;     ///< one revolution [rad]
inline constexpr double kDegree = kPi / 180;  ///< [rad]
inline constexpr auto kPiF = static_cast<float>(kPi);
inline constexpr auto kTwoPiF = static_cast<float>(kTwoPi);

[[nodiscard]] constexpr double square(double value) {
  return value * value;
}

}  // namespace extperfc
