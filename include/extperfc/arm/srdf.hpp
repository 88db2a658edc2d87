#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/arm/collision_model.hpp"
#include "extperfc/base/error.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::arm {

/// Two links that are not checked against each other, and why.
struct DisabledPair {
  std::string link_a;
  std::string link_b;
  std::string reason;  ///< "Adjacent", "Never", "Always", "Rigid" or any other text
};

/// Joints that are planned for together: those named, those of links, of chains, and of other groups.
struct SrdfGroup {
  std::string name;
  std::vector<std::string> joints;
  std::vector<std::string> links;                           ///< stands for the joint that carries each
  std::vector<std::pair<std::string, std::string>> chains;  ///< base link, tip link
  std::vector<std::string> groups;
};

struct SrdfState {
  std::string name;
  std::string group;
  std::map<std::string, double> positions;  ///< joint: [rad] or [m]
};

struct SrdfEndEffector {
  std::string name;
  std::string group;
  std::string parent_link;
  std::string parent_group;  ///< may be empty
};

/// The semantic companion of a URDF, as MoveIt reads it. Virtual joints and passive joints are passed over.
struct Srdf {
  std::string robot;
  std::vector<SrdfGroup> groups;
  std::vector<SrdfState> states;
  std::vector<SrdfEndEffector> end_effectors;
  std::vector<DisabledPair> disabled;
};

/// Errors: not XML, no <robot>, an element without a name it needs, a number that is none.
[[nodiscard]] Result<Srdf> parse_srdf(const std::string& xml);
[[nodiscard]] Result<Srdf> read_srdf(const std::filesystem::path& file);
/// XML that parse_srdf() reads back equal.
[[nodiscard]] std::string to_xml(const Srdf& srdf);

/// The group's moving joints (none fixed, none that mimics), each once, from base to tip in the order named.
/// Errors: an unknown group, joint or link; a chain that does not lead from base to tip; groups in a circle.
[[nodiscard]] Result<std::vector<std::string>> joints_of_group(const Srdf& srdf, const RobotModel& robot,
                                                               const std::string& group);

[[nodiscard]] AllowedPairs allowed_pairs(const Srdf& srdf);

}  // namespace extperfc::arm
