// The robot in urdf/mobile_baxter.urdf against Baxter's published figures.
#include <array>
#include <cmath>
#include <map>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "extperfc/world/robot_model.hpp"

namespace extperfc {
namespace {

constexpr std::array<const char*, 7> kJoints{"s0", "s1", "e0", "e1", "w0", "w1", "w2"};
using Arm = std::array<double, 7>;

const RobotModel& baxter() {
  static const RobotModel robot = [] {
    const std::filesystem::path root = EXTPERFC_SOURCE_DIR;
    auto result = RobotModel::from_file(root / "urdf/mobile_baxter.urdf", root);
    if (!result) throw std::runtime_error(result.error().message);
    return *std::move(result);
  }();
  return robot;
}

std::vector<double> positions(const std::string& side, const Arm& arm) {
  std::vector<double> result(baxter().joints().size(), 0.0);
  for (std::size_t i = 0; i < arm.size(); ++i)
    result[baxter().joint(side + "_" + kJoints[i]).value()] = arm[i];
  return result;
}

Pose relative(const std::vector<Pose>& poses, const std::string& target, const std::string& source) {
  return poses[baxter().link(target).value()].inverse() * poses[baxter().link(source).value()];
}

Pose at_rest(const std::string& target, const std::string& source) {
  return relative(baxter().link_poses(std::vector<double>(baxter().joints().size(), 0.0)), target, source);
}

const Joint& joint(const std::string& name) {
  return baxter().joints()[baxter().joint(name).value()];
}

/// Positions of one arm with the published pose of its gripper in `base` (position, rotation by rows).
struct ArmPose {
  const char* name;
  const char* side;
  Arm arm;
  std::array<double, 3> xyz;
  std::array<double, 9> rotation;
};

const std::array<ArmPose, 6> kPoses{{
    {"tuck",
     "left",
     {-1.0, -2.07, 3.0, 2.55, 0.0, 0.01, 0.0},
     {-0.134718, 0.371985, -0.070326},
     {0.941463, -0.331882, -0.059183, -0.325884, -0.940899, 0.092244, -0.086299, -0.067558, -0.993976}},
    {"tuck",
     "right",
     {1.0, -2.07, -3.0, 2.55, 0.0, 0.01, 0.0},
     {-0.134718, -0.371985, -0.070326},
     {0.941463, 0.331882, -0.059183, 0.325884, -0.940899, -0.092244, -0.086299, 0.067558, -0.993976}},
    {"untuck",
     "left",
     {-0.08, -1.0, -1.19, 1.94, 0.67, 1.03, -0.5},
     {0.579711, 0.183294, 0.1137},
     {-0.959067, 0.278031, 0.053747, 0.27922, 0.960096, 0.015889, -0.047185, 0.030246, -0.998428}},
    {"untuck",
     "right",
     {0.08, -1.0, 1.19, 1.94, -0.67, 1.03, 0.5},
     {0.579711, -0.183294, 0.1137},
     {-0.959067, -0.278031, 0.053747, -0.27922, 0.960096, -0.015889, -0.047185, -0.030246, -0.998428}},
    {"neutral",
     "left",
     {0, -0.55, 0, 0.75, 0, 1.26, 0},
     {0.646258, 0.84126, 0.062618},
     {-0.70277, -0.707108, 0.078184, -0.702772, 0.707105, 0.078185, -0.11057, 0.0, -0.993868}},
    {"neutral",
     "right",
     {0, -0.55, 0, 0.75, 0, 1.26, 0},
     {0.646258, -0.84126, 0.062618},
     {-0.70277, 0.707108, 0.078184, 0.702772, 0.707105, -0.078185, -0.11057, 0.0, -0.993868}},
}};

TEST(MobileBaxter, GrippersAreWhereTheyArePublished) {
  for (const ArmPose& pose : kPoses) {
    const auto poses = baxter().link_poses(positions(pose.side, pose.arm));
    const Pose gripper = relative(poses, "base", std::string(pose.side) + "_gripper");
    for (int row = 0; row < 3; ++row) {
      EXPECT_NEAR(gripper.translation()[row], pose.xyz[row], 1e-6) << pose.name << " " << pose.side;
      for (int column = 0; column < 3; ++column)
        EXPECT_NEAR(gripper.linear()(row, column), pose.rotation[3 * row + column], 1e-6) << pose.name;
    }
  }
}

/// Standard Denavit-Hartenberg step.
Pose dh(double a, double alpha, double d, double theta) {
  return make_pose({0, 0, d}, {0, 0, theta}) * make_pose({a, 0, 0}, {alpha, 0, 0});
}

TEST(MobileBaxter, ArmsFollowTheirDenavitHartenbergTable) {
  const Arm a{0.069, 0, 0.069, 0, 0.01, 0, 0};
  const Arm alpha{-M_PI_2, M_PI_2, -M_PI_2, M_PI_2, -M_PI_2, M_PI_2, 0};
  const Arm d{0.27035, 0, 0.36442, 0, 0.37429, 0, 0.229525};
  const Arm arm{0.3, -0.7, 1.1, 0.9, -0.4, 0.6, 1.3};
  Pose expected = Pose::Identity();
  for (std::size_t i = 0; i < arm.size(); ++i)
    expected = expected * dh(a[i], alpha[i], d[i], arm[i] + (i == 1 ? M_PI_2 : 0.0));
  for (const std::string side : {"left", "right"}) {
    const auto poses = baxter().link_poses(positions(side, arm));
    const Pose mount_T_hand = relative(poses, side + "_arm_mount", side + "_hand");
    const Pose start = make_pose({0.055695, 0, 0.011038});
    EXPECT_TRUE(mount_T_hand.isApprox(start * expected, 1e-9)) << side;
  }
}

TEST(MobileBaxter, ArmsHaveTheirPublishedLimits) {
  struct Limit {
    double lower, upper, velocity, effort;
  };
  const std::map<std::string, Limit> limits{
      {"s0", {-1.70167993878, 1.70167993878, 1.5, 50}},
      {"s1", {-2.147, 1.047, 1.5, 100}},  // published: 50, see docs/robot.md
      {"e0", {-3.05417993878, 3.05417993878, 1.5, 50}},
      {"e1", {-0.05, 2.618, 1.5, 50}},
      {"w0", {-3.059, 3.059, 4, 15}},
      {"w1", {-1.57079632679, 2.094, 4, 15}},
      {"w2", {-3.059, 3.059, 4, 15}}};
  for (const std::string side : {"left", "right"})
    for (const auto& [name, limit] : limits) {
      const Joint& found = joint(std::string(side).append("_").append(name));
      EXPECT_EQ(found.type, JointType::kRevolute);
      EXPECT_EQ(found.lower, limit.lower) << found.name;
      EXPECT_EQ(found.upper, limit.upper) << found.name;
      EXPECT_EQ(found.max_velocity, limit.velocity) << found.name;
      EXPECT_EQ(found.max_effort, limit.effort) << found.name;
    }
}

TEST(MobileBaxter, EveryPublishedPoseIsWithinTheLimits) {
  for (const ArmPose& pose : kPoses)
    for (std::size_t i = 0; i < pose.arm.size(); ++i) {
      const Joint& limit = joint(std::string(pose.side) + "_" + kJoints[i]);
      EXPECT_LE(limit.lower, pose.arm[i]) << pose.name << " " << limit.name;
      EXPECT_GE(limit.upper, pose.arm[i]) << pose.name << " " << limit.name;
    }
}

TEST(MobileBaxter, LinksComeAfterTheirParents) {
  EXPECT_EQ(baxter().links().front().name, "base_footprint");
  ASSERT_EQ(baxter().links().size(), baxter().joints().size() + 1);
  for (std::size_t i = 0; i < baxter().joints().size(); ++i) {
    EXPECT_EQ(baxter().joints()[i].child_link, static_cast<int>(i) + 1);
    EXPECT_LE(baxter().joints()[i].parent_link, static_cast<int>(i));
  }
}

TEST(MobileBaxter, StandsOnItsBase) {
  EXPECT_NEAR(at_rest("base_footprint", "base_link").translation().z(), 0.1016, 1e-12);
  EXPECT_NEAR(at_rest("base_footprint", "base").translation().z(), 0.6309, 1e-12);
  EXPECT_NEAR(at_rest("base_link", "velodyne").translation().z(), 0.2872, 1e-12);
  const std::map<std::string, Eigen::Vector2d> signs{
      {"front_left", {1, 1}}, {"front_right", {1, -1}}, {"rear_left", {-1, 1}}, {"rear_right", {-1, -1}}};
  for (const auto& [name, sign] : signs) {
    const Joint& wheel = joint("wheel_" + name + "_joint");
    EXPECT_EQ(wheel.type, JointType::kContinuous);
    EXPECT_EQ(wheel.axis, Eigen::Vector3d::UnitY()) << "positive is forward";
    const Eigen::Vector3d expected(0.25275 * sign.x(), 0.34025 * sign.y(), 0);
    EXPECT_TRUE(at_rest("base_link", "wheel_" + name).translation().isApprox(expected, 1e-12)) << name;
  }
}

TEST(MobileBaxter, EveryBodyHasARealInertia) {
  for (const Link& link : baxter().links()) {
    if (!link.inertial) continue;
    const Eigen::Vector3d i = link.inertial->inertia_kg_m2.selfadjointView<Eigen::Lower>().eigenvalues();
    EXPECT_GT(i.minCoeff(), 0) << link.name;
    EXPECT_LE(2 * i.maxCoeff(), i.sum() * (1 + 1e-9)) << link.name << ": no body has this one";
    EXPECT_LT(i.maxCoeff() / link.inertial->mass_kg, 0.2)
        << link.name << ": far larger than the robot's parts";
  }
}

/// Inner distance of a gripper's tips by their collision shapes.
double gap(const std::string& letter, double half_thickness, double finger) {
  std::vector<double> q(baxter().joints().size(), 0.0);
  q[baxter().joint(letter + "_gripper_l_finger_joint").value()] = finger;
  const auto poses = baxter().link_poses(q);
  const auto inner = [&](const std::string& name, double sign) {
    const int link = baxter().link(letter + "_gripper_" + name + "_finger_tip").value();
    const Pose shape = baxter().links()[link].collisions.at(0).body_T_shape;
    const std::string base = letter == "l" ? "left_gripper_base" : "right_gripper_base";
    return (relative(poses, base, baxter().links()[link].name) * shape).translation().y() -
           sign * half_thickness;
  };
  return inner("l", 1) - inner("r", -1);
}

TEST(MobileBaxter, GrippersOpenAsPublished) {
  EXPECT_NEAR(gap("l", 0.00325, 0.0), 0.0160, 1e-4);
  EXPECT_NEAR(gap("l", 0.00325, 0.020833), 0.0577, 1e-4);
  EXPECT_NEAR(gap("r", 0.008, 0.0), 0.0065, 1e-4);
  EXPECT_NEAR(gap("r", 0.008, 0.020833), 0.0482, 1e-4);
}

TEST(MobileBaxter, CameraSeesTheTable) {
  const Pose optical_T_foot = at_rest("camera_color_optical_frame", "base_footprint");
  EXPECT_NEAR(optical_T_foot.inverse().translation().z(), 1.5, 0.05);
  for (const double x : {0.55, 1.3})
    for (const double y : {-0.3, 0.0, 0.3}) {
      const Eigen::Vector3d p = optical_T_foot * Eigen::Vector3d(x, y, 0.62);
      EXPECT_GT(p.z(), 0.3) << "nearer than the depth camera measures";
      EXPECT_LT(std::abs(p.x() / p.z()), std::tan(27.5 * M_PI / 180))
          << x << " " << y;  // 4:3 part of 69 degrees
      EXPECT_LT(std::abs(p.y() / p.z()), std::tan(21.0 * M_PI / 180)) << x << " " << y;
    }
}

TEST(MobileBaxter, CameraFramesAreTheDrivers) {
  const Pose color_T_depth = at_rest("camera_color_optical_frame", "camera_depth_optical_frame");
  EXPECT_TRUE(color_T_depth.isApprox(make_pose({0.015, 0, 0}), 1e-9));
  EXPECT_TRUE(at_rest("camera_link", "camera_depth_optical_frame")
                  .linear()
                  .isApprox(make_pose({0, 0, 0}, {-M_PI_2, 0, -M_PI_2}).linear(), 1e-9));
}

/// Distance of a point from a shape; 0 inside [m].
double distance(const Geometry& geometry, const Eigen::Vector3d& p) {
  if (const auto* box = std::get_if<Box>(&geometry))
    return (p.cwiseAbs() - box->size_m / 2).cwiseMax(0.0).norm();
  if (const auto* sphere = std::get_if<Sphere>(&geometry)) return std::max(0.0, p.norm() - sphere->radius_m);
  const auto& cylinder = std::get<Cylinder>(geometry);
  return std::hypot(std::max(0.0, p.head<2>().norm() - cylinder.radius_m),
                    std::max(0.0, std::abs(p.z()) - cylinder.length_m / 2));
}

/// Least distance of a round part of an arm from some links.
double clearance(const Cylinder& part, const Pose& root_T_part, const std::vector<Pose>& poses,
                 const std::vector<std::string>& links) {
  double nearest = 10;
  for (const std::string& name : links) {
    const int link = baxter().link(name).value();
    for (const Shape& shape : baxter().links()[link].collisions)
      for (int step = -5; step <= 5; ++step) {
        const Eigen::Vector3d p = root_T_part * Eigen::Vector3d(0, 0, step * part.length_m / 10);
        nearest =
            std::min(nearest, distance(shape.geometry, (poses[link] * shape.body_T_shape).inverse() * p));
      }
  }
  return nearest - part.radius_m;
}

TEST(MobileBaxter, ArmsKeepClearOfTheBodyInEveryPublishedPose) {
  for (const ArmPose& pose : kPoses) {
    // A tucked arm enters the wide safety spheres about the head, as on the real robot, which therefore wants
    // its collision avoidance suppressed while it tucks.
    std::vector<std::string> body{"torso", "pedestal", "chassis", "birdcage"};
    if (std::string(pose.name) != "tuck")
      body.insert(body.end(), {"collision_head_link_1", "collision_head_link_2"});
    const auto poses = baxter().link_poses(positions(pose.side, pose.arm));
    for (const char* name : {"lower_shoulder", "upper_elbow", "upper_elbow_visual", "lower_elbow",
                             "upper_forearm", "upper_forearm_visual", "lower_forearm", "wrist", "hand"}) {
      const int link = baxter().link(std::string(pose.side) + "_" + name).value();
      for (const Shape& shape : baxter().links()[link].collisions)
        EXPECT_GT(
            clearance(std::get<Cylinder>(shape.geometry), poses[link] * shape.body_T_shape, poses, body),
            0.005)
            << pose.name << " " << pose.side << " " << name;
    }
  }
}

TEST(MobileBaxter, CollisionShapesArePrimitives) {
  for (const Link& link : baxter().links())
    for (const Shape& shape : link.collisions)
      EXPECT_FALSE(std::holds_alternative<TriangleMesh>(shape.geometry)) << link.name;
}

}  // namespace
}  // namespace extperfc
