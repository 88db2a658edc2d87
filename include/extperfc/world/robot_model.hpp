#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/shape.hpp"

namespace extperfc {

/// Mass and inertia of a link.
struct Inertial {
  double mass_kg{0};
  Pose link_T_com{Pose::Identity()};                           ///< frame of the inertia tensor
  Eigen::Matrix3d inertia_kg_m2{Eigen::Matrix3d::Identity()};  ///< symmetric, about the centre of mass
};

struct Link {
  std::string name;
  std::optional<Inertial> inertial;
  std::vector<Shape> visuals;
  std::vector<Shape> collisions;
  int parent_joint{-1};  ///< index of the joint that carries it; -1 for the root
};

enum class JointType { kFixed, kRevolute, kContinuous, kPrismatic };

/// Follows another joint: position = multiplier * other + offset.
struct Mimic {
  int joint{-1};
  double multiplier{1};
  double offset{0};
};

struct Joint {
  std::string name;
  JointType type{JointType::kFixed};
  int parent_link{-1};
  int child_link{-1};
  Pose parent_T_joint{Pose::Identity()};           ///< at position 0
  Eigen::Vector3d axis{Eigen::Vector3d::UnitX()};  ///< unit vector in the joint's frame
  double lower{0};                                 ///< [rad] or [m]; continuous: -infinity
  double upper{0};                                 ///< [rad] or [m]; continuous: +infinity
  double max_velocity{0};                          ///< [rad/s] or [m/s]
  double max_effort{0};                            ///< [N m] or [N]
  std::optional<Mimic> mimic;
};

/// A robot's tree of links, read from a URDF. Links and joints are in order from the root: a parent stands
/// before its children, and the child of joint i is link i + 1. Immutable, so it may be shared between
/// threads.
class RobotModel {
 public:
  /// `resource_root` is where `package://extperfc/` points. Errors: not a URDF, not a tree, a shape without
  /// size, an unknown mesh, a joint type that is not in JointType, a mimic of a joint that is missing or not
  /// driven, a limit with lower > upper. Numbers are read in the "C" locale. Thread-safe.
  [[nodiscard]] static Result<RobotModel> from_urdf(const std::string& xml,
                                                    const std::filesystem::path& resource_root);
  [[nodiscard]] static Result<RobotModel> from_file(const std::filesystem::path& urdf,
                                                    const std::filesystem::path& resource_root);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::vector<Link>& links() const { return links_; }
  [[nodiscard]] const std::vector<Joint>& joints() const { return joints_; }
  /// Index by name, empty when there is none.
  [[nodiscard]] std::optional<int> link(const std::string& name) const;
  [[nodiscard]] std::optional<int> joint(const std::string& name) const;

  /// Pose of every link in the root link's frame; `positions` has one value per joint (ignored for fixed and
  /// mimic joints). Throws std::out_of_range when values are missing. O(links).
  [[nodiscard]] std::vector<Pose> link_poses(const std::vector<double>& positions) const;

 private:
  std::string name_;
  std::vector<Link> links_;
  std::vector<Joint> joints_;
};

}  // namespace extperfc
