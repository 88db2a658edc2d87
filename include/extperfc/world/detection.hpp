#pragma once

#include <algorithm>
#include <vector>

namespace extperfc {

/// Axis-aligned rectangle in pixels of the full image; x right, y down, pixel edges (not centres), so a box
/// around the single pixel (0, 0) is {0, 0, 1, 1}. May reach beyond the image.
struct Box2 {
  float x_min{0};
  float y_min{0};
  float x_max{0};
  float y_max{0};

  [[nodiscard]] float width() const { return x_max - x_min; }
  [[nodiscard]] float height() const { return y_max - y_min; }
  [[nodiscard]] float area() const { return std::max(0.0F, width()) * std::max(0.0F, height()); }
  [[nodiscard]] float center_x() const { return 0.5F * (x_min + x_max); }
  [[nodiscard]] float center_y() const { return 0.5F * (y_min + y_max); }
};

/// Intersection over union, in [0, 1]; 0 when both are empty.
[[nodiscard]] inline float iou(const Box2& a, const Box2& b) {
  const Box2 both{std::max(a.x_min, b.x_min), std::max(a.y_min, b.y_min), std::min(a.x_max, b.x_max),
                  std::min(a.y_max, b.y_max)};
  const float shared = both.area();
  const float all = a.area() + b.area() - shared;
  return all > 0.0F ? shared / all : 0.0F;
}

/// One object in one image.
struct Detection {
  int class_index{0};  ///< into the model's class names
  float score{0};      ///< [0, 1]
  Box2 box;            ///< pixels of the image that was given, not of the network's input
};

using Detections = std::vector<Detection>;

}  // namespace extperfc
