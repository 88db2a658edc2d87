#pragma once

#include <Eigen/Core>

namespace extperfc {

/// The shortest rotation that turns z into `axis` (any length but 0): the axes of a frame whose z lies along
/// it.
[[nodiscard]] Eigen::Matrix3d frame_about(const Eigen::Vector3d& axis);

}  // namespace extperfc
