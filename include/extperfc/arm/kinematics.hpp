#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <kdl/chain.hpp>
#include <kdl/frames.hpp>
#include <kdl/jntarray.hpp>

#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::arm {

struct ChainGeometry;

/// 6 x joints: the velocity of the tip's origin (rows 0..2, [m/s]) and of the tip (rows 3..5, [rad/s]) per
/// unit velocity of each joint.
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxJoints>;

/// The joints between two links of a robot. Vectors hold one value per moving joint, in the order from the
/// root; fixed joints are merged. Immutable, cheap to copy, may be shared between threads.
class ArmChain {
 public:
  /// Errors: a link that does not exist (kNotFound); a tip that the root does not carry, no moving joint
  /// between them, or a joint whose range is empty or not finite (kInvalidArgument); a joint that follows
  /// another one, or more than kMaxJoints of them (kUnsupported).
  [[nodiscard]] static Result<ArmChain> make(const RobotModel& robot, const std::string& root_link,
                                             const std::string& tip_link);

  [[nodiscard]] int joint_count() const { return static_cast<int>(joint_names_.size()); }
  [[nodiscard]] const std::vector<std::string>& joint_names() const { return joint_names_; }
  /// Indices in RobotModel::joints().
  [[nodiscard]] const std::vector<int>& robot_joints() const { return robot_joints_; }
  [[nodiscard]] const std::string& root_link() const { return root_link_; }
  [[nodiscard]] const std::string& tip_link() const { return tip_link_; }
  /// Continuous joints: -infinity and +infinity.
  [[nodiscard]] const JointLimits& limits() const { return limits_; }
  /// [rad/s] or [m/s]
  [[nodiscard]] const JointVector& max_velocity() const { return max_velocity_; }
  /// The middle of every range; 0 for continuous joints.
  [[nodiscard]] JointVector mid_range() const;
  /// The nearest position within the limits.
  [[nodiscard]] JointVector clamp(const JointVector& joints) const;
  /// The shortest displacement between two positions: continuous joints take the shorter rotation.
  [[nodiscard]] JointVector difference(const JointVector& to, const JointVector& from) const;
  [[nodiscard]] bool within_limits(const JointVector& joints) const;

  /// root_T_tip. Throws std::invalid_argument when `joints` has another size. O(joints), about 0.2 us for
  /// seven.
  [[nodiscard]] Pose forward(const JointVector& joints) const;
  /// Of forward(), in the root link's frame. Throws as forward() does.
  [[nodiscard]] Jacobian jacobian(const JointVector& joints) const;

  /// The same chain for KDL's solvers: one segment per joint of the description, named after its child link.
  [[nodiscard]] const KDL::Chain& kdl() const { return *kdl_; }
  /// For the solvers of this library.
  [[nodiscard]] const ChainGeometry& geometry() const { return *geometry_; }

 private:
  std::string root_link_, tip_link_;
  std::vector<std::string> joint_names_;
  std::vector<int> robot_joints_;
  JointLimits limits_;
  JointVector max_velocity_;
  std::shared_ptr<const KDL::Chain> kdl_;
  std::shared_ptr<const ChainGeometry> geometry_;
};

[[nodiscard]] KDL::Frame to_kdl(const Pose& pose);
[[nodiscard]] Pose from_kdl(const KDL::Frame& frame);
[[nodiscard]] KDL::JntArray to_kdl(const JointVector& joints);
/// Throws std::invalid_argument for more than kMaxJoints values.
[[nodiscard]] JointVector from_kdl(const KDL::JntArray& joints);

}  // namespace extperfc::arm
