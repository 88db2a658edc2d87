#include "extperfc/arm/parallel_hand.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "arm/collision/convex_part.hpp"

namespace extperfc::arm {
namespace {

struct ShapeBounds {
  Eigen::Vector3d low{Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity())};
  Eigen::Vector3d high{-low};
  void add(const ShapeBounds& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
};

/// Links without a moving joint between them and `link`, itself included.
std::vector<int> rigid_group(const RobotModel& robot, int link) {
  std::vector<int> group{link};
  for (const Joint& joint : robot.joints())
    if (joint.type == JointType::kFixed &&
        std::find(group.begin(), group.end(), joint.parent_link) != group.end())
      group.push_back(joint.child_link);
  return group;
}

/// A robot with all joints at 0 but for the one that drives the fingers, seen from the tip.
class View {
 public:
  View(const RobotModel& robot, int tip, int joint, double value) : robot_(robot) {
    std::vector<double> positions(robot.joints().size(), 0.0);
    positions[joint] = value;
    poses_ = robot.link_poses(positions);
    const Pose tip_T_root = poses_[tip].inverse();
    for (Pose& pose : poses_) pose = tip_T_root * pose;
  }

  [[nodiscard]] const Pose& pose(int link) const { return poses_[link]; }

  /// Of every collision shape of the links.
  [[nodiscard]] Result<std::vector<ShapeBounds>> bounds(const std::vector<int>& links) const {
    std::vector<ShapeBounds> all;
    for (const int link : links) {
      const auto parts =
          make_convex_parts("link " + robot_.links()[link].name, robot_.links()[link].collisions);
      if (!parts) return tl::unexpected<Error>(parts.error());
      for (const auto& part : *parts) {
        const Pose pose = poses_[link] * part->body_T_part;
        const Eigen::Vector3d half = rotated_half(*part, pose.linear());
        all.push_back({pose.translation() - half, pose.translation() + half});
      }
    }
    return all;
  }

 private:
  const RobotModel& robot_;
  std::vector<Pose> poses_;
};

struct Fingers {
  int tip, joint, mimic;
  std::vector<int> driven, other;  ///< links
};

Result<Fingers> find_fingers(const RobotModel& robot, const std::string& tip_link,
                             const std::string& finger_joint) {
  const auto tip = robot.link(tip_link);
  const auto joint = robot.joint(finger_joint);
  if (!tip || !joint)
    return fail(ErrorCode::kNotFound,
                "the robot has no " + (tip ? "joint " + finger_joint : "link " + tip_link));
  if (robot.joints()[*joint].type != JointType::kPrismatic)
    return fail(ErrorCode::kInvalidArgument, "joint " + finger_joint + " is not prismatic");
  const auto& joints = robot.joints();
  const auto mimic = std::find_if(joints.begin(), joints.end(), [&](const Joint& other) {
    return other.mimic && other.mimic->joint == *joint && other.type == JointType::kPrismatic &&
           other.parent_link == joints[*joint].parent_link;
  });
  if (mimic == joints.end())
    return fail(ErrorCode::kInvalidArgument, "no finger beside that of joint " + finger_joint + " mimics it");
  return Fingers{*tip, *joint, static_cast<int>(mimic - joints.begin()),
                 rigid_group(robot, joints[*joint].child_link), rigid_group(robot, mimic->child_link)};
}

ShapeBounds mirrored(const ShapeBounds& bounds) {
  return {{bounds.low.x(), -bounds.high.y(), bounds.low.z()},
          {bounds.high.x(), -bounds.low.y(), bounds.high.z()}};
}

bool alike(const std::vector<ShapeBounds>& a, const std::vector<ShapeBounds>& b) {
  constexpr double kAlike = 1e-3;  // [m]
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const ShapeBounds other = mirrored(b[i]);
    // Left and right may be exchanged along x: the pieces of such fingers are rotated, not mirrored.
    const double x =
        std::min((a[i].low - other.low).cwiseAbs().x() + (a[i].high - other.high).cwiseAbs().x(),
                 std::abs(a[i].low.x() + other.high.x()) + std::abs(a[i].high.x() + other.low.x()));
    if (x > kAlike || (a[i].low - other.low).tail<2>().norm() > kAlike ||
        (a[i].high - other.high).tail<2>().norm() > kAlike)
      return false;
  }
  return true;
}

/// The pieces of the finger on the side y > 0 when closed. What reaches across the middle is none of them.
void add_fingers(std::vector<ShapeBounds> shapes, ParallelHand& hand) {
  shapes.erase(
      std::remove_if(shapes.begin(), shapes.end(), [](const ShapeBounds& b) { return b.low.y() <= 0; }),
      shapes.end());
  std::stable_sort(shapes.begin(), shapes.end(),
                   [](const ShapeBounds& a, const ShapeBounds& b) { return a.low.y() < b.low.y(); });
  for (const ShapeBounds& shape : shapes)
    hand.parts.push_back({std::max(std::abs(shape.low.x()), std::abs(shape.high.x())), shape.low.z(),
                          shape.high.z(), shape.low.y() - shapes.front().low.y(),
                          shape.high.y() - shape.low.y()});
  if (!shapes.empty()) hand.opening_min_m = 2 * shapes.front().low.y();
}

/// What reaches across the middle when closed counts where it is then and when open.
void add_carriage(const std::vector<ShapeBounds>& closed, const std::vector<ShapeBounds>& open,
                  ShapeBounds& palm) {
  for (std::size_t i = 0; i < closed.size(); ++i) {
    if (closed[i].low.y() > 0 || closed[i].high.y() < 0) continue;
    palm.add(closed[i]);
    palm.add(open[i]);
  }
}

}  // namespace

Result<void> ParallelHand::validate() const {
  const auto bad = [&](const std::string& what) {
    return fail(ErrorCode::kInvalidArgument, "gripper " + tip_link + ": " + what);
  };
  if (!(opening_min_m >= 0 && opening_max_m > opening_min_m && opening_max_m <= 0.5))
    return bad("openings must be 0 <= min < max <= 0.5 m");
  if (parts.empty())
    return bad("no shape of a finger lies on one side of the middle, y > 0, when it is closed");
  for (const FingerPart& part : parts)
    if (!(part.x_half_m > 0 && part.z_high_m > part.z_low_m && part.inset_m >= 0 && part.thickness_m > 0) ||
        !std::isfinite(part.x_half_m + part.z_high_m - part.z_low_m + part.inset_m + part.thickness_m))
      return bad("a part of a finger has a size that cannot be");
  if (!palm_low.allFinite() || !palm_high.allFinite() || (palm_high - palm_low).minCoeff() < 0)
    return bad("the palm's box cannot be");
  if (!(palm_high.z() < parts.front().z_high_m)) return bad("the palm lies in front of the pad's end");
  return {};
}

Result<ParallelHand> hand_of(const RobotModel& robot, const std::string& tip_link,
                             const std::string& finger_joint) {
  const auto fingers = find_fingers(robot, tip_link, finger_joint);
  if (!fingers) return tl::unexpected<Error>(fingers.error());
  const Joint& joint = robot.joints()[fingers->joint];
  const View closed(robot, fingers->tip, fingers->joint, joint.lower);
  const View open(robot, fingers->tip, fingers->joint, joint.upper);
  const int link = joint.child_link;
  const Eigen::Vector3d delta = open.pose(link).translation() - closed.pose(link).translation();
  if (!(std::abs(delta.y()) > 1e-6) || delta.head<1>().norm() + std::abs(delta.z()) > 1e-6)
    return fail(ErrorCode::kInvalidArgument,
                "joint " + finger_joint + " does not move along y of " + tip_link);
  const auto one = closed.bounds(fingers->driven), two = closed.bounds(fingers->other);
  const auto palm_shapes = closed.bounds(rigid_group(robot, joint.parent_link));
  for (const auto* shapes : {&one, &two, &palm_shapes})
    if (!*shapes) return tl::unexpected<Error>(shapes->error());
  if (one->empty() || !alike(*one, *two))
    return fail(ErrorCode::kInvalidArgument,
                "the fingers of " + tip_link + " have no shapes or are not alike");
  ParallelHand hand;
  hand.tip_link = tip_link;
  add_fingers(delta.y() > 0 ? *one : *two, hand);
  hand.opening_max_m = hand.opening_min_m + 2 * std::abs(delta.y());
  ShapeBounds palm;
  for (const ShapeBounds& shape : *palm_shapes) palm.add(shape);
  add_carriage(*one, *open.bounds(fingers->driven), palm);
  add_carriage(*two, *open.bounds(fingers->other), palm);
  hand.palm_low = palm.low;
  hand.palm_high = palm.high;
  for (const auto* links : {&fingers->driven, &fingers->other})
    for (const int index : *links)
      if (!robot.links()[index].collisions.empty()) hand.finger_links.push_back(robot.links()[index].name);
  if (auto ok = hand.validate(); !ok) return tl::unexpected<Error>(ok.error());
  return hand;
}

}  // namespace extperfc::arm
