// Planning to pick an object from a table with Baxter's left arm, and to place it there.
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/arm/pick_and_place.hpp"

#include "test/unit/arm/motion/baxter_arms.hpp"

namespace extperfc::arm::test {
namespace {

constexpr double kTable = 0.75;  // [m] above the root link, the floor's height
constexpr double kCube = 0.04;
constexpr double kLift = 0.1;

const Manipulator& left() {
  static const Manipulator manipulator =
      Manipulator::make(baxter_arms(), "left", "left_arm", "left_gripper", "l_gripper_l_finger_joint")
          .value();
  return manipulator;
}

/// The cube stands with its middle half an edge above.
Pose on_table(double x, double y) {
  return make_pose({x, y, kTable + kCube / 2});
}

WorldObject box(const std::string& name, const Eigen::Vector3d& size_m, const Pose& root_T_object) {
  WorldObject object{name, std::vector<Shape>(1), root_T_object};
  object.shapes[0].geometry = Box{size_m};
  return object;
}

WorldObject cube(const Pose& root_T_object) {
  return box("cube", {kCube, kCube, kCube}, root_T_object);
}

template <typename Added>
void must(const Added& added) {
  if (!added) throw std::runtime_error(added.error().message);
}

class PickAndPlace : public testing::Test {
 protected:
  void add(const WorldObject& object) { must(world_.add(object)); }

  [[nodiscard]] PickTask pick(const WorldObject& object) {
    add(object);
    PickTask task;
    task.start = standing("neutral");
    task.manipulators = {&left()};
    task.objects = {object};
    task.grasp.lift_m = kLift;
    return task;
  }

  /// The cube is held from above, in the middle between the fingers.
  [[nodiscard]] PlaceTask place(const Pose& root_T_place) {
    PlaceTask task;
    task.start = standing("neutral");
    task.manipulator = &left();
    task.object = {"cube", "left_gripper", cube(Pose::Identity()).shapes,
                   make_pose({0, 0, 0.0}, {3.14159265358979, 0, 0}), left().hand.finger_links};
    task.place.root_T_places = {root_T_place};
    must(world_.attach(task.object));
    return task;
  }

  /// Every waypoint is free and within 1 mm of the line from the first tip position to the last.
  void expect_straight_and_free(const std::vector<JointVector>& path, const CollisionWorld& world) {
    auto checker = pipeline_.checker("left_arm", standing("neutral"), world, false).value();
    const auto& chain = left().kinematics.chain();
    const Eigen::Vector3d from = chain.forward(path.front()).translation();
    const Eigen::Vector3d along = (chain.forward(path.back()).translation() - from).normalized();
    for (const auto& joints : path) {
      const Eigen::Vector3d off = chain.forward(joints).translation() - from;
      EXPECT_LT((off - off.dot(along) * along).norm(), 1e-3);
      EXPECT_FALSE(checker.contact(joints));
    }
  }

  MotionPipeline pipeline_{baxter_arms(), {}};
  CollisionWorld world_{table_world(kTable)};
};

TEST_F(PickAndPlace, AReachableGraspHasAnApproachAndALift) {
  const auto plan = plan_pick(pipeline_, pick(cube(on_table(0.8, 0.35))), world_);
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_EQ(plan->manipulator, &left());
  EXPECT_EQ(plan->object.name, "cube");
  EXPECT_GE(plan->tried, 1);
  const auto& chain = left().kinematics.chain();
  const auto& [approach, lift, placed] = plan->paths;
  EXPECT_TRUE(chain.forward(approach.front()).isApprox(plan->grasp.root_T_pregrasp, 1e-3));
  EXPECT_TRUE(chain.forward(approach.back()).isApprox(plan->grasp.root_T_tip, 1e-3));
  EXPECT_TRUE(lift.front() == approach.back());
  const Eigen::Vector3d rise =
      chain.forward(lift.back()).translation() - chain.forward(lift.front()).translation();
  EXPECT_LT((rise - Eigen::Vector3d(0, 0, kLift)).norm(), 1e-3);
  EXPECT_EQ(placed.size(), 0);
  auto touching = world_;
  allow_grasp(touching, "cube", left().hand);
  expect_straight_and_free(approach, touching);
  expect_straight_and_free(lift, touching);
}

TEST_F(PickAndPlace, TheFirstObjectThatCanBeGraspedIsTaken) {
  auto task = pick(cube(on_table(0.8, 0.35)));
  auto far = box("far cube", {kCube, kCube, kCube}, make_pose({3, 0.35, kTable}));
  add(far);
  task.objects.insert(task.objects.begin(), far);
  const auto plan = plan_pick(pipeline_, task, world_);
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_EQ(plan->object.name, "cube");
}

TEST_F(PickAndPlace, SaysWhyNoGraspIsReachable) {
  const auto plan = plan_pick(pipeline_, pick(cube(on_table(3.0, 0.35))), world_);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().code, ArmCode::kNoGrasp);
  EXPECT_EQ(plan.error().message.find("cube: none of "), 0U) << plan.error().message;
  EXPECT_NE(plan.error().message.find("left: "), std::string::npos) << plan.error().message;
  EXPECT_NE(plan.error().message.find(" out of reach"), std::string::npos) << plan.error().message;
}

TEST_F(PickAndPlace, SaysWhyAnObjectCannotBeGrasped) {
  const auto wide = plan_pick(pipeline_, pick(box("wide", {0.2, 0.2, 0.2}, on_table(0.8, 0.35))), world_);
  ASSERT_FALSE(wide);
  EXPECT_EQ(wide.error().code, ArmCode::kNoGrasp);
  EXPECT_EQ(wide.error().message.find("wide: left: no grasp: too wide"), 0U) << wide.error().message;
  auto two = cube(on_table(0.8, -0.35));
  two.shapes.push_back(two.shapes.front());
  const auto plan = plan_pick(pipeline_, pick(two), world_);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().message, "cube has 2 shapes: only objects of one shape can be grasped");
}

TEST_F(PickAndPlace, AGraspForALaterPlace) {
  auto task = pick(cube(on_table(0.8, 0.35)));
  task.place.root_T_places = {on_table(4.0, 0.0), on_table(0.75, 0.2)};
  task.place.any_yaw = true;
  const auto plan = plan_pick(pipeline_, task, world_);
  ASSERT_TRUE(plan) << plan.error().message;
  const Pose root_T_object = left().kinematics.chain().forward(plan->paths.place) * plan->grasp.tip_T_object;
  EXPECT_LT((root_T_object.translation() - on_table(0.75, 0.2).translation()).norm(), 2e-3);
  task.place.root_T_places.pop_back();
  task.attempt_time_s = 2;
  const auto none = plan_pick(pipeline_, task, world_);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ArmCode::kNoGrasp);
  EXPECT_NE(none.error().message.find("the required place restricts the grasps"), std::string::npos);
}

TEST_F(PickAndPlace, AFreePlaceHasADescentAndARetreat) {
  const auto task = place(on_table(0.8, 0.35));
  const auto plan = plan_place(pipeline_, task, world_);
  ASSERT_TRUE(plan) << plan.error().message;
  const auto& chain = left().kinematics.chain();
  const auto& [down, back, unused] = plan->paths;
  EXPECT_TRUE(chain.forward(down.front()).isApprox(plan->candidate.root_T_above, 1e-3));
  EXPECT_TRUE(chain.forward(down.back()).isApprox(plan->candidate.root_T_tip, 1e-3));
  EXPECT_TRUE((chain.forward(down.back()) * task.object.link_T_object).isApprox(on_table(0.8, 0.35), 1e-3));
  EXPECT_TRUE(back.front() == down.back());
  EXPECT_TRUE(chain.forward(back.back()).isApprox(plan->candidate.root_T_retreat, 1e-3));
  auto standing = world_;
  allow_support(standing, "cube", task.object.shapes, on_table(0.8, 0.35));
  expect_straight_and_free(down, standing);
  standing.remove("cube");
  expect_straight_and_free(back, standing);
  EXPECT_TRUE(plan->clear);
}

TEST_F(PickAndPlace, FingersThatStayBesideThePlacedObjectMustNotClose) {
  auto task = place(on_table(0.8, 0.35));
  task.place.retreat_m = 0.01;
  const auto plan = plan_place(pipeline_, task, world_);
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_FALSE(plan->clear);
}

TEST_F(PickAndPlace, SaysWhyAPlaceIsTaken) {
  auto task = place(on_table(0.8, 0.35));
  add(box("crate", {0.1, 0.1, 0.1}, make_pose({0.8, 0.35, kTable + 0.05})));
  task.thorough = false;
  const auto plan = plan_place(pipeline_, task, world_);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().code, ArmCode::kGoalUnreachable);
  EXPECT_EQ(plan.error().message.find("cannot place cube there: none of "), 0U) << plan.error().message;
  EXPECT_NE(plan.error().message.find(" in collision"), std::string::npos) << plan.error().message;
  // With another place to go to it goes there.
  task.place.root_T_places.push_back(on_table(0.75, 0.1));
  const auto other = plan_place(pipeline_, task, world_);
  ASSERT_TRUE(other) << other.error().message;
  EXPECT_TRUE(other->candidate.root_T_object.isApprox(on_table(0.75, 0.1), 1e-6));
}

TEST_F(PickAndPlace, StopsWhenCancelled) {
  auto picking = pick(cube(on_table(0.8, 0.35)));
  picking.cancelled = [] { return true; };
  const auto plan = plan_pick(pipeline_, picking, world_);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().code, ArmCode::kCancelled);
  world_.remove("cube");
  auto placing = place(on_table(0.8, 0.35));
  placing.cancelled = [] { return true; };
  const auto placed = plan_place(pipeline_, placing, world_);
  ASSERT_FALSE(placed);
  EXPECT_EQ(placed.error().code, ArmCode::kCancelled);
}

TEST_F(PickAndPlace, AJointWithoutAPositionIsAnError) {
  auto task = pick(cube(on_table(0.8, 0.35)));
  task.start.erase("left_w1");
  const auto plan = plan_pick(pipeline_, task, world_);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().code, ArmCode::kNoJointStates);
  EXPECT_NE(plan.error().message.find("left_w1"), std::string::npos) << plan.error().message;
}

TEST_F(PickAndPlace, OnlyWhatEndsBelowSupportsAnObject) {
  add(box("shelf", {0.8, 1.1, 0.02}, make_pose({1.0, 0, kTable + 0.3})));
  add(box("neighbour", {0.1, 0.1, 0.1}, make_pose({0.8, 0.2, kTable + 0.05})));
  auto world = world_;
  const auto object = cube(on_table(0.8, 0.35));
  allow_support(world, "cube", object.shapes, object.root_T_object);
  EXPECT_TRUE(world.allowed().allows("cube", "table"));
  EXPECT_FALSE(world.allowed().allows("cube", "shelf"));
  EXPECT_FALSE(world.allowed().allows("cube", "neighbour"));
}

TEST(Manipulator, NamesWhatTheRobotLacks) {
  const auto group = Manipulator::make(baxter_arms(), "left", "tail", "left_gripper", "");
  ASSERT_FALSE(group);
  EXPECT_NE(group.error().message.find("tail"), std::string::npos);
  const auto link =
      Manipulator::make(baxter_arms(), "left", "left_arm", "no_link", "l_gripper_l_finger_joint");
  ASSERT_FALSE(link);
  EXPECT_NE(link.error().message.find("no_link"), std::string::npos);
}

}  // namespace
}  // namespace extperfc::arm::test
