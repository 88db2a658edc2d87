#pragma once

#include <optional>

#include "depth/samples.hpp"

namespace extperfc::depth {

/// Depths between which one surface lies [m].
struct Layer {
  float near_m;
  float far_m;
};

/// The nearest depth range that holds a considerable fraction of the samples: the object, when what lies
/// behind it or beside it is deeper. Precondition: samples.size >= 1. O(samples).
[[nodiscard]] Layer nearest_layer(const Samples& samples, const StereoNoiseModel& noise);

}  // namespace extperfc::depth
