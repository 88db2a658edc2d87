#pragma once

namespace extperfc::depth {

/// Weight of a residual, near 0 for outliers; `scale` in the residual's unit.
[[nodiscard]] inline double cauchy(double residual, double scale) {
  const double r = residual / scale;
  return 1.0 / (1.0 + r * r);
}

}  // namespace extperfc::depth
