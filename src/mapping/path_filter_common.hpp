#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "extperfc/world/pose.hpp"

#include "mapping/pose_distance.hpp"

namespace extperfc::mapping {

// Shared by the parts of PathFilter: when a submap counts as matched, and when two poses count as one.

inline constexpr double kMatchSigmaM = 0.3;  // of a particle before the match
inline constexpr double kMatchSigmaRad = 0.12;
inline constexpr double kMatchReachM = 0.4;
inline constexpr double kFarthestPullM = 0.6;  // a match that moves the pose farther is wrong
inline constexpr double kFarthestPullRad = 0.25;
inline constexpr double kGoodFit = 0.6;  // fraction of points explained from which a submap counts as matched
inline constexpr double kContradictionCost =
    2.0;                                    // of fit, per fraction of contradicting points and surfaces
inline constexpr double kWeightGain = 6.0;  // log weight per key frame and unit of fit
inline constexpr double kSameClusterM = 0.3;
inline constexpr double kSameClusterRad = 0.1;
inline constexpr double kDriftPerM = 0.012;  // standard deviation of the tracker's drift

// Loops of the whole path.
inline constexpr double kMinLoopM = 8.0;  // of path between a submap and one that it may be recognized in
inline constexpr std::size_t kMinLoopFrames = 24;
inline constexpr double kOverlapM = 4.0;             // two key frames this near have much the same view
inline constexpr std::size_t kOtherPassFrames = 30;  // apart: another pass of the same location
inline constexpr int kGraphIterations = 10;

/// Of key frames and their distances those that are nearest, one of each pass, the nearest first.
inline std::vector<std::size_t> nearest_of_passes(std::vector<std::pair<double, std::size_t>> frames,
                                                  std::size_t max_count) {
  std::sort(frames.begin(), frames.end());
  std::vector<std::size_t> chosen;
  for (const auto& [away, i] : frames) {
    const bool new_pass = std::all_of(chosen.begin(), chosen.end(), [&, i = i](std::size_t other) {
      return (i > other ? i - other : other - i) >= kOtherPassFrames;
    });
    if (new_pass) chosen.push_back(i);
    if (chosen.size() == max_count) break;
  }
  return chosen;
}

inline bool near(const Pose2& a, const Pose2& b, double m, double rad) {
  return distance(a, b) < m && yaw_between(a, b) < rad;
}

}  // namespace extperfc::mapping
