#pragma once

#include <string>
#include <vector>

#include "extperfc/base/rng.hpp"

#include "test/benchmark/depth/scene.hpp"

namespace extperfc::benchmark {

/// How far a detector's box is off: standard deviations as parts of the box's sides.
struct BoxError {
  double shift{0.03};
  double scale{0.05};
  double mean_scale{1.0};
};

/// A family of scenes.
struct Case {
  std::string name;
  std::vector<Shape> shapes;
  double near_m{0.2};  ///< the truth lies in [near_m, far_m]
  double far_m{0.9};
  bool at_border{false};  ///< the image's edge cuts the object
  BoxError box_error{};
};

/// Per class and range, then all classes at the image's border and with bad boxes.
[[nodiscard]] std::vector<Case> all_cases();

/// A rendering that fits the case; rejects until it does.
[[nodiscard]] Rendering draw_rendering(const Case& kind, const CameraModel& camera, Rng& rng);

/// The box as a detector would give it, clipped to the image.
[[nodiscard]] Box2 detected_box(const Box2& box, const BoxError& error, const CameraModel& camera, Rng& rng);

}  // namespace extperfc::benchmark
