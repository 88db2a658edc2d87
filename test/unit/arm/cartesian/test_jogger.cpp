// Every step of the jogger is judged from outside: Bullet for collisions, differences for velocity and
// acceleration, the description for limits.
#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "extperfc/arm/jogger.hpp"

#include "test/unit/arm/collision/baxter.hpp"

namespace extperfc::arm {
namespace {

constexpr double kDt = 0.01;

JointVector neutral() {
  JointVector state(7);
  state << 0.0, -0.55, 0.0, 0.75, 0.0, 1.26, 0.0;
  return state;
}

/// The elbow well bent: the tool may go on outwards for some decimetres.
JointVector bent() {
  JointVector state(7);
  state << 0.0, -1.0, 0.0, 1.9, 0.0, 0.67, 0.0;
  return state;
}

/// Of the tool in the frame that objects are in; its axes are those of the chain's root.
Eigen::Vector3d tool_at(const JointVector& state) {
  return test::group_model("left_arm").link_pose(state, "left_gripper").value().translation();
}

WorldObject wall(const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& at) {
  Shape shape;
  shape.geometry = Box{size};
  return {name, {shape}, make_pose(at)};
}

class JoggerTest : public testing::Test {
 protected:
  void start(const CollisionWorld& world, const JointVector& state, const JoggerParams& params = {},
             const std::string& group = "left_arm") {
    checker_.emplace(CollisionChecker::make(test::group_model(group), world).value());
    jogger_.emplace(Jogger::make(*checker_, chain_, params).value());
    params_ = params;
    state_ = state;
    velocity_ = JointVector::Zero(state.size());
    now_ = 0;
  }

  void want(JogCommand command) {
    command.stamp_s = now_;
    jogger_->command(command);
  }
  void want_twist(const Eigen::Vector3d& linear, const Eigen::Vector3d& angular = Eigen::Vector3d::Zero(),
                  JogCommand::Kind kind = JogCommand::Kind::kTwistRoot) {
    JogCommand command;
    command.kind = kind;
    command.twist << linear, angular;
    want(command);
  }
  void want_joint(int joint, double speed) {
    JogCommand command;
    command.kind = JogCommand::Kind::kJoints;
    command.joint_velocity = JointVector::Zero(7);
    command.joint_velocity[joint] = speed;
    want(command);
  }

  /// One step of a robot that does what it is told, with what must hold of every step.
  JogStep go() {
    const JogStep step = jogger_->step(now_, state_, kDt);
    now_ += kDt;
    const JointVector moved = (step.positions - state_) / kDt;
    const auto& model = checker_->model();
    const JointVector& limit = chain_.max_velocity();
    EXPECT_LE((moved.cwiseAbs().head(7) - limit).maxCoeff(), 1e-9);
    EXPECT_LE((step.velocities.cwiseAbs().head(7) - limit).maxCoeff(), 1e-9);
    EXPECT_LE((step.velocities - velocity_).cwiseAbs().maxCoeff(),
              params_.max_acceleration_rad_s2 * kDt * (1 + 1e-9));
    EXPECT_LE((step.positions - model.limits().upper).maxCoeff(), 1e-12);
    EXPECT_LE((model.limits().lower - step.positions).maxCoeff(), 1e-12);
    EXPECT_FALSE(checker_->contact(step.positions).has_value());
    state_ = step.positions;
    velocity_ = step.velocities;
    return step;
  }

  ArmChain chain_ = ArmChain::make(test::baxter(), "base", "left_gripper").value();
  std::optional<CollisionChecker> checker_;
  std::optional<Jogger> jogger_;
  JoggerParams params_;
  JointVector state_, velocity_;
  double now_{0};
};

TEST_F(JoggerTest, ATwistMovesTheToolAsAsked) {
  for (const auto kind : {JogCommand::Kind::kTwistRoot, JogCommand::Kind::kTwistTip}) {
    start({}, neutral());
    const Pose before = chain_.forward(state_);
    const Eigen::Vector3d linear(0.05, 0.02, -0.03), angular(0.1, -0.05, 0.2);
    for (int i = 0; i < 20; ++i) {
      want_twist(linear, angular, kind);
      go();
    }
    const Pose from = chain_.forward(state_);
    want_twist(linear, angular, kind);
    const JogStep step = go();
    const Pose to = chain_.forward(state_);
    EXPECT_EQ(step.hindrance, JogHindrance::kNone);
    const Eigen::Matrix3d frame =
        kind == JogCommand::Kind::kTwistTip ? from.linear() : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
    EXPECT_LT(((to.translation() - from.translation()) / kDt - frame * linear).norm(), 1e-3);
    const Eigen::AngleAxisd rotation(to.linear() * from.linear().transpose());
    EXPECT_LT((rotation.angle() / kDt * rotation.axis() - frame * angular).norm(), 2e-3);
    EXPECT_GT((to.translation() - before.translation()).norm(), 0.005);
  }
}

TEST_F(JoggerTest, AnOldCommandRampsToZero) {
  start({}, neutral());
  want_joint(0, 0.8);
  JogStep step;
  for (int i = 0; i < 15; ++i) step = go();
  EXPECT_GT(step.velocities[0], 0.5);
  double last = step.velocities[0];
  int steps = 0;
  while (step.moving && steps < 100) {
    step = go();
    EXPECT_LE(std::abs(step.velocities[0]), last + 0.06);
    last = step.velocities[0];
    ++steps;
  }
  EXPECT_FALSE(step.moving);
  EXPECT_EQ(step.hindrance, JogHindrance::kTimeout);
  EXPECT_LT(steps, 6 + 16 + 3);  // what is left of 0.2 s, then 0.8 rad/s at 5 rad/s^2
  want_joint(0, 0.8);
  go();
  EXPECT_TRUE(go().moving);
}

TEST_F(JoggerTest, StopsAtAJointsLimitAndLeavesIt) {
  start({}, neutral());
  JogStep step;
  for (int i = 0; i < 1500; ++i) {
    want_joint(4, 1.0);
    step = go();
  }
  EXPECT_FALSE(step.moving);
  EXPECT_EQ(step.hindrance, JogHindrance::kJointLimit);
  EXPECT_EQ(step.joint, chain_.joint_names()[4]);
  EXPECT_LT(chain_.limits().upper[4] - state_[4], 0.01);
  for (int i = 0; i < 30; ++i) {
    want_joint(4, -1.0);
    step = go();
  }
  EXPECT_LT(step.velocities[4], -0.5);
}

TEST_F(JoggerTest, StopsBeforeAnObstacleNamesItAndLeavesIt) {
  CollisionWorld world;
  test::must(world.add(wall("wall", {0.05, 2.0, 2.0}, tool_at(bent()) + Eigen::Vector3d(0.2, 0, 0))));
  start(world, bent());
  JogStep step;
  int steps = 0;
  do {
    want_twist({0.2, 0, 0});
    step = go();
  } while ((step.moving || steps < 10) && ++steps < 1000);
  EXPECT_EQ(step.hindrance, JogHindrance::kCollision);
  ASSERT_TRUE(step.contact.has_value());
  EXPECT_TRUE(step.contact->first == "wall" || step.contact->second == "wall");
  const auto nearest = checker_->nearest(state_);
  ASSERT_TRUE(nearest.has_value());
  EXPECT_TRUE(nearest->first == "wall" || nearest->second == "wall");
  EXPECT_LT(nearest->distance_m, 0.02);
  const double before = chain_.forward(state_).translation().x();
  for (int i = 0; i < 50; ++i) {
    want_twist({-0.2, 0, 0});
    step = go();
  }
  EXPECT_LT(chain_.forward(state_).translation().x(), before - 0.05);
}

TEST_F(JoggerTest, MovesOutOfAnObjectThatWasPutIntoTheArm) {
  start({}, bent());
  go();
  CollisionWorld world;
  test::must(world.add(wall("crate", {0.8, 0.8, 0.8}, tool_at(state_) + Eigen::Vector3d(0.37, 0, 0))));
  auto checker = CollisionChecker::make(test::group_model("left_arm"), world).value();
  ASSERT_TRUE(checker.contact(state_).has_value());
  jogger_->use(checker);
  const auto drive = [&](double speed, int steps) {
    JogStep step;
    for (int i = 0; i < steps; ++i) {
      want_twist({speed, 0, 0});
      step = jogger_->step(now_, state_, kDt);
      now_ += kDt;
      state_ = step.positions;
    }
    return step;
  };
  const JointVector begin = state_;
  const JogStep deeper = drive(0.1, 50);
  EXPECT_EQ(deeper.hindrance, JogHindrance::kCollision);
  EXPECT_LT((state_ - begin).norm(), 1e-9);
  drive(-0.1, 2000);
  EXPECT_FALSE(checker.contact(state_).has_value());
}

TEST_F(JoggerTest, SlowsDownAndEndsBeforeASingularityAndLeavesIt) {
  start({}, neutral());
  JogStep step;
  for (int i = 0; i < 3000 && step.hindrance != JogHindrance::kSingularity; ++i) {
    want_twist({0.1, 0.1, 0.02});
    step = go();
  }
  ASSERT_EQ(step.hindrance, JogHindrance::kSingularity);
  for (int i = 0; i < 3000 && step.moving; ++i) {
    want_twist({0.1, 0.1, 0.02});
    step = go();
  }
  EXPECT_EQ(step.hindrance, JogHindrance::kSingularity);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(chain_.jacobian(state_));
  EXPECT_GE(svd.singularValues().minCoeff(), 0.5 * params_.singularity_stop);
  const Eigen::Vector3d before = chain_.forward(state_).translation();
  for (int i = 0; i < 200; ++i) {
    want_twist({-0.1, -0.1, -0.02});
    step = go();
  }
  EXPECT_GT((chain_.forward(state_).translation() - before).norm(), 0.05);
}

TEST_F(JoggerTest, StopsWhereTheRobotDoesNotFollow) {
  start({}, neutral());
  JogStep step;
  for (int i = 0; i < 200 && step.hindrance != JogHindrance::kLag; ++i) {
    want_joint(0, 0.5);
    step = jogger_->step(now_, neutral(), kDt);
    now_ += kDt;
  }
  EXPECT_EQ(step.hindrance, JogHindrance::kLag);
  for (int i = 0; i < 50; ++i) {
    want_joint(0, 0.0);
    step = jogger_->step(now_, neutral(), kDt);
    now_ += kDt;
  }
  EXPECT_LT((step.positions - neutral()).norm(), 1e-12);
  EXPECT_FALSE(step.moving);
}

TEST_F(JoggerTest, BadInputBrakes) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  start({}, neutral());
  EXPECT_EQ(jogger_->step(0, JointVector::Zero(3), kDt).hindrance, JogHindrance::kBadInput);
  for (int i = 0; i < 15; ++i) {
    want_joint(0, 0.8);
    go();
  }
  EXPECT_EQ(jogger_->step(now_, state_, 0.0).hindrance, JogHindrance::kBadInput);
  want_joint(0, nan);
  JogStep step = go();
  EXPECT_EQ(step.hindrance, JogHindrance::kBadInput);
  EXPECT_LT(step.velocities[0], 0.8);
  const double before = step.velocities[0];
  JointVector broken = state_;
  broken[2] = nan;
  step = jogger_->step(now_, broken, kDt);
  EXPECT_EQ(step.hindrance, JogHindrance::kBadInput);
  EXPECT_LT(step.velocities[0], before);
  EXPECT_TRUE(step.positions.allFinite());
  want_twist({nan, 0, 0});
  state_ = step.positions;
  velocity_ = step.velocities;
  EXPECT_EQ(go().hindrance, JogHindrance::kBadInput);
}

TEST_F(JoggerTest, RefusesBadParameters) {
  start({}, neutral());
  const auto refused = [&](auto change) {
    JoggerParams params;
    change(params);
    return !Jogger::make(*checker_, chain_, params).has_value();
  };
  EXPECT_TRUE(refused([](auto& p) { p.max_acceleration_rad_s2 = 0; }));
  EXPECT_TRUE(refused([](auto& p) { p.max_velocity = JointVector::Ones(3); }));
  EXPECT_TRUE(refused([](auto& p) { p.singularity_stop = p.singularity_slow; }));
  EXPECT_TRUE(refused([](auto& p) { p.reaction_s = std::numeric_limits<double>::quiet_NaN(); }));
  EXPECT_FALSE(refused([](auto&) {}));
  const auto other = ArmChain::make(test::baxter(), "base", "right_gripper").value();
  EXPECT_FALSE(Jogger::make(*checker_, other).has_value());
}

// Random twists and joint speeds, changed at random times, among random obstacles; go() judges every step.
TEST_F(JoggerTest, NothingThatIsCommandedCollides) {
  Rng rng(5);
  int moved = 0;
  int blocked = 0;
  for (int world = 0; world < 12; ++world) {
    const bool both = world % 3 == 2;
    start(test::random_world(12, rng), neutral(), {}, both ? "both_arms" : "left_arm");
    const auto& names = checker_->model().joint_names();
    ASSERT_EQ(names[0], chain_.joint_names()[0]) << "the left arm comes first";
    for (int i = 0; i < 1000 && (i == 0 || !checker_->is_free(state_)); ++i)
      state_ = test::random_state(checker_->model().limits(), rng);
    if (!checker_->is_free(state_)) continue;  // an object stands in the robot's body
    velocity_ = JointVector::Zero(state_.size());
    JogCommand command;
    for (int i = 0; i < 500; ++i) {
      if (i % 40 == 0) {
        command.kind = static_cast<JogCommand::Kind>(rng.integer(1, 3));
        command.joint_velocity.resize(7);
        for (int j = 0; j < 7; ++j) command.joint_velocity[j] = rng.uniform(-3, 3);
        for (int j = 0; j < 6; ++j) command.twist[j] = rng.uniform(-1, 1);
      }
      want(command);
      const JogStep step = go();
      moved += step.moving ? 1 : 0;
      blocked += step.hindrance == JogHindrance::kCollision ? 1 : 0;
      ASSERT_FALSE(HasFailure()) << "world " << world << ", step " << i;
    }
  }
  EXPECT_GT(moved, 1500);
  EXPECT_GT(blocked, 300);
}

}  // namespace
}  // namespace extperfc::arm
