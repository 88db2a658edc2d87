#include "scan/slope_ground.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::scan {

namespace {

/// The floor of a column up to its last point.
class Floor {
 public:
  explicit Floor(const GroundParams& params)
      : steepest_(static_cast<float>(std::tan(params.max_slope_rad))),
        z_(static_cast<float>(params.z_m)),
        anchor_z_(z_) {}

  /// How far it may have risen or sunk from its last point to `range` [m].
  [[nodiscard]] float rise(float range) const {
    constexpr float kLongestStepM = 0.6F;
    const float step = range - range_;
    return std::min(steepest_ * step, slope_ * step + steepest_ * std::min(step, kLongestStepM));
  }

  [[nodiscard]] float z() const { return z_; }

  void extend(float range, float z) {
    constexpr float kBaselineM = 0.15F;  // noise of 1 cm on it is a slope of 4 degrees
    const float max_rise = rise(range);
    z_ += std::clamp(z - z_, -max_rise, max_rise);
    range_ = range;
    if (range - anchor_range_ < kBaselineM) return;
    slope_ = std::clamp((z_ - anchor_z_) / (range - anchor_range_), 0.0F, steepest_);
    anchor_range_ = range;
    anchor_z_ = z_;
  }

 private:
  float steepest_;
  float range_{0};
  float z_;
  float slope_{0};  ///< upwards, over the last 0.15 m or more
  float anchor_range_{0};
  float anchor_z_;
};

/// Another point steeply above or below within 0.1 m behind `point`.
bool is_face(const ColumnPoint* point, const Column& column, const std::vector<float>& z, float clearance,
             float steepest) {
  constexpr float kDepthM = 0.1F;
  constexpr std::ptrdiff_t kMaxCompared = 64;
  const ColumnPoint* const last = point + std::min<std::ptrdiff_t>(column.end() - point, kMaxCompared);
  for (const ColumnPoint* other = point + 1; other < last && other->range - point->range <= kDepthM; ++other)
    if (std::abs(z[other->index] - z[point->index]) > clearance + steepest * kDepthM) return true;
  return false;
}

}  // namespace

std::size_t obstacles_first(const Column& column, const std::vector<float>& z, const GroundParams& params) {
  const auto steepest = static_cast<float>(std::tan(params.max_slope_rad));
  const auto clearance = static_cast<float>(params.clearance_m);
  Floor floor(params);
  std::size_t obstacles = 0;
  for (ColumnPoint* point = column.begin(); point != column.end(); ++point) {
    const float rise = floor.rise(point->range);
    const float above = z[point->index] - floor.z();
    if (above >= rise + clearance || (above > clearance && is_face(point, column, z, clearance, steepest))) {
      // The place is not swapped but overwritten: floor points are needed no more.
      column.first[obstacles++] = *point;
    } else if (above > -rise - clearance) {  // lower ones are holes or reflections
      floor.extend(point->range, z[point->index]);
    }
  }
  return obstacles;
}

}  // namespace extperfc::scan
