#include <numeric>

#include "simulate/bodies/collision_shapes.hpp"
#include "simulate/bodies/rigid_tree.hpp"
#include "test/unit/simulate/bodies/baxter_arm.hpp"

namespace extperfc::simulate {
namespace {

TEST(RigidTree, MergesWhatDoesNotMove) {
  const RigidTree tree = make_rigid_tree(mobile_baxter());
  // Root, head, seven links and two fingers of each arm.
  EXPECT_EQ(tree.groups.size(), 20);
  EXPECT_EQ(tree.group_of_link[link_index("torso")], 0);
  EXPECT_EQ(tree.group_of_link[link_index("wheel_rear_left")], 0);
  EXPECT_EQ(tree.group_of_link[link_index("left_gripper_base")],
            tree.group_of_link[link_index("left_wrist")]);
  double all = 0;
  for (const Link& link : mobile_baxter().links()) all += link.inertial ? link.inertial->mass_kg : 0;
  double merged = 0;
  for (const RigidGroup& group : tree.groups) merged += group.mass.mass_kg;
  EXPECT_NEAR(merged, all, 1e-9);
}

TEST(RigidTree, FindsGrippersAndTheWayTheyClose) {
  const RigidTree tree = make_rigid_tree(mobile_baxter());
  const auto grippers = find_grippers(mobile_baxter(), tree);
  ASSERT_EQ(grippers.size(), 2);
  for (const auto& gripper : grippers) {
    EXPECT_EQ(gripper.closing, -1) << "a finger's travel grows when it opens";
    EXPECT_EQ(tree.groups[gripper.finger].parent, gripper.hand);
    EXPECT_NE(gripper.finger, gripper.mimic_finger);
  }
}

/// Potential energy of the robot [J].
double potential(const std::vector<double>& positions) {
  const auto poses = mobile_baxter().link_poses(positions);
  double energy = 0;
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (const auto& inertial = mobile_baxter().links()[i].inertial)
      energy += 9.81 * inertial->mass_kg * (poses[i] * inertial->link_T_com.translation()).z();
  return energy;
}

TEST(GravityEfforts, AreTheSlopeOfThePotential) {
  const RigidTree tree = make_rigid_tree(mobile_baxter());
  const auto positions = reach("left", from_above({0.7, 0.4, 0.9}), untucked());
  const auto efforts = gravity_efforts(mobile_baxter(), tree, mobile_baxter().link_poses(positions), 9.81);
  for (const char* side : {"left", "right"})
    for (const int joint : arm_joints(side)) {
      auto up = positions;
      auto down = positions;
      up[joint] += 1e-5;
      down[joint] -= 1e-5;
      EXPECT_NEAR(efforts[joint], (potential(up) - potential(down)) / 2e-5, 1e-5)
          << mobile_baxter().joints()[joint].name;
    }
}

TEST(MassProperties, OfACombinedBoxAreThoseOfTheWhole) {
  const Shape left = shape_of(box_of(0.1, 0.2, 0.3), make_pose({-0.05, 0, 0}));
  const Shape right = shape_of(box_of(0.1, 0.2, 0.3), make_pose({0.05, 0, 0}));
  const auto halves = solid_mass_properties({left, right}, 2.0);
  const auto whole = solid_mass_properties({shape_of(box_of(0.2, 0.2, 0.3))}, 2.0);
  EXPECT_NEAR((halves.inertia_kg_m2 - whole.inertia_kg_m2).norm(), 0, 1e-12);
  EXPECT_NEAR(halves.com.norm(), 0, 1e-12);
  // m (b^2 + c^2) / 12
  EXPECT_NEAR(whole.inertia_kg_m2(0, 0), 2.0 / 12 * (0.04 + 0.09), 1e-12);
}

TEST(MassProperties, PrincipalFrameOfATurnedBox) {
  const Pose rotation = make_pose({0.1, 0.2, 0.3}, {0.4, 0.5, 0.6});
  const auto properties = solid_mass_properties({shape_of(box_of(0.1, 0.2, 0.3), rotation)}, 1.0);
  const auto frame = principal_frame(properties);
  EXPECT_LT((frame.frame_T_principal.translation() - rotation.translation()).norm(), 1e-12);
  EXPECT_NEAR(frame.frame_T_principal.linear().determinant(), 1, 1e-12);
  const Eigen::Matrix3d back = frame.frame_T_principal.linear() * frame.moments_kg_m2.asDiagonal() *
                               frame.frame_T_principal.linear().transpose();
  EXPECT_LT((back - properties.inertia_kg_m2).norm(), 1e-12);
}

TEST(MassProperties, ConesAreHeavyBelow) {
  const auto cone = solid_mass_properties({shape_of(Cone{0.03, 0.08})}, 0.1);
  EXPECT_NEAR(cone.com.z(), -0.02, 1e-12);
}

}  // namespace
}  // namespace extperfc::simulate
