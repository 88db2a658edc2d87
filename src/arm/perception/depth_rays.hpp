#pragma once

#include <vector>

#include <Eigen/Core>

#include "extperfc/world/camera_model.hpp"
#include "extperfc/world/image_view.hpp"

namespace extperfc::arm {

/// Directions of the pixels of a camera that are looked at, with a depth of 1 m. Kept while the camera stays
/// the same.
class DepthRays {
 public:
  explicit DepthRays(int pixel_step) : step_(pixel_step) {}

  /// O(pixels) when the camera is another one, else O(1).
  void set(const CameraModel& camera);

  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int step() const { return step_; }
  /// x and y of the point at 1 m of the k-th pixel of a row that is looked at, pixel k * step().
  [[nodiscard]] const Eigen::Vector2f* row(int row) const {
    return rays_.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_);
  }
  /// Whether a direction, as in row(), is in the image or within a tenth of its size beside it. Further out
  /// a lens model of high order may put points into the image that are not there.
  [[nodiscard]] bool near_view(const Eigen::Vector2d& ray) const {
    return (ray.array() >= low_.array()).all() && (ray.array() <= high_.array()).all();
  }

 private:
  const int step_;
  int columns_{0}, rows_{0};
  CameraModel camera_;
  std::vector<Eigen::Vector2f> rays_;
  Eigen::Vector2d low_{Eigen::Vector2d::Zero()}, high_{Eigen::Vector2d::Zero()};
};

/// Depth [m] of a pixel of a depth image; 0 when there is no measurement.
[[nodiscard]] float depth_at(const ImageView& image, int u, int v);

}  // namespace extperfc::arm
