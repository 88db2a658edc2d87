#pragma once

#include "depth/nearest_layer.hpp"

namespace extperfc::depth {

/// Depth of a surface at the centre of a box, and what it rests on.
struct SurfaceFit {
  double depth_m{0};
  double variance_m2{0};  ///< of one sample around the surface
  double effective{0};    ///< samples that count, as a weighted number
  double slope_x{0};      ///< change of depth towards the right [m/px]
  double slope_y{0};      ///< change of depth downwards [m/px]
};

/// Fits a plane to the samples inside `layer` and evaluates it at the centre of the box. O(samples).
///
/// A plane in space is affine in inverse depth: 1/z = c + a u + b v, and there stereo noise is the same
/// everywhere, so least squares is exact for slanted faces. Samples far from the centre count less (objects
/// are round), and samples off the plane count less (Cauchy weights, iterated). The result stays inside the
/// layer.
[[nodiscard]] SurfaceFit fit_surface(const Samples& samples, const Layer& layer,
                                     const BoxDepthParams& params);

}  // namespace extperfc::depth
