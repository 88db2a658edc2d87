#include "extperfc/world/robot_model.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <utility>

#include "world/robot/urdf_document.hpp"
#include "world/robot/urdf_tree.hpp"

namespace extperfc {

namespace {

template <typename Named>
std::optional<int> index_of(const std::vector<Named>& elements, const std::string& name) {
  const auto found = std::find_if(elements.begin(), elements.end(),
                                  [&](const Named& element) { return element.name == name; });
  if (found == elements.end()) return std::nullopt;
  return static_cast<int>(found - elements.begin());
}

double position_of(const Joint& joint, std::size_t index, const std::vector<double>& positions) {
  if (joint.mimic) return joint.mimic->multiplier * positions.at(joint.mimic->joint) + joint.mimic->offset;
  return positions.at(index);
}

/// Motion of the child against the joint's frame.
Pose motion(const Joint& joint, double position) {
  Pose pose = Pose::Identity();
  if (joint.type == JointType::kPrismatic)
    pose.translation() = position * joint.axis;
  else
    pose.linear() = Eigen::AngleAxisd(position, joint.axis).toRotationMatrix();
  return pose;
}

}  // namespace

Result<RobotModel> RobotModel::from_urdf(const std::string& xml, const std::filesystem::path& resource_root) {
  const auto document = parse_urdf(xml);
  if (!document) return tl::unexpected<Error>(document.error());
  auto tree = to_link_tree(**document, resource_root);
  if (!tree) return tl::unexpected<Error>(tree.error());
  RobotModel model;
  model.name_ = (*document)->getName();
  model.links_ = std::move(tree->links);
  model.joints_ = std::move(tree->joints);
  return model;
}

Result<RobotModel> RobotModel::from_file(const std::filesystem::path& urdf,
                                         const std::filesystem::path& resource_root) {
  std::ifstream file(urdf, std::ios::binary);
  std::ostringstream xml;
  if (!file || !(xml << file.rdbuf()))
    return fail(ErrorCode::kNotFound,
                "robot description " + urdf.string() + " is missing, empty or unreadable");
  auto model = from_urdf(xml.str(), resource_root);
  if (!model) return fail(model.error().code, urdf.string() + ": " + model.error().message);
  return model;
}

std::optional<int> RobotModel::link(const std::string& name) const {
  return index_of(links_, name);
}

std::optional<int> RobotModel::joint(const std::string& name) const {
  return index_of(joints_, name);
}

std::vector<Pose> RobotModel::link_poses(const std::vector<double>& positions) const {
  std::vector<Pose> poses(links_.size(), Pose::Identity());
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const Joint& joint = joints_[i];
    Pose& child = poses[joint.child_link];
    child = poses[joint.parent_link] * joint.parent_T_joint;
    if (joint.type != JointType::kFixed) child = child * motion(joint, position_of(joint, i, positions));
  }
  return poses;
}

}  // namespace extperfc
