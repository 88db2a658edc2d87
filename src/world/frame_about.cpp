#include "extperfc/world/frame_about.hpp"

#include <Eigen/Geometry>

namespace extperfc {

// Not in a header: it makes Eigen instantiate a singular value decomposition, which compiles for four
// seconds.
Eigen::Matrix3d frame_about(const Eigen::Vector3d& axis) {
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis).toRotationMatrix();
}

}  // namespace extperfc
