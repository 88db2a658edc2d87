#include "world/robot/urdf_tree.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "world/robot/urdf_convert.hpp"

namespace extperfc {

namespace {

/// Each link hangs on one joint, so that walking down from the root ends. urdfdom does not look.
Result<void> check_parents(const urdf::ModelInterface& model) {
  std::map<std::string, std::string> carried_by;
  for (const auto& [name, joint] : model.joints_) {
    const auto [entry, first] = carried_by.emplace(joint->child_link_name, name);
    if (!first)
      return fail(ErrorCode::kCorrupt, "link '" + joint->child_link_name + "' is the child of the joints '" +
                                           entry->second + "' and '" + name + "': a link has one parent");
  }
  return {};
}

Result<void> append(const urdf::Link& link, int parent_joint, const std::filesystem::path& root,
                    LinkTree& tree) {
  auto converted = to_link(link, root);
  if (!converted) return tl::unexpected<Error>(converted.error());
  converted->parent_joint = parent_joint;
  const int parent = static_cast<int>(tree.links.size());
  tree.links.push_back(*std::move(converted));
  for (std::size_t i = 0; i < link.child_joints.size(); ++i) {
    auto joint = to_joint(*link.child_joints[i]);
    if (!joint) return tl::unexpected<Error>(joint.error());
    const int index = static_cast<int>(tree.joints.size());
    joint->parent_link = parent;
    joint->child_link = static_cast<int>(tree.links.size());
    tree.joints.push_back(*std::move(joint));
    if (auto added = append(*link.child_links[i], index, root, tree); !added) return added;
  }
  return {};
}

/// What urdfdom knows of a link that the walk did not reach.
Result<void> check_reached(const urdf::ModelInterface& model, const LinkTree& tree) {
  std::set<std::string> reached;
  for (const Link& link : tree.links) reached.insert(link.name);
  for (const auto& entry : model.links_)
    if (reached.count(entry.first) == 0)
      return fail(ErrorCode::kCorrupt, "link '" + entry.first +
                                           "' is part of a loop of joints that the root '" +
                                           tree.links.front().name + "' does not carry: open the loop");
  return {};
}

Result<int> mimicked_joint(const std::string& name, const urdf::ModelInterface& model,
                           const std::vector<Joint>& joints) {
  const auto found =
      std::find_if(joints.begin(), joints.end(), [&](const Joint& joint) { return joint.name == name; });
  if (found == joints.end())
    return fail(ErrorCode::kNotFound, "mimics the joint '" + name + "', which does not exist");
  if (found->type == JointType::kFixed || model.getJoint(name)->mimic)
    return fail(
        ErrorCode::kInvalidArgument,
        "mimics the joint '" + name + "', which is fixed or a mimic itself: name the joint that is driven");
  return static_cast<int>(found - joints.begin());
}

Result<void> add_mimics(const urdf::ModelInterface& model, std::vector<Joint>& joints) {
  for (Joint& joint : joints) {
    const auto source = model.getJoint(joint.name);
    if (!source->mimic || joint.type == JointType::kFixed) continue;
    const auto other = mimicked_joint(source->mimic->joint_name, model, joints);
    if (!other) return fail(other.error().code, "joint '" + joint.name + "' " + other.error().message);
    joint.mimic = Mimic{*other, source->mimic->multiplier, source->mimic->offset};
  }
  return {};
}

}  // namespace

Result<LinkTree> to_link_tree(const urdf::ModelInterface& model, const std::filesystem::path& resource_root) {
  LinkTree tree;
  auto done = check_parents(model);
  if (done) done = append(*model.getRoot(), -1, resource_root, tree);
  if (done) done = check_reached(model, tree);
  if (done) done = add_mimics(model, tree.joints);
  if (!done) return tl::unexpected<Error>(done.error());
  return tree;
}

}  // namespace extperfc
