#include "test/unit/simulate/bodies/baxter_arm.hpp"

namespace extperfc::simulate {
namespace {

constexpr double kTop = 0.70;  // of the table [m]

/// An object, the side that takes it, and how far above its origin the tips' frame goes.
struct Case {
  const char* name;
  Geometry geometry;
  double height_m;  // of its origin above the table
  double tip_m;
  const char* side;
  bool dynamic;
};

class ShapesGrasped : public ::testing::TestWithParam<Case> {};

TEST_P(ShapesGrasped, AreLiftedAndPutDown) {
  const Case& c = GetParam();
  const bool left = std::string(c.side) == "left";
  const int finger = joint_index(left ? "l_gripper_l_finger_joint" : "r_gripper_l_finger_joint");
  const Eigen::Vector3d place(0.75, left ? 0.3 : -0.3, kTop + c.height_m);
  WorldSpec world;
  world.bodies = {make_floor(),
                  body("table", Mobility::kFixed, box_of(0.6, 1.6, 0.03), make_pose({0.9, 0, kTop - 0.015})),
                  body("object", Mobility::kLoose, c.geometry, make_pose(place), 0.1)};
  const auto at = reach(c.side, from_above(place + Eigen::Vector3d(0, 0, c.tip_m)), untucked());
  auto lifted = reach(c.side, from_above(place + Eigen::Vector3d(0, 0, c.tip_m + 0.2)), at);
  const auto bodies = make_bodies(world, mobile_baxter(), at, c.dynamic);
  JointDriver driver(*bodies, at);
  auto closed = at;
  closed[finger] = lifted[finger] = 0;
  driver.move(at, 0.2);
  driver.move(closed, 0.5);
  driver.move(closed, 0.4);
  ASSERT_EQ(bodies->gripped(finger), 2);
  EXPECT_GT(bodies->position(finger), 0.001);
  const double start = bodies->world_T_body(2).translation().z();
  driver.move(lifted, 1);
  driver.move(lifted, 0.5);
  EXPECT_NEAR(bodies->world_T_body(2).translation().z(), start + 0.2, 0.002);
  driver.move(closed, 1);
  driver.move(at, 0.3);
  driver.move(at, 1);
  EXPECT_FALSE(bodies->gripped(finger));
  EXPECT_NEAR(bodies->world_T_body(2).translation().z(), place.z(), 0.002);
  EXPECT_LT((bodies->world_T_body(2).translation() - place).norm(), 0.03);
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const bool dynamic : {false, true})
    for (const char* side : {"left", "right"}) {
      const bool wide = std::string(side) == "left";
      const double edge = wide ? 0.05 : 0.04;
      all.push_back({"cube", box_of(edge, edge, edge), edge / 2, -0.005, side, dynamic});
      all.push_back({"ball", Sphere{edge / 2}, edge / 2, -0.012, side, dynamic});
      all.push_back({"cone", Cone{0.03, 0.08}, 0.04, -0.01, side, dynamic});
      all.push_back({"can", Cylinder{0.02, 0.08}, 0.04, -0.01, side, dynamic});
    }
  return all;
}

INSTANTIATE_TEST_SUITE_P(All, ShapesGrasped, ::testing::ValuesIn(cases()), [](const auto& test) {
  return std::string(test.param.name) + "_" + test.param.side +
         (test.param.dynamic ? "_dynamic" : "_kinematic");
});

}  // namespace
}  // namespace extperfc::simulate
