// Choosing a grasp that an arm of Baxter reaches free of collisions.
#include <algorithm>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/arm/grasp_choice.hpp"
#include "extperfc/arm/srdf.hpp"

#include "test/unit/arm/grasping/hands.hpp"

namespace extperfc::arm::test {
namespace {

constexpr double kTable = 0.75;  // [m] above the root link, the floor's height

void must(const Result<void>& done) {
  if (!done) throw std::runtime_error(done.error().message);
}

Shape shape_of(const Geometry& geometry) {
  Shape shape;
  shape.geometry = geometry;
  return shape;
}

/// A table before the robot with one object on it, and both arms with open fingers.
class Scene {
 public:
  explicit Scene(const GraspObject& object) : object_(object) {
    must(world_.add({"table", {shape_of(Box{{0.8, 1.1, 0.04}})}, make_pose({1.0, 0, kTable - 0.02})}));
    must(world_.add({"object", {shape_of(object.geometry)}, object.root_T_object}));
    allow_grasp(world_, "object", left_hand());
    allow_grasp(world_, "object", right_hand());
    static const Srdf srdf =
        read_srdf(EXTPERFC_SOURCE_DIR "/config/robots/baxter/mobile_baxter.srdf").value();
    CollisionModelParams params;
    params.joints = joints_of_group(srdf, baxter(), "both_arms").value();
    params.allowed = allowed_pairs(srdf);
    params.fixed_positions = {{"l_gripper_l_finger_joint", 0.020833}, {"r_gripper_l_finger_joint", 0.020833}};
    model_ = CollisionModel::make(baxter(), params).value();
    for (const char* side : {"left", "right"})
      kinematics_.emplace_back(
          ArmChain::make(baxter(), baxter().links().front().name, std::string(side) + "_gripper").value());
  }

  CollisionWorld& world() { return world_; }

  std::vector<GraspArm> arms() {
    checker_.emplace(CollisionChecker::make(*model_, world_).value());
    JointVector state(14);
    state << 0, -0.55, 0, 0.75, 0, 1.26, 0, 0, -0.55, 0, 0.75, 0, 1.26, 0;  // neutral
    return {{"left", &kinematics_[0], &*checker_, state, nullptr, {}},
            {"right", &kinematics_[1], &*checker_, state, nullptr, {}}};
  }

  CollisionChecker& checker() { return *checker_; }

  [[nodiscard]] std::vector<GraspCandidate> grasps() const {
    return generate_grasps(left_hand(), object_).value();
  }

 private:
  GraspObject object_;
  CollisionWorld world_;
  std::optional<CollisionModel> model_;
  std::vector<InverseKinematics> kinematics_;
  std::optional<CollisionChecker> checker_;
};

GraspObject cube_at(const Eigen::Vector3d& place) {
  GraspObject cube;
  cube.geometry = Box{{0.04, 0.04, 0.04}};
  cube.root_T_object = make_pose(place + Eigen::Vector3d(0, 0, 0.02));
  cube.support_z_m = place.z();
  return cube;
}

/// Another posture for the same grasp: far from the one that is found from where the arm is.
JointVector other_posture(const GraspArm& arm, const JointVector& usual, const Pose& root_T_tip) {
  const auto& chain = arm.kinematics->chain();
  for (std::uint64_t seed = 1; seed < 200; ++seed) {
    IkOptions options;
    options.rng_seed = seed;
    options.timeout_s = 0.05;
    options.accept = [&](const JointVector& joints) {
      JointVector whole = arm.state;
      whole.head<7>() = joints;
      return (joints - usual).cwiseAbs().maxCoeff() > 0.5 && arm.checker->is_free(whole);
    };
    JointVector start = chain.mid_range();
    start[2] += std::sin(static_cast<double>(seed));
    const auto found = arm.kinematics->solve(root_T_tip, chain.clamp(start), options);
    if (found) return found->joints;
  }
  throw std::runtime_error("no other posture");
}

TEST(GraspChoice, StartsAreLookedFromFirst) {
  Scene scene(cube_at({0.85, 0.35, kTable}));
  auto arms = scene.arms();
  arms.resize(1);
  const auto grasps = scene.grasps();
  const auto usual = choose_grasp(grasps, arms);
  ASSERT_TRUE(usual) << usual.error().message;
  const std::vector<GraspCandidate> one{grasps[static_cast<std::size_t>(usual->candidate)]};
  const auto start = other_posture(arms[0], usual->grasp(), one[0].root_T_tip);
  arms[0].starts = {start};
  const auto chosen = choose_grasp(one, arms);
  ASSERT_TRUE(chosen) << chosen.error().message;
  EXPECT_LT((chosen->grasp() - start).cwiseAbs().maxCoeff(), 0.05);
  EXPECT_GT((chosen->grasp() - usual->grasp()).cwiseAbs().maxCoeff(), 0.4);
}

TEST(GraspChoice, AStartThatLeadsNowhereChangesNothing) {
  Scene scene(cube_at({0.85, 0.35, kTable}));
  auto arms = scene.arms();
  arms.resize(1);
  // Of no use to any way: it is refused whatever it is asked for first.
  int asked = 0;
  arms[0].straight = [&](std::size_t, const GraspCandidate&,
                         const JointVector& grasp) -> std::optional<StraightPaths> {
    if (++asked == 1) return std::nullopt;
    return StraightPaths{{grasp}, {}, {}};
  };
  arms[0].starts = {arms[0].kinematics->chain().mid_range()};
  EXPECT_TRUE(choose_grasp(scene.grasps(), arms));
  arms[0].starts = {JointVector::Zero(3)};
  EXPECT_THROW((void)choose_grasp(scene.grasps(), arms), std::invalid_argument);
}

TEST(GraspChoice, TheArmOnTheObjectsSideTakesIt) {
  for (const double side : {1.0, -1.0}) {
    Scene scene(cube_at({0.8, 0.35 * side, kTable}));
    const auto arms = scene.arms();
    const auto grasps = scene.grasps();
    const auto choice = choose_grasp(grasps, arms);
    ASSERT_TRUE(choice) << choice.error().message;
    EXPECT_EQ(choice->arm, side > 0 ? 0 : 1);
    const GraspCandidate& grasp = grasps[choice->candidate];
    const ArmChain& chain = arms[choice->arm].kinematics->chain();
    EXPECT_TRUE(chain.forward(choice->grasp()).isApprox(grasp.root_T_tip, 1e-4));
    EXPECT_TRUE(chain.forward(choice->pregrasp()).isApprox(grasp.root_T_pregrasp, 1e-4));
    // Straight: no point of the tip is off the line, ends and middles looked at, and all of it is free.
    for (std::size_t i = 1; i < choice->paths.approach.size(); ++i) {
      const JointVector middle = (choice->paths.approach[i - 1] + choice->paths.approach[i]) / 2;
      const Eigen::Vector3d off = chain.forward(middle).translation() - grasp.root_T_tip.translation();
      EXPECT_LT((off - off.dot(grasp.approach) * grasp.approach).norm(), 1e-3);
    }
    for (const JointVector& point : choice->paths.approach) {
      JointVector state = arms[0].state;
      state.segment(7 * choice->arm, 7) = point;
      EXPECT_FALSE(scene.checker().contact(state));
    }
  }
}

TEST(GraspChoice, SaysThatItIsOutOfReach) {
  Scene scene(cube_at({3.0, 0.35, kTable}));
  const auto choice = choose_grasp(scene.grasps(), scene.arms());
  ASSERT_FALSE(choice);
  const int tried = choice.error().tried;
  EXPECT_EQ(tried, static_cast<int>(scene.grasps().size()));
  EXPECT_EQ(choice.error().refusals[0][0], tried) << choice.error().message;
  EXPECT_NE(choice.error().message.find("out of reach"), std::string::npos);
}

TEST(GraspChoice, SaysThatSomethingIsInThePath) {
  Scene scene(cube_at({0.8, 0.35, kTable}));
  must(scene.world().add({"lid", {shape_of(Box{{0.5, 0.5, 0.02}})}, make_pose({0.8, 0.35, kTable + 0.07})}));
  for (const double side : {-1.0, 1.0}) {
    const std::string number = std::to_string(side);
    must(scene.world().add({"wall x " + number,
                            {shape_of(Box{{0.02, 0.5, 0.1}})},
                            make_pose({0.8 + 0.24 * side, 0.35, kTable + 0.05})}));
    must(scene.world().add({"wall y " + number,
                            {shape_of(Box{{0.5, 0.02, 0.1}})},
                            make_pose({0.8, 0.35 + 0.24 * side, kTable + 0.05})}));
  }
  auto grasps = scene.grasps();
  grasps.resize(12);
  GraspChoiceOptions options;
  options.timeout_s = 20;
  const auto choice = choose_grasp(grasps, scene.arms(), options);
  ASSERT_FALSE(choice);
  EXPECT_FALSE(choice.error().timed_out);
  EXPECT_GT(choice.error().refusals[0][static_cast<int>(GraspRefusal::kCollision)], 0)
      << choice.error().message;
  EXPECT_NE(choice.error().message.find(" touches "), std::string::npos) << choice.error().message;
}

TEST(GraspChoice, TheCallersStraightMotionIsAsked) {
  Scene scene(cube_at({0.8, 0.35, kTable}));
  auto arms = scene.arms();
  arms.resize(1);
  int asked = 0;
  arms[0].straight = [&](std::size_t, const GraspCandidate&, const JointVector&) {
    ++asked;
    return std::nullopt;
  };
  auto grasps = scene.grasps();
  grasps.resize(4);
  const auto choice = choose_grasp(grasps, arms);
  ASSERT_FALSE(choice);
  EXPECT_GT(asked, 0);
  EXPECT_GT(choice.error().refusals[0][static_cast<int>(GraspRefusal::kNoPath)], 0);
}

TEST(GraspChoice, EveryArmHasItsHandsGrasps) {
  // The left hand has none; of the right hand's, the first two are out of reach.
  Scene scene(cube_at({0.8, -0.45, kTable}));
  auto arms = scene.arms();
  auto right = scene.grasps();
  right.insert(right.begin(), 2, right.front());
  right[0].root_T_tip.translation().x() += 3;
  right[1].root_T_tip.translation().x() += 3;
  arms[1].grasps = &right;
  const std::vector<GraspCandidate> none;
  arms[0].grasps = &none;
  const auto choice = choose_grasp({}, arms);
  ASSERT_TRUE(choice) << choice.error().message;
  EXPECT_EQ(choice->arm, 1);
  EXPECT_EQ(choice->candidate, 2);
  EXPECT_EQ(choice->tried, 3);
}

TEST(GraspChoice, AGripperWithRoomToSpareTakesIt) {
  Scene scene(cube_at({0.75, 0.05, kTable}));
  auto arms = scene.arms();
  const auto grasps = scene.grasps();
  const auto reached_by_both = std::find_if(grasps.begin(), grasps.end(), [&](const GraspCandidate& grasp) {
    return choose_grasp({grasp}, {arms[0]}) && choose_grasp({grasp}, {arms[1]});
  });
  ASSERT_NE(reached_by_both, grasps.end());
  std::vector<GraspCandidate> wide{*reached_by_both}, tight = wide;
  wide[0].spare_m = 0.01;
  tight[0].spare_m = 0.001;
  for (const int roomy : {0, 1}) {
    arms[roomy].grasps = &wide;
    arms[1 - roomy].grasps = &tight;
    const auto choice = choose_grasp({}, arms);
    ASSERT_TRUE(choice) << choice.error().message;
    EXPECT_EQ(choice->arm, roomy);
  }
}

TEST(GraspChoice, StopsWhenCancelled) {
  Scene scene(cube_at({0.8, 0.35, kTable}));
  GraspChoiceOptions options;
  options.cancelled = [] { return true; };
  const auto choice = choose_grasp(scene.grasps(), scene.arms(), options);
  ASSERT_FALSE(choice);
  EXPECT_TRUE(choice.error().timed_out);
  EXPECT_EQ(choice.error().tried, 0);
}

TEST(GraspChoice, RefusesArmsThatDoNotFit) {
  Scene scene(cube_at({0.8, 0.35, kTable}));
  auto arms = scene.arms();
  arms[0].state.conservativeResize(7);
  EXPECT_THROW((void)choose_grasp({}, arms), std::invalid_argument);
  arms[0].checker = nullptr;
  EXPECT_THROW((void)choose_grasp({}, arms), std::invalid_argument);
  EXPECT_THROW((void)choose_grasp({}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace extperfc::arm::test
