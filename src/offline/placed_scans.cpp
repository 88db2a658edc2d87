#include "extperfc/offline/placed_scans.hpp"

#include <cmath>
#include <utility>

namespace extperfc::offline {

namespace {

bool is_far(const Pose2& from, const Pose2& to, const ScanSpacing& spacing) {
  const auto step = between(from, to);
  return std::hypot(step.x, step.y) >= spacing.distance_m || std::abs(step.yaw) >= spacing.rotation_rad;
}

}  // namespace

std::vector<sources::PlacedScan> placed_scans(sources::ScanLog& log, const MappingResult& result,
                                              const ScanSpacing& spacing) {
  std::vector<sources::PlacedScan> scans;
  for (std::size_t i = 0; i < result.trajectory.size();) {
    auto record = log.next();
    if (!record || !*record) break;
    if ((*record)->index != result.scan_index[i]) continue;
    const auto& pose = result.trajectory[i++].pose;
    const bool wanted = scans.empty() || is_far(scans.back().map_T_base, pose, spacing);
    if (wanted && validate((*record)->scan)) scans.push_back({pose, std::move((*record)->scan)});
  }
  return scans;
}

}  // namespace extperfc::offline
