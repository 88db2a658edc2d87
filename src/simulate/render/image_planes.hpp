#pragma once

#include <cstddef>
#include <vector>

#include "simulate/render/ray_scene.hpp"

namespace extperfc::simulate {

/// Floats in rows, with a border that holds -1, so that neighbours need no check.
class Plane {
 public:
  static constexpr int kBorder = 16;  ///< columns at each side; rows: kBorderRows
  static constexpr int kBorderRows = 2;

  /// Sizes are rounded up to whole tiles.
  void resize(int width, int height);
  [[nodiscard]] float* row(int y) { return data_.data() + offset(y); }
  [[nodiscard]] const float* row(int y) const { return data_.data() + offset(y); }

 private:
  [[nodiscard]] std::size_t offset(int y) const {
    return static_cast<std::size_t>(y + kBorderRows) * stride_ + kBorder;
  }
  std::size_t stride_{0};
  int width_{0};
  int height_{0};
  std::vector<float> data_;
};

/// An image before its light is put together.
struct ImagePlanes {
  Plane depth;       ///< [m]; -1: nothing
  Plane direct[3];   ///< direct light that is reflected where nothing blocks it, linear
  Plane ambient[3];  ///< light from all around that comes back, linear
  Plane light_seen;  ///< 1: the pixel's point of the light is seen, 0: it is not, -1: unknown
  Plane sky_seen;    ///< as light_seen, for the pixel's direction

  void resize(int width, int height);
};

/// Writes the 16 values of a tile whose left upper pixel is (x, y).
void store(const float* lanes, int x, int y, Plane& plane);

/// Replaces each value by the mean over 4 x 4 pixels around it that are known and whose depth is about the
/// same. All 16 lanes of the pattern are in any 4 x 4 pixels. Nothing known: 1. `scratch` has the same size.
void spread(const Plane& depth, Plane& seen, Plane& scratch, int width, int height);

/// The light that is shown as `shown`, [0, 1].
[[nodiscard]] float light_of(float shown);

/// Puts a row together: display values in [0, 1] (not linear), three per `width` pixels, planar.
void resolve_row(const ImagePlanes& planes, int y, int width, float* red, float* green, float* blue);

}  // namespace extperfc::simulate
