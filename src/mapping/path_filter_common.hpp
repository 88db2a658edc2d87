#pragma once

#include <cmath>

#include "extperfc/world/pose.hpp"

namespace extperfc::mapping {

// What the parts of PathFilter share: when a place counts as seen, and when two poses count as one.

inline constexpr double kSightSigmaM = 0.3;  // of a particle before it looks
inline constexpr double kSightSigmaRad = 0.12;
inline constexpr double kSightReachM = 0.4;
inline constexpr double kFarthestPullM = 0.6;  // a match that pulls farther found something else
inline constexpr double kFarthestPullRad = 0.25;
inline constexpr double kGoodFit = 0.6;  // share of points explained at which a place counts as seen
inline constexpr double kContradictionCost = 2.0;  // of fit, per share of points and surfaces that cannot be
inline constexpr double kSameClusterM = 0.3;
inline constexpr double kSameClusterRad = 0.1;
inline constexpr double kDriftPerM = 0.012;  // standard deviation of the tracker's drift

inline double distance(const Pose2& a, const Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

inline double turn_between(const Pose2& a, const Pose2& b) {
  return std::abs(wrap_angle(a.yaw - b.yaw));
}

inline bool near(const Pose2& a, const Pose2& b, double m, double rad) {
  return distance(a, b) < m && turn_between(a, b) < rad;
}

}  // namespace extperfc::mapping
