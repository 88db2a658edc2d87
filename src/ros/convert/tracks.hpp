#pragma once

#include <vector>

#include <Eigen/Geometry>
#include <extperfc/TrackArray.h>
#include <vision_msgs/Detection3DArray.h>

#include "extperfc/track/tracker.hpp"

namespace extperfc::ros_convert {

/// What a detection says about its object, beside its position.
struct TrackedBody {
  geometry_msgs::Quaternion orientation;  ///< in the frame of the tracks
  geometry_msgs::Vector3 size;            ///< [m]
};

/// Positions of the best hypothesis of each detection, with its covariance, after `target_T_source`. A
/// detection without a hypothesis is not finite, so that the index of an observation is that of its
/// detection.
[[nodiscard]] std::vector<track::Observation> to_observations(const vision_msgs::Detection3DArray& message,
                                                              const Eigen::Isometry3d& target_T_source);

/// Orientation and size of a detection's box after `target_T_source`.
[[nodiscard]] TrackedBody body_of(const vision_msgs::Detection3D& detection,
                                  const Eigen::Isometry3d& target_T_source);

[[nodiscard]] Track to_message(const track::Track& track, const TrackedBody& body);

}  // namespace extperfc::ros_convert
