#pragma once

#include <array>
#include <optional>

#include "extperfc/depth/box_depth.hpp"

namespace extperfc::depth {

/// Whole pixels [x0, x1) x [y0, y1) inside an image.
struct Region {
  int x0{0};
  int y0{0};
  int x1{0};
  int y1{0};

  [[nodiscard]] bool empty() const { return x1 <= x0 || y1 <= y0; }
  [[nodiscard]] int width() const { return x1 - x0; }
  [[nodiscard]] int height() const { return y1 - y0; }
};

/// One valid depth value.
struct Sample {
  float dx;  ///< pixel centre relative to the centre of the box [px]
  float dy;
  float depth_m;
};

/// The valid values of a region. Lives on the stack: a larger region is sampled on a regular grid instead.
struct Samples {
  static constexpr int kCapacity = 1024;

  std::array<Sample, kCapacity> items;  // the first `size` are set
  int size{0};
  int looked_at{0};  ///< grid points of the region, valid or not
  int step{1};       ///< pixels between grid points

  [[nodiscard]] const Sample* begin() const { return items.data(); }
  [[nodiscard]] const Sample* end() const { return items.data() + size; }
  /// Pixels of the image that `count` samples stand for.
  [[nodiscard]] double pixels(double count) const { return count * step * step; }
};

/// The part of the box inside the image; empty when it is not finite, has no area or lies outside.
[[nodiscard]] std::optional<Box2> clip_box(const Box2& box, int width, int height);

/// Square of `side` pixels around the centre of `box`, clipped to the image.
[[nodiscard]] Region center_window(const Box2& box, int side, int width, int height);

/// The middle `fraction` of the box, rounded outwards to whole pixels. `box` lies inside the image.
[[nodiscard]] Region central_part(const Box2& box, double fraction, int width, int height);

/// Reads the valid depths of `region`, which lies inside the image, into `out`.
void collect(const ImageView& depth, const Region& region, const Box2& box, const BoxDepthParams& params,
             Samples& out);

}  // namespace extperfc::depth
