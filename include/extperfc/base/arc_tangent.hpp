#pragma once

#include <cmath>
#include <limits>

#include "extperfc/base/math.hpp"

namespace extperfc {

/// Angle of (x, y) from the x axis in [-pi, pi], within 6e-7 rad of std::atan2(y, x): a tenth of a millimetre
/// at 100 m. Without branches and calls, so that a loop over arrays takes several points at a time. (0, 0)
/// gives 0; NaN gives NaN. The series is that of Abramowitz and Stegun, Handbook of Mathematical
/// Functions, 4.4.49, |error| <= 2e-8.
inline float arc_tangent(float y, float x) {
  const float wide = std::abs(x);
  const float high = std::abs(y);
  const float larger = wide > high ? wide : high;
  const float smaller = wide > high ? high : wide;
  const float t = smaller / (larger + std::numeric_limits<float>::min());
  const float s = t * t;
  float series = 0.0028662257F;
  for (const float factor : {-0.0161657367F, 0.0429096138F, -0.0752896400F, 0.1065626393F, -0.1420889944F,
                             0.1999355085F, -0.3333314528F, 1.0F})
    series = series * s + factor;
  const float within_eighth = series * t;
  const float within_quarter = high > wide ? 0.5F * kPiF - within_eighth : within_eighth;
  const float above = x < 0 ? kPiF - within_quarter : within_quarter;
  return std::copysign(above, y);
}

}  // namespace extperfc
