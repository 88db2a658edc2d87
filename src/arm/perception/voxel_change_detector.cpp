#include "extperfc/arm/voxel_change_detector.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace extperfc::arm {
namespace {

constexpr std::int64_t kRow = std::int64_t{1} << 20;  // more than the voxels along an edge
constexpr std::int64_t kLayer = kRow * kRow;

bool near_one_of(const std::unordered_set<std::int64_t>& keys, std::int64_t key) {
  if (keys.count(key) > 0) return true;
  for (std::int64_t z = -kLayer; z <= kLayer; z += kLayer)
    for (std::int64_t y = -kRow; y <= kRow; y += kRow)
      for (std::int64_t x = -1; x <= 1; ++x)
        if (keys.count(key + x + y + z) > 0) return true;
  return false;
}

bool all_near(const std::unordered_set<std::int64_t>& keys, const std::unordered_set<std::int64_t>& others) {
  return std::all_of(keys.begin(), keys.end(), [&](std::int64_t key) { return near_one_of(others, key); });
}

}  // namespace

bool VoxelChangeDetector::changed(const std::vector<Eigen::Vector3d>& middles, double time_s) {
  Keys now;
  now.reserve(middles.size());
  for (const auto& middle : middles) {
    // Cells begin at 1: neighbours at the border must not be keys of other rows.
    const Eigen::Vector3d cell = ((middle - low_m_) / voxel_m_).array().floor() + 1;
    now.insert(static_cast<std::int64_t>(cell.x()) + kRow * static_cast<std::int64_t>(cell.y()) +
               kLayer * static_cast<std::int64_t>(cell.z()));
  }
  if (now == reported_) return false;
  const bool waited = !(time_s - reported_s_ < patience_s_) || time_s < reported_s_;
  if (!waited && all_near(now, reported_) && all_near(reported_, now)) return false;
  reported_ = std::move(now);
  reported_s_ = time_s;
  return true;
}

}  // namespace extperfc::arm
