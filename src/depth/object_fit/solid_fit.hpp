#pragma once

#include <vector>

#include <Eigen/Core>

#include "depth/object_fit/solids.hpp"

namespace extperfc::depth {

/// A point in the support's frame.
struct SurfaceSample {
  Eigen::Vector3d position;  ///< [m]
  double sigma_m{0};         ///< standard deviation [m], > 0
};

using NumbersCovariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxNumbers, kMaxNumbers>;

struct SolidFit {
  Numbers numbers;
  NumbersCovariance covariance;
  double rms{0};      ///< spread of what lies on the solid, in standard deviations
  double rms_m{0};    ///< the same [m]
  double fitting{0};  ///< fraction of the samples within 3 standard deviations
};

/// The solid of this shape that lies nearest to the samples; the best of several starts. `independent`: how
/// many measurements a sample counts for.
[[nodiscard]] SolidFit fit_solid(FitShape shape, const std::vector<SurfaceSample>& samples,
                                 double independent);

}  // namespace extperfc::depth
