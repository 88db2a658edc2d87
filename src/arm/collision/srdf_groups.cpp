#include <algorithm>
#include <optional>

#include "extperfc/arm/srdf.hpp"

namespace extperfc::arm {
namespace {

/// Collects a group's joints.
class Collector {
 public:
  Collector(const Srdf& srdf, const RobotModel& robot) : srdf_(srdf), robot_(robot) {}

  Result<void> add_group(const std::string& name) {
    const auto group = std::find_if(srdf_.groups.begin(), srdf_.groups.end(),
                                    [&](const SrdfGroup& candidate) { return candidate.name == name; });
    if (group == srdf_.groups.end()) return fail(ErrorCode::kNotFound, "the SRDF has no group " + name);
    if (std::find(open_.begin(), open_.end(), name) != open_.end())
      return fail(ErrorCode::kCorrupt, "group " + name + " of the SRDF contains itself");
    open_.push_back(name);
    for (const auto& joint : group->joints)
      if (auto done = add_named(joint); !done) return done;
    for (const auto& link : group->links)
      if (auto done = add_carrier(link); !done) return done;
    for (const auto& [base, tip] : group->chains)
      if (auto done = add_chain(base, tip); !done) return done;
    for (const auto& inner : group->groups)
      if (auto done = add_group(inner); !done) return done;
    open_.pop_back();
    return {};
  }

  [[nodiscard]] std::vector<std::string> joints() && { return std::move(joints_); }

 private:
  void add(int index) {
    const Joint& joint = robot_.joints()[index];
    if (joint.type == JointType::kFixed || joint.mimic) return;
    if (std::find(joints_.begin(), joints_.end(), joint.name) == joints_.end()) joints_.push_back(joint.name);
  }

  Result<void> add_named(const std::string& name) {
    const auto index = robot_.joint(name);
    if (!index) return fail(ErrorCode::kNotFound, "the robot has no joint " + name);
    add(*index);
    return {};
  }

  Result<void> add_carrier(const std::string& name) {
    const auto link = robot_.link(name);
    if (!link) return fail(ErrorCode::kNotFound, "the robot has no link " + name);
    if (const int carrier = robot_.links()[*link].parent_joint; carrier >= 0) add(carrier);
    return {};
  }

  Result<void> add_chain(const std::string& base, const std::string& tip) {
    const auto first = robot_.link(base), last = robot_.link(tip);
    if (!first || !last) return fail(ErrorCode::kNotFound, "the robot has no link " + (first ? tip : base));
    const std::string none = "no chain leads from " + base + " to " + tip;
    std::vector<int> chain;
    for (int link = *last; link != *first;) {
      const int carrier = robot_.links()[link].parent_joint;
      if (carrier < 0) return fail(ErrorCode::kInvalidArgument, none);
      chain.push_back(carrier);
      link = robot_.joints()[carrier].parent_link;
    }
    std::for_each(chain.rbegin(), chain.rend(), [&](int joint) { add(joint); });
    return {};
  }

  const Srdf& srdf_;
  const RobotModel& robot_;
  std::vector<std::string> joints_, open_;
};

}  // namespace

Result<std::vector<std::string>> joints_of_group(const Srdf& srdf, const RobotModel& robot,
                                                 const std::string& group) {
  Collector collector(srdf, robot);
  if (auto done = collector.add_group(group); !done) return tl::unexpected<Error>(done.error());
  return std::move(collector).joints();
}

}  // namespace extperfc::arm
