#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "extperfc/arm/joint_trajectory.hpp"
#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/arm/srdf.hpp"
#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::arm {

/// Positions [rad] or [m] by the names of joints.
using JointPositions = std::map<std::string, double>;

/// Joints of an SRDF group that are planned for together.
struct ArmGroup {
  std::string name;
  std::vector<std::string> joints;  ///< in the order of every JointVector
  std::vector<std::string> tips;    ///< links at the ends of its chains, in the SRDF's order
  JointVector max_velocity;         ///< [rad/s] or [m/s], of the robot description
  JointVector max_acceleration;     ///< [rad/s^2] or [m/s^2]
};

struct RobotArmsParams {
  /// Of every joint that max_acceleration does not name; above 0 [rad/s^2] or [m/s^2].
  double default_max_acceleration{3.0};
  JointPositions max_acceleration;
};

/// A robot and its groups of joints. Immutable; a copy shares the data.
class RobotArms {
 public:
  /// Errors: a group of the SRDF that does not fit the robot, a group's joint without a velocity limit or
  /// with limits that are not finite (continuous joints excepted), a parameter out of its range or for a
  /// joint that does not exist. Groups without a chain (hands) are left out.
  [[nodiscard]] static Result<RobotArms> make(const RobotModel& robot, const Srdf& srdf,
                                              const RobotArmsParams& params = {});

  [[nodiscard]] const RobotModel& robot() const { return data_->robot; }
  [[nodiscard]] const Srdf& srdf() const { return data_->srdf; }
  [[nodiscard]] const std::vector<ArmGroup>& groups() const { return data_->groups; }
  /// Error: no such group; the message names those that there are.
  [[nodiscard]] Result<const ArmGroup*> group(const std::string& name) const;
  /// The root of the tree: frame of everything in space.
  [[nodiscard]] const std::string& root_link() const { return data_->robot.links().front().name; }

  /// A state of the SRDF for the group, e.g. "neutral"; states of groups within it are joined. Errors: no
  /// such state (the message names those that there are), or one that leaves joints of the group open.
  [[nodiscard]] Result<JointPositions> named_state(const ArmGroup& group, const std::string& state) const;

  /// The group's values among `positions`. Error: one is missing; the message names it.
  [[nodiscard]] static Result<JointVector> select(const ArmGroup& group, const JointPositions& positions);

  /// root_T_link with the joints at `positions`; those not named at 0 or their nearest limit. Error: no such
  /// link.
  [[nodiscard]] Result<Pose> link_pose(const std::string& link, const JointPositions& positions) const;

 private:
  struct Data {
    RobotModel robot;
    Srdf srdf;
    std::vector<ArmGroup> groups;
  };
  explicit RobotArms(std::shared_ptr<const Data> data) : data_(std::move(data)) {}
  std::shared_ptr<const Data> data_;
};

}  // namespace extperfc::arm
