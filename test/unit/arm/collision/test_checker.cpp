// States: the spheres never call a state free that Bullet does not; the checker agrees with Bullet.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "arm/collision/checks.hpp"
#include "test/unit/arm/collision/baxter.hpp"
#include "test/unit/arm/collision/bullet_oracle.hpp"

namespace extperfc::arm {
namespace {

using test::baxter;

constexpr double kMillimetre = 1e-3;
constexpr double kDistanceError = 1e-5;  // of Bullet's GJK and EPA at round shapes [m]

Shape shape_of(const Geometry& geometry) {
  Shape shape;
  shape.geometry = geometry;
  return shape;
}

JointVector neutral(const CollisionModel& model) {
  JointVector state = JointVector::Zero(model.joint_count());
  for (int i = 0; i < model.joint_count(); ++i)
    for (const auto& named : test::baxter_srdf().states)
      if (const auto found = named.positions.find(model.joint_names()[i]); found != named.positions.end())
        state[i] = found->second;
  return state;
}

TEST(Checker, LinkPosesAreTheRobots) {
  const CollisionModel model = test::group_model("both_arms");
  Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const JointVector state = test::random_state(model.limits(), rng);
    std::vector<double> values(baxter().joints().size(), 0.0);
    for (int k = 0; k < model.joint_count(); ++k)
      values[baxter().joint(model.joint_names()[k]).value()] = state[k];
    const auto poses = baxter().link_poses(values);
    for (std::size_t k = 0; k < poses.size(); ++k)
      EXPECT_TRUE(model.link_pose(state, baxter().links()[k].name)->isApprox(poses[k], 1e-9));
  }
}

/// Returns how many states are free for the oracle.
int expect_agreement(const std::string& group, const CollisionWorld& world,
                     const std::vector<JointVector>& states) {
  const auto params = test::group_params(group);
  const auto model = CollisionModel::make(baxter(), params).value();
  CollisionChecker checker = CollisionChecker::make(model, world).value();
  CollisionChecker bullet = CollisionChecker::make(model, world, {1e-3, false}).value();
  test::BulletOracle oracle(baxter(), params, world);
  const auto spheres = checker.spheres_free(states);
  const auto both = checker.are_free(states);
  const auto exact = bullet.are_free(states);
  int unsafe = 0, sphere_unsafe = 0, different = 0, strict = 0, free = 0;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const bool collides = oracle.collides(states[i]);
    unsafe += both[i] && collides ? 1 : 0;
    sphere_unsafe += spheres[i] && !exact[i] ? 1 : 0;
    different += both[i] != exact[i] ? 1 : 0;
    strict += !both[i] && !collides ? 1 : 0;
    free += collides ? 0 : 1;
  }
  EXPECT_EQ(0, unsafe);
  EXPECT_EQ(0, sphere_unsafe);
  EXPECT_EQ(0, different);
  // The oracle's shapes lose up to 0.1 mm at their edges: grazing contacts that it misses are rare.
  EXPECT_LE(strict, 1 + static_cast<int>(states.size()) / 300);
  return free;
}

TEST(Checker, AgreesWithBulletInRandomWorlds) {
  Rng rng(7);
  int free = 0;
  for (int i = 0; i < 8; ++i) {
    const std::string group = i % 2 == 0 ? "both_arms" : "left_arm";
    const CollisionModel model = test::group_model(group);
    const CollisionWorld world = test::random_world(8, rng);
    std::vector<JointVector> states;
    for (int k = 0; k < 250; ++k) states.push_back(test::random_state(model.limits(), rng));
    free += expect_agreement(group, world, states);
  }
  EXPECT_GT(free, 100);  // else this test shows nothing
}

TEST(Checker, AgreesWithBulletWithThingsInTheHands) {
  Rng rng(8);
  CollisionWorld world = test::random_world(6, rng);
  for (int i = 0; i < 4; ++i)
    test::must(world.attach({"tool_" + std::to_string(i),
                             i % 2 == 0 ? "left_gripper" : "right_wrist",
                             {shape_of(test::random_geometry(i, rng))},
                             test::random_pose(rng, {-0.1, -0.1, 0}, {0.1, 0.1, 0.2}),
                             {"left_gripper_base", "left_hand", "l_gripper_l_finger", "l_gripper_r_finger",
                              "l_gripper_l_finger_tip", "l_gripper_r_finger_tip"}}));
  const CollisionModel model = test::group_model("both_arms");
  std::vector<JointVector> states;
  for (int k = 0; k < 600; ++k) states.push_back(test::random_state(model.limits(), rng));
  EXPECT_GT(expect_agreement("both_arms", world, states), 10);
}

TEST(Checker, EveryKernelIsOnTheSafeSide) {
  const CollisionModel model = test::group_model("both_arms");
  Rng rng(9);
  const CollisionWorld world = test::random_world(10, rng);
  const auto scene = make_scene(model.bodies(), world).value();
  const KernelTables tables(model.bodies(), scene);
  KernelMemory memory(tables.view());
  ExactPairs exact(scene);
  BodyPlacement placement;
  std::vector<KernelFunction> kernels{sphere_kernel(), sphere_kernel_generic};
  for (int batch = 0; batch < 100; ++batch) {
    std::vector<JointVector> states;
    for (int lane = 0; lane < kLanes; ++lane) {
      states.push_back(test::random_state(model.limits(), rng));
      for (int k = 0; k < model.joint_count(); ++k)
        memory.positions()[k * kLanes + lane] = static_cast<float>(states[lane][k]);
    }
    for (const auto kernel : kernels) {
      std::vector<unsigned> flagged(scene.pairs.size(), 0);
      const int flags = kernel(tables.view(), memory.positions(), nullptr, memory.scratch());
      for (int i = 0; i < flags; ++i)
        flagged[memory.scratch().flags[i].pair] |= memory.scratch().flags[i].lanes;
      for (int lane = 0; lane < kLanes; ++lane) {
        placement.set(model.bodies(), scene, states[lane].data());
        for (std::size_t pair = 0; pair < scene.pairs.size(); ++pair) {
          const int index = static_cast<int>(pair);
          if ((flagged[pair] >> lane & 1U) == 0 && exact.rough_bound(index, placement) <= 0) {
            EXPECT_GT(exact.separation(index, placement).gap_m, 0);
          }
        }
      }
    }
  }
}

/// A ball of 5 cm radius so that its surface is `gap` in front of link left_gripper, 1.8 mm less in front of
/// the fingers (nearer than any two links are in this position).
CollisionWorld ball_in_front(const CollisionModel& model, double gap) {
  const Pose gripper = *model.link_pose(neutral(model), "left_gripper");
  CollisionWorld world;
  Pose pose = Pose::Identity();
  pose.translation() = gripper * Eigen::Vector3d(0, 0, 0.05 + gap);
  test::must(world.add({"ball", {shape_of(Sphere{0.05})}, pose}));
  return world;
}

TEST(Checker, NamesTheContactAndMeasuresDistances) {
  const CollisionModel model = test::group_model("left_arm");
  const JointVector state = neutral(model);
  CollisionChecker near = CollisionChecker::make(model, ball_in_front(model, 0.005)).value();
  ASSERT_TRUE(near.is_free(state));
  EXPECT_FALSE(near.contact(state));
  const auto nearest = near.nearest(state);
  ASSERT_TRUE(nearest);
  CollisionChecker nearer = CollisionChecker::make(model, ball_in_front(model, 0.004)).value();
  EXPECT_LT(nearer.nearest(state)->distance_m, nearest->distance_m);
  CollisionChecker touching = CollisionChecker::make(model, ball_in_front(model, -0.03)).value();
  EXPECT_FALSE(touching.is_free(state));
  const auto contact = touching.contact(state);
  ASSERT_TRUE(contact);
  EXPECT_EQ("ball", contact->second);
  EXPECT_LT(contact->distance_m, 0);
  EXPECT_LT(touching.nearest(state)->distance_m, 0);
}

TEST(Checker, DistanceOfASphereFromALinkIsExact) {
  // A ball over the middle of the upper arm's cylinder: radius 0.06 m, axis along z of the link.
  const CollisionModel model = test::group_model("left_arm");
  const JointVector state = neutral(model);
  const Pose arm = *model.link_pose(state, "left_upper_elbow_visual");
  for (const double gap : {0.05, 0.001, -0.004}) {
    CollisionWorld world;
    Pose pose = Pose::Identity();
    pose.translation() = arm * Eigen::Vector3d(0.06 + 0.02 + gap, 0, 0.1365);
    test::must(world.add({"ball", {shape_of(Sphere{0.02})}, pose}));
    world.allow("ball", "left_upper_elbow");  // which stands nearer in places
    CollisionChecker checker = CollisionChecker::make(model, world).value();
    EXPECT_EQ(gap > 0, checker.is_free(state));
    if (gap < 0.01) {
      EXPECT_NEAR(gap, checker.nearest(state)->distance_m, kDistanceError);
    }
  }
}

TEST(Checker, PaddingKeepsDistance) {
  auto params = test::group_params("left_arm");
  const auto plain = CollisionModel::make(baxter(), params).value();
  const CollisionWorld world = ball_in_front(plain, 0.007);
  const JointVector state = neutral(plain);
  const double distance = CollisionChecker::make(plain, world).value().nearest(state)->distance_m;
  ASSERT_GT(distance, 2 * kMillimetre);
  for (const double extra : {-kMillimetre, kMillimetre}) {
    params.world_padding_m = distance + extra;
    const auto padded = CollisionModel::make(baxter(), params).value();
    CollisionChecker checker = CollisionChecker::make(padded, world).value();
    EXPECT_EQ(extra < 0, checker.is_free(state));
    EXPECT_NEAR(-extra, checker.nearest(state)->distance_m, kDistanceError);
  }
}

TEST(Checker, AttachedObjectsMoveAlongAndAllowedOnesMayTouch) {
  const CollisionModel model = test::group_model("left_arm");
  const JointVector state = neutral(model);
  CollisionWorld world = ball_in_front(model, 0.1);
  ASSERT_TRUE(CollisionChecker::make(model, world).value().is_free(state));
  AttachedObject rod{"rod", "left_gripper", {shape_of(Cylinder{0.01, 0.2})}, Pose::Identity(), {}};
  rod.link_T_object.translation().z() = 0.1;
  for (const char* link : {"left_gripper_base", "l_gripper_l_finger", "l_gripper_r_finger", "left_hand"})
    rod.touch_links.emplace_back(link);
  test::must(world.attach(rod));
  CollisionChecker checker = CollisionChecker::make(model, world).value();
  const auto contact = checker.contact(state);
  ASSERT_TRUE(contact);
  EXPECT_EQ("rod", contact->first);
  EXPECT_EQ("ball", contact->second);
  EXPECT_FALSE(checker.is_free(state));
  world.allow("rod", "ball");
  EXPECT_TRUE(CollisionChecker::make(model, world).value().is_free(state));
  EXPECT_TRUE(world.remove("rod"));
  EXPECT_FALSE(world.remove("rod"));
}

TEST(Checker, RefusesWhatMakesNoSense) {
  const CollisionModel model = test::group_model("left_arm");
  CollisionWorld world;
  EXPECT_FALSE(world.add({"", {shape_of(Sphere{1})}, Pose::Identity()}));
  EXPECT_FALSE(world.add({"none", {}, Pose::Identity()}));
  EXPECT_FALSE(world.add({"flat", {shape_of(Box{{1, 1, 0}})}, Pose::Identity()}));
  EXPECT_FALSE(world.add({"no mesh", {shape_of(TriangleMesh{"/nowhere.stl", {1, 1, 1}})}, Pose::Identity()}));
  EXPECT_FALSE(world.move("nothing", Pose::Identity()));
  test::must(world.add({"torso", {shape_of(Sphere{1})}, Pose::Identity()}));
  EXPECT_FALSE(CollisionChecker::make(model, world));
  world.clear();
  test::must(world.attach({"object", "no_link", {shape_of(Sphere{1})}, Pose::Identity(), {}}));
  EXPECT_FALSE(CollisionChecker::make(model, world));
  auto params = test::group_params("left_arm");
  params.joints.push_back(params.joints.front());
  EXPECT_FALSE(CollisionModel::make(baxter(), params));
  params.joints = {"left_hand"};
  EXPECT_FALSE(CollisionModel::make(baxter(), params));
  params.joints = {};
  EXPECT_FALSE(CollisionModel::make(baxter(), params));
}

TEST(Checker, AStateThatIsNotFiniteIsNotFree) {
  const CollisionModel model = test::group_model("left_arm");
  CollisionChecker checker = CollisionChecker::make(model, {}).value();
  JointVector state = neutral(model);
  ASSERT_TRUE(checker.is_free(state));
  state[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(checker.is_free(state));
  EXPECT_FALSE(checker.motion_free(neutral(model), state));
  EXPECT_THROW((void)checker.is_free(JointVector::Zero(3)), std::invalid_argument);
}

TEST(Checker, AngleOfManyRevolutionsIsTheSame) {
  const CollisionModel model = test::group_model("left_arm");
  Rng rng(11);
  CollisionChecker checker = CollisionChecker::make(model, test::random_world(8, rng)).value();
  for (int i = 0; i < 100; ++i) {
    const JointVector state = test::random_state(model.limits(), rng);
    JointVector rotated = state;
    rotated[i % 7] += 2 * 3.14159265358979323846 * rng.integer(-1000, 1000);
    EXPECT_EQ(checker.is_free(state), checker.is_free(rotated));
  }
}

}  // namespace
}  // namespace extperfc::arm
