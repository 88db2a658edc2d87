#include "test/unit/simulate/bodies/baxter_arm.hpp"

namespace extperfc::simulate {
namespace {

const int kFinger = joint_index("l_gripper_l_finger_joint");

/// Half of the chassis' length: where it meets a wall ahead.
double reach_forward(Bodies& bodies, double wall_m) {
  double low = 0;
  double high = wall_m;
  for (int i = 0; i < 30; ++i) {
    const double middle = 0.5 * (low + high);
    (bodies.root_collides(make_pose({middle, 0, 0})) ? high : low) = middle;
  }
  return wall_m - low;
}

TEST(Root, CollidesWithAWallAtTheChassisEdge) {
  WorldSpec world;
  world.bodies = {make_floor(),
                  body("wall", Mobility::kFixed, box_of(0.1, 6, 2.5), make_pose({3.05, 0, 1.25}))};
  const auto bodies = make_bodies(world, mobile_baxter(), untucked());
  EXPECT_FALSE(bodies->root_collides(Pose::Identity()));
  // 0.8128 m long, and 2 mm of overlap do not count.
  EXPECT_NEAR(reach_forward(*bodies, 3.0), 0.4064, 0.03);
  EXPECT_TRUE(bodies->root_collides(make_pose({3, 0, 0})));
  EXPECT_FALSE(bodies->root_collides(make_pose({5, 0, 0})));
}

TEST(Root, FloorSillsAndLooseObjectsDoNotCount) {
  WorldSpec world;
  world.bodies = {make_floor(), body("sill", Mobility::kFixed, box_of(0.1, 1, 0.02), make_pose({1, 0, 0.01})),
                  make_cube("cube", 0.05, {-1, 0, 0.025})};
  const auto bodies = make_bodies(world, mobile_baxter(), untucked());
  EXPECT_FALSE(bodies->root_collides(make_pose({1, 0, 0})));
  EXPECT_FALSE(bodies->root_collides(make_pose({-1, 0, 0})));
}

TEST(Root, CollidesWithPeopleAndMovableObjectsWhereTheyAreNow) {
  WorldSpec world;
  PersonSpec person;
  person.path_m = {{2, 0}};
  world.people = {person};
  world.bodies = {make_floor(), body("door", Mobility::kMovable, box_of(0.05, 0.9, 2), make_pose({0, 2, 1}))};
  const auto bodies = make_bodies(world, mobile_baxter(), untucked());
  EXPECT_TRUE(bodies->root_collides(make_pose({2, 0, 0})));
  EXPECT_TRUE(bodies->root_collides(make_pose({0, 2, 0})));
  ASSERT_TRUE(bodies->move_body(1, make_pose({5, 5, 1})));
  bodies->set_person(0, {-3, 0, 0});
  bodies->step();
  EXPECT_FALSE(bodies->root_collides(make_pose({2, 0, 0})));
  EXPECT_FALSE(bodies->root_collides(make_pose({0, 2, 0})));
  EXPECT_TRUE(bodies->root_collides(make_pose({-3, 0, 0})));
}

TEST(Root, ChassisPushesLooseObjects) {
  WorldSpec world;
  world.bodies = {make_floor(), make_cube("cube", 0.2, {0.8, 0, 0.1})};
  const auto bodies = make_bodies(world, mobile_baxter(), untucked());
  for (int i = 1; i <= 480; ++i) {
    bodies->set_root(make_pose({0.3 * i * kStep, 0, 0}));
    bodies->step();
  }
  const double ahead = bodies->world_T_body(1).translation().x() - 0.6;
  EXPECT_GT(ahead, 0.4);
  EXPECT_LT(ahead, 0.7);
}

class HeldCube : public ::testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    const Eigen::Vector3d cube(0.75, 0.3, 0.725);
    WorldSpec world;
    world.bodies = {make_floor(),
                    body("table", Mobility::kMovable, box_of(0.6, 1.2, 0.03), make_pose({0.9, 0.3, 0.685})),
                    make_cube("cube", 0.05, cube)};
    const auto at = reach("left", from_above(cube - Eigen::Vector3d(0, 0, 0.008)), untucked());
    bodies_ = make_bodies(world, mobile_baxter(), at, GetParam());
    auto closed = at;
    closed[kFinger] = 0;
    JointDriver driver(*bodies_, at);
    driver.move(closed, 0.3);
    driver.move(closed, 0.3);
    ASSERT_EQ(bodies_->gripped(kFinger), 2);
    ASSERT_TRUE(bodies_->move_body(1, make_pose({8, 8, 0.685})));
    hand_T_cube_ = hand_T_cube();
  }

  [[nodiscard]] Pose hand_T_cube() const {
    return bodies_->world_T_link(link_index("left_gripper")).inverse() * bodies_->world_T_body(2);
  }
  [[nodiscard]] double slip() const {
    return (hand_T_cube().translation() - hand_T_cube_.translation()).norm();
  }

  std::unique_ptr<Bodies> bodies_;
  Pose hand_T_cube_;
};

TEST_P(HeldCube, FollowsTheBase) {
  // A second of speeding up to 1 m/s and 1 rad/s, two of driving, one of braking.
  double speed = 0;
  Pose2 root;
  double worst = 0;
  for (int i = 0; i < 960; ++i) {
    speed += (i < 240 ? 1 : i < 720 ? 0 : -1) * kStep;
    root = advance(root, {speed, 0.3 * speed, speed}, kStep);
    bodies_->set_root(to_pose(root));
    bodies_->step();
    worst = std::max(worst, slip());
  }
  EXPECT_EQ(bodies_->gripped(kFinger), 2);
  EXPECT_LT(worst, 0.003);
  EXPECT_GT(std::hypot(root.x, root.y), 0.5);
}

TEST_P(HeldCube, ComesAlongWhenTheRobotIsPutElsewhere) {
  bodies_->set_root(make_pose({-4, 3, 0}, {0, 0, 2}));
  bodies_->step();
  EXPECT_LT(slip(), 0.001);
  step(*bodies_, 0.5);
  EXPECT_EQ(bodies_->gripped(kFinger), 2);
  EXPECT_LT(slip(), 0.001);
  EXPECT_LT(bodies_->world_T_body(2).translation().x(), -3);
}

INSTANTIATE_TEST_SUITE_P(Modes, HeldCube, ::testing::Bool(),
                         [](const auto& mode) { return mode.param ? "dynamic" : "kinematic"; });

}  // namespace
}  // namespace extperfc::simulate
