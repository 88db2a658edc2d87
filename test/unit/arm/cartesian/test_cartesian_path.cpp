// Straight paths, judged by forward kinematics and Bullet on a fine grid between the waypoints.
#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "extperfc/arm/cartesian_path.hpp"

#include "test/unit/arm/collision/baxter.hpp"
#include "test/unit/arm/planning/planar_arm.hpp"

namespace extperfc::arm {
namespace {

ArmChain left_chain() {
  return ArmChain::make(test::baxter(), "base", "left_gripper").value();
}

/// The elbow well bent: the tool may go some decimetres anywhere.
JointVector bent() {
  JointVector state(7);
  state << 0.0, -1.0, 0.0, 1.9, 0.0, 0.67, 0.0;
  return state;
}

Pose shifted(const Pose& pose, const Eigen::Vector3d& by) {
  Pose result = pose;
  result.translation() += by;
  return result;
}

double angle_between(const Pose& a, const Pose& b) {
  return 2 * std::asin(std::min(1.0, (a.linear() - b.linear()).norm() / std::sqrt(8.0)));
}

/// Largest distance of the tip from the line a-b, and angle from the orientation of the line's nearest place.
/// The line is looked at every ten-thousandth.
struct Deviation {
  double position_m{0};
  double angle_rad{0};
};
Deviation deviation(const ArmChain& chain, const std::vector<JointVector>& path, const Pose& a,
                    const Pose& b) {
  Deviation worst;
  const Eigen::Vector3d delta = b.translation() - a.translation();
  const Eigen::Quaterniond from(a.linear()), to(b.linear());
  for (std::size_t i = 1; i < path.size(); ++i)
    for (int k = 0; k <= 20; ++k) {
      const Pose tip = chain.forward(path[i - 1] + k / 20.0 * (path[i] - path[i - 1]));
      const double ratio =
          std::clamp(delta.dot(tip.translation() - a.translation()) / delta.squaredNorm(), 0.0, 1.0);
      worst.position_m =
          std::max(worst.position_m, (a.translation() + ratio * delta - tip.translation()).norm());
      Pose place = Pose::Identity();
      place.linear() = from.slerp(ratio, to).toRotationMatrix();
      worst.angle_rad = std::max(worst.angle_rad, angle_between(tip, place));
    }
  return worst;
}

/// What must hold of every result.
void judge(const CartesianResult& result, CollisionChecker& checker) {
  ASSERT_EQ(result.waypoints.size(), result.progress.size());
  ASSERT_FALSE(result.waypoints.empty());
  EXPECT_TRUE(std::is_sorted(result.progress.begin(), result.progress.end()));
  EXPECT_NEAR(result.progress.back(), result.fraction, 1e-9);
  const auto& limits = checker.model().limits();
  for (const auto& state : result.waypoints) {
    EXPECT_LE((state - limits.upper).maxCoeff(), 0.0);
    EXPECT_LE((limits.lower - state).maxCoeff(), 0.0);
  }
  for (std::size_t i = 1; i < result.waypoints.size(); ++i)
    EXPECT_LE((result.waypoints[i] - result.waypoints[i - 1]).cwiseAbs().maxCoeff(), 0.2);
  EXPECT_TRUE(free_all_along(checker, result.waypoints));
}

TEST(CartesianPath, KeepsTheLineAndRotatesEvenly) {
  const ArmChain chain = left_chain();
  auto checker = CollisionChecker::make(test::group_model("both_arms"), {}).value();
  auto planner = CartesianPlanner::make(checker, chain).value();
  JointVector start(14);
  start << bent(), -bent()[0], bent().tail(6);
  const Pose a = chain.forward(bent());
  for (const bool rotated : {false, true}) {
    Pose b = shifted(a, {-0.05, 0.1, -0.1});
    if (rotated)
      b.linear() = b.linear() * Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
    const auto result = planner.plan({start, {b}, {}});
    ASSERT_EQ(result.end, CartesianEnd::kComplete) << result.message;
    EXPECT_EQ(result.fraction, 1.0);
    judge(result, checker);
    std::vector<JointVector> arm;
    for (const auto& state : result.waypoints) {
      arm.push_back(state.head(7));
      EXPECT_EQ(state.tail(7), start.tail(7)) << "the other arm stands";
    }
    const auto worst = deviation(chain, arm, a, b);
    EXPECT_LE(worst.position_m, 1e-4);
    EXPECT_LE(worst.angle_rad, 1e-3);
    EXPECT_LT((chain.forward(arm.back()).translation() - b.translation()).norm(), 1e-7);
    EXPECT_LT(angle_between(chain.forward(arm.back()), b), 1e-6);
  }
}

TEST(CartesianPath, RandomLinesKeepTheirToleranceAndAreFree) {
  const ArmChain chain = left_chain();
  Rng rng(11);
  int complete = 0;
  int begun = 0;
  for (int i = 0; i < 60; ++i) {
    auto checker = CollisionChecker::make(test::group_model("left_arm"), test::random_world(6, rng)).value();
    CartesianParams params;
    params.position_tolerance_m = i % 2 == 0 ? 1e-4 : 2e-3;
    params.orientation_tolerance_rad = i % 2 == 0 ? 1e-3 : 2e-2;
    auto planner = CartesianPlanner::make(checker, chain, params).value();
    const JointVector start = test::random_state(checker.model().limits(), rng);
    if (!checker.is_free(start)) continue;
    const Pose a = chain.forward(start);
    Pose b = shifted(a, {rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3)});
    b.linear() = b.linear() * Eigen::AngleAxisd(rng.uniform(-1, 1), Eigen::Vector3d::UnitX()).matrix();
    const auto result = planner.plan({start, {b}, {}});
    judge(result, checker);
    const auto worst = deviation(chain, result.waypoints, a, b);
    EXPECT_LE(worst.position_m, params.position_tolerance_m) << "line " << i;
    EXPECT_LE(worst.angle_rad, params.orientation_tolerance_rad) << "line " << i;
    EXPECT_EQ(result.message.empty(), result.end == CartesianEnd::kComplete);
    ++begun;
    complete += result.end == CartesianEnd::kComplete ? 1 : 0;
  }
  EXPECT_GT(begun, 20);
  EXPECT_GT(complete, 5);
}

TEST(CartesianPath, SeveralPosesAreAllPassed) {
  const ArmChain chain = left_chain();
  auto checker = CollisionChecker::make(test::group_model("left_arm"), {}).value();
  auto planner = CartesianPlanner::make(checker, chain).value();
  const Pose a = chain.forward(bent());
  const std::vector<Pose> poses{shifted(a, {0, 0.1, 0}), shifted(a, {0, 0.1, -0.1}), shifted(a, {0, 0, -0.1}),
                                a};
  const auto result = planner.plan({bent(), poses, {}});
  ASSERT_EQ(result.end, CartesianEnd::kComplete) << result.message;
  judge(result, checker);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    double nearest = 1;
    for (const auto& state : result.waypoints)
      nearest = std::min(nearest, (chain.forward(state).matrix() - poses[i].matrix()).norm());
    EXPECT_LT(nearest, 1e-6) << "pose " << i;
  }
  const auto again = planner.plan({bent(), poses, {}});
  EXPECT_EQ(again.waypoints, result.waypoints);
}

TEST(CartesianPath, EndsBeforeAnObstacleAndNamesIt) {
  const ArmChain chain = left_chain();
  const CollisionModel model = test::group_model("left_arm");
  WorldObject wall{"wall", {Shape{Box{{2.0, 0.02, 2.0}}, Pose::Identity(), {}}}, Pose::Identity()};
  wall.root_T_object.translation() =
      model.link_pose(bent(), "left_gripper").value().translation() + Eigen::Vector3d(0, 0.3, 0);
  CollisionWorld world;
  test::must(world.add(wall));
  auto checker = CollisionChecker::make(model, world).value();
  auto planner = CartesianPlanner::make(checker, chain).value();
  ASSERT_TRUE(checker.is_free(bent()));
  const Pose a = chain.forward(bent());
  const auto result = planner.plan({bent(), {shifted(a, {0, 0.6, 0})}, {}});
  EXPECT_EQ(result.end, CartesianEnd::kCollision) << result.message;
  ASSERT_TRUE(result.contact.has_value());
  EXPECT_TRUE(result.contact->first == "wall" || result.contact->second == "wall") << result.message;
  EXPECT_NE(result.message.find("wall"), std::string::npos);
  judge(result, checker);
  EXPECT_GT(result.fraction, 0.2);  // the hand is up to 0.15 m wide
  EXPECT_LT(result.fraction, 0.5);
  EXPECT_LT(checker.nearest(result.waypoints.back())->distance_m, 2e-3)
      << "it goes on until it nearly touches";
}

// The planar arm turns about z alone: x, y and the yaw of its tip, with three joints and no redundancy.
class PlanarPath : public testing::Test {
 protected:
  CartesianResult line(const JointVector& start, const Pose& to, const CartesianParams& params = {}) {
    auto planner = CartesianPlanner::make(checker_, chain_, params).value();
    return planner.plan({start, {to}, {}});
  }
  RobotModel robot_ = RobotModel::from_urdf(planar_arm_urdf(), ".").value();
  ArmChain chain_ = ArmChain::make(robot_, "base", "bar3").value();
  CollisionChecker checker_ = CollisionChecker::make(planar_arm(), {}).value();
};

// The tip frame stands at joint 3. Beyond 1 m from the base nothing reaches: the fraction is known.
TEST_F(PlanarPath, EndsAtTheReach) {
  const JointVector start = joints(-0.6, 1.2, 0.0);
  const Pose a = chain_.forward(start);
  const double from = a.translation().x();  // 2 * 0.5 * cos(0.6), y = 0
  ASSERT_NEAR(a.translation().y(), 0, 1e-12);
  const auto result = line(start, shifted(a, {1.2 - from, 0, 0}));
  EXPECT_EQ(result.end, CartesianEnd::kOutOfReach) << result.message;
  EXPECT_NEAR(result.fraction, (1.0 - from) / (1.2 - from), 0.01);
  judge(result, checker_);
}

/// The planar arm without shapes, joints within +-`limit` rad.
RobotModel bare_arm(const std::string& limit) {
  std::string urdf = planar_arm_urdf();
  for (std::size_t at; (at = urdf.find("2.8")) != std::string::npos;) urdf.replace(at, 3, limit);
  for (std::size_t at; (at = urdf.find("<collision>")) != std::string::npos;)
    urdf.erase(at, urdf.find("</collision>") + 12 - at);
  return RobotModel::from_urdf(urdf, ".").value();
}

CartesianResult bare_line(const std::string& limit, const JointVector& start, const Eigen::Vector3d& by,
                          const CartesianParams& params = {}) {
  const RobotModel robot = bare_arm(limit);
  CollisionModelParams model;
  model.joints = {"j1", "j2", "j3"};
  auto checker = CollisionChecker::make(CollisionModel::make(robot, model).value(), {}).value();
  const auto chain = ArmChain::make(robot, "base", "bar3").value();
  auto result = CartesianPlanner::make(checker, chain, params)
                    .value()
                    .plan({start, {shifted(chain.forward(start), by)}, {}});
  judge(result, checker);
  return result;
}

// Along y = 0 towards the base the elbow folds; joint 2 ends at 2.5 rad, where the tip is cos(1.25) m away.
TEST(CartesianPath, EndsAtALimitAndNamesTheJoint) {
  const double from = std::cos(0.6);
  const auto result = bare_line("2.5", joints(-0.6, 1.2, -0.6), {-from, 0, 0});
  EXPECT_EQ(result.end, CartesianEnd::kLimit) << result.message;
  EXPECT_EQ(result.joint, "j2");
  EXPECT_NEAR(result.fraction, (from - std::cos(1.25)) / from, 1e-3);
}

TEST_F(PlanarPath, NoLengthIsCompleteAtOnce) {
  const JointVector start = joints(-0.6, 1.2, 0.3);
  const auto result = line(start, chain_.forward(start));
  EXPECT_EQ(result.end, CartesianEnd::kComplete);
  EXPECT_EQ(result.fraction, 1.0);
  ASSERT_EQ(result.waypoints.size(), 1U);
  EXPECT_EQ(result.waypoints[0], start);
}

TEST_F(PlanarPath, SaysWhatIsWrongWithTheRequest) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Pose a = chain_.forward(joints(0, 1, 0));
  EXPECT_EQ(line(joints(nan, 0, 0), a).end, CartesianEnd::kInvalidRequest);
  EXPECT_EQ(line(JointVector::Zero(2), a).end, CartesianEnd::kInvalidRequest);
  Pose broken = a;
  broken.translation().x() = nan;
  EXPECT_EQ(line(joints(0, 1, 0), broken).end, CartesianEnd::kInvalidRequest);
  broken = a;
  broken.linear() *= 1.1;
  EXPECT_EQ(line(joints(0, 1, 0), broken).end, CartesianEnd::kInvalidRequest);
  auto planner = CartesianPlanner::make(checker_, chain_).value();
  EXPECT_EQ(planner.plan({joints(0, 1, 0), {}, {}}).end, CartesianEnd::kInvalidRequest);
  const auto outside = line(joints(0, 2.9, 0), a);
  EXPECT_EQ(outside.end, CartesianEnd::kStartOutsideLimits);
  EXPECT_EQ(outside.joint, "j2");
  const auto cancelled = planner.plan({joints(0, 1, 0), {shifted(a, {-0.1, 0, 0})}, [] { return true; }});
  EXPECT_EQ(cancelled.end, CartesianEnd::kCancelled);
  EXPECT_EQ(cancelled.fraction, 0.0);
  CollisionWorld world;
  test::must(world.add(post("crate", 0.25, 0.0)));
  checker_ = CollisionChecker::make(planar_arm(), world).value();
  const auto touching = line(joints(0, 0, 0), a);
  EXPECT_EQ(touching.end, CartesianEnd::kStartInCollision);
  EXPECT_NE(touching.message.find("crate"), std::string::npos) << touching.message;
}

TEST_F(PlanarPath, RefusesBadParametersAndStrangeChains) {
  CartesianParams params;
  params.position_tolerance_m = 0;
  EXPECT_FALSE(CartesianPlanner::make(checker_, chain_, params).has_value());
  params = {};
  params.timeout_s = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(CartesianPlanner::make(checker_, chain_, params).has_value());
  EXPECT_FALSE(CartesianPlanner::make(checker_, left_chain()).has_value());
  params = {};
  params.timeout_s = 1e-9;
  const Pose a = chain_.forward(joints(0, 1, 0));
  EXPECT_EQ(line(joints(0, 1, 0), shifted(a, {-0.1, 0, 0}), params).end, CartesianEnd::kTimeout);
}

// Past the base's axis at a distance of 20 um, with a tolerance of 1 um: joint 1 would have to turn half
// round within some 40 um of the path. The joints could be anywhere, so neither limits nor reach are the
// reason.
TEST(CartesianPath, EndsBeforeAJump) {
  CartesianParams params;
  params.position_tolerance_m = 1e-6;
  const double from = std::cos(0.6);
  const auto past = bare_line("6.0", joints(-0.6, 1.2, -0.6), {-2 * from, 4e-5, 0}, params);
  EXPECT_EQ(past.end, CartesianEnd::kSingularity) << past.message;
  EXPECT_NEAR(past.fraction, 0.5, 0.001);
  // At 10 cm from the axis it is a quick turn, but no jump.
  const auto around = bare_line("6.0", joints(-0.6, 1.2, -0.6), {-2 * from, 0.2, 0}, params);
  EXPECT_EQ(around.end, CartesianEnd::kComplete) << around.message;
}

}  // namespace
}  // namespace extperfc::arm
