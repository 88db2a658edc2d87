// One solution: found, within limits, within tolerance, the same again.
#include <limits>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "test/unit/arm/kinematics/arms.hpp"

namespace extperfc::arm {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

/// Two links of 0.5 m and 0.3 m that turn about z. Joint 2 bends by +-2.5 rad.
///
///        y            tip
///        |           /
///        |    q2    /  0.3
///        |  o------.
///        | /   0.5
///        |/ q1
///   base o--------- x
ArmChain two_links(double q1_limit = 3) {
  return chain_of(
      link("base") + link("upper") + link("lower") + link("tip") +
          joint("q1", "revolute", "base", "upper", "<axis xyz='0 0 1'/>" + limit(-q1_limit, q1_limit)) +
          joint("q2", "revolute", "upper", "lower",
                origin("0.5 0 0") + "<axis xyz='0 0 1'/>" + limit(-2.5, 2.5)) +
          joint("end", "fixed", "lower", "tip", origin("0.3 0 0")),
      "tip");
}

/// The position alone.
IkTolerance any_orientation() {
  IkTolerance tolerance;
  tolerance.orientation_rad.setConstant(kInf);
  return tolerance;
}

JointVector joints(std::initializer_list<double> values) {
  JointVector out(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), out.data());
  return out;
}

/// Timeless, so that a busy machine changes nothing.
IkOptions patient() {
  IkOptions options;
  options.timeout_s = kInf;
  options.max_restarts = 1000;
  return options;
}

class BaxterPoses : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Baxter, BaxterPoses, testing::Values("left", "right"),
                         [](const auto& side) { return std::string(side.param); });

TEST_P(BaxterPoses, SolveEveryReachablePose) {
  const InverseKinematics kinematics(baxter_arm(GetParam()));
  const ArmChain& chain = kinematics.chain();
  Rng rng(11);
  int restarts = 0;
  for (int i = 0; i < 10'000; ++i) {
    const JointVector q = random_joints(chain, rng);
    const Pose target = chain.forward(q);
    const auto result = kinematics.solve(target, chain.mid_range(), patient());
    ASSERT_TRUE(result) << "pose " << i << ": " << to_string(result.error().reason);
    ASSERT_TRUE(chain.within_limits(result->joints)) << "pose " << i;
    const Pose tip = target.inverse() * chain.forward(result->joints);
    ASSERT_LE(tip.translation().cwiseAbs().maxCoeff(), 1.001e-5) << "pose " << i;
    ASSERT_LE(orientation_error(target, chain.forward(result->joints)), std::sqrt(3.0) * 1.001e-5)
        << "pose " << i;
    ASSERT_NEAR(result->position_error_m, tip.translation().norm(), 1e-9);
    restarts += result->restarts;
  }
  EXPECT_LT(restarts, 20'000);
}

TEST(InverseKinematics, KeepsASeedThatIsASolution) {
  const InverseKinematics kinematics(baxter_arm("left"));
  Rng rng(12);
  for (int i = 0; i < 100; ++i) {
    const JointVector q = random_joints(kinematics.chain(), rng);
    const auto result = kinematics.solve(kinematics.chain().forward(q), q);
    ASSERT_TRUE(result);
    EXPECT_EQ(result->joints, q);
    EXPECT_EQ(result->restarts, 0);
  }
}

TEST(InverseKinematics, GivesTheSameAgainAndOthersForOtherSeeds) {
  const InverseKinematics kinematics(baxter_arm("right"));
  Rng rng(13);
  int different = 0;
  for (int i = 0; i < 200; ++i) {
    const Pose target = kinematics.chain().forward(random_joints(kinematics.chain(), rng));
    IkOptions options = patient();
    const auto first = kinematics.solve(target, kinematics.chain().mid_range(), options);
    const auto again = kinematics.solve(target, kinematics.chain().mid_range(), options);
    ASSERT_TRUE(first && again);
    ASSERT_EQ(first->joints, again->joints);
    options.rng_seed = 99;
    const auto other = kinematics.solve(target, kinematics.chain().mid_range(), options);
    ASSERT_TRUE(other);
    if (other->joints != first->joints) ++different;
  }
  EXPECT_GT(different, 0);
}

TEST(InverseKinematics, MovesASeedIntoTheLimits) {
  const InverseKinematics kinematics(baxter_arm("left"));
  const ArmChain& chain = kinematics.chain();
  const Pose target = chain.forward(chain.mid_range());
  const JointVector outside = chain.limits().upper + JointVector::Constant(7, 2.0);
  const auto result = kinematics.solve(target, outside, patient());
  const auto clamped = kinematics.solve(target, chain.clamp(outside), patient());
  ASSERT_TRUE(result && clamped);
  EXPECT_TRUE(chain.within_limits(result->joints));
  EXPECT_EQ(result->joints, clamped->joints);
}

TEST(InverseKinematics, TakesAndGivesKdlTypes) {
  const InverseKinematics kinematics(baxter_arm("left"));
  const ArmChain& chain = kinematics.chain();
  Rng rng(14);
  const Pose target = chain.forward(random_joints(chain, rng));
  const auto ours = kinematics.solve(target, chain.mid_range(), patient());
  const auto theirs = kinematics.solve(to_kdl(target), to_kdl(chain.mid_range()), patient());
  ASSERT_TRUE(ours && theirs);
  EXPECT_EQ(ours->joints, theirs->joints);
  const auto short_seed = kinematics.solve(to_kdl(target), KDL::JntArray(30), patient());
  ASSERT_FALSE(short_seed);
  EXPECT_EQ(short_seed.error().reason, IkReason::kInvalid);
}

TEST(InverseKinematics, SolvesForAllNumbersOfJoints) {
  Rng rng(15);
  const auto six = ArmChain::make(baxter(), "base", "left_lower_forearm").value();
  const auto five = ArmChain::make(baxter(), "left_upper_shoulder", "left_lower_forearm").value();
  for (const ArmChain& chain : {six, five, two_links()}) {
    const InverseKinematics kinematics(chain);
    for (int i = 0; i < 200; ++i) {
      const Pose target = chain.forward(random_joints(chain, rng));
      const auto result = kinematics.solve(target, chain.mid_range(), patient());
      ASSERT_TRUE(result) << chain.joint_count() << " joints: " << to_string(result.error().reason);
      EXPECT_LT(position_error(target, chain.forward(result->joints)), 2e-5);
      EXPECT_TRUE(chain.within_limits(result->joints));
    }
  }
}

TEST(InverseKinematics, KeepsEndlessJointsWithinHalfATurnOfTheSeed) {
  const ArmChain chain =
      chain_of(link("base") + link("a") + link("b") +
                   joint("rail", "prismatic", "base", "a", "<axis xyz='0 0 1'/>" + limit(-1, 1)) +
                   joint("turn", "continuous", "a", "b", origin("0.2 0 0") + "<axis xyz='0 0 1'/>"),
               "b");
  const InverseKinematics kinematics(chain);
  Rng rng(16);
  for (int i = 0; i < 100; ++i) {
    const JointVector q = joints({rng.uniform(-1, 1), rng.uniform(-30, 30)});
    const JointVector seed = joints({0, rng.uniform(-30, 30)});
    const auto result = kinematics.solve(chain.forward(q), seed, patient());
    ASSERT_TRUE(result) << to_string(result.error().reason);
    EXPECT_LE(std::abs(result->joints[1] - seed[1]), 3.1416);
    EXPECT_LT(chain.difference(result->joints, q).norm(), 1e-4);
  }
}

TEST(Tolerance, FreesTheRotationAboutTheToolAxis) {
  const InverseKinematics kinematics(baxter_arm("left"));
  const ArmChain& chain = kinematics.chain();
  IkOptions options = patient();
  options.tolerance.orientation_rad.z() = kInf;
  Rng rng(17);
  for (int i = 0; i < 300; ++i) {
    // Turned so far that w2 alone, which turns the tool, often stands at a limit.
    const Pose target =
        chain.forward(random_joints(chain, rng)) * make_pose({0, 0, 0}, {0, 0, rng.uniform(-3, 3)});
    const auto result = kinematics.solve(target, chain.mid_range(), options);
    ASSERT_TRUE(result) << i;
    const Pose tip = chain.forward(result->joints);
    EXPECT_LT(position_error(target, tip), 2e-5);
    EXPECT_LT((tip.linear().col(2) - target.linear().col(2)).norm(), 2e-5);
  }
}

TEST(Tolerance, UsesItsRoomAndNoMore) {
  const InverseKinematics kinematics(baxter_arm("right"));
  const ArmChain& chain = kinematics.chain();
  IkOptions options = patient();
  options.tolerance.position_m.x() = 0.05;
  options.tolerance.orientation_rad = {0.1, 1e-5, 0.2};
  Rng rng(18);
  int off_target = 0;
  for (int i = 0; i < 300; ++i) {
    const Pose target = chain.forward(random_joints(chain, rng));
    const auto result = kinematics.solve(target, random_joints(chain, rng), options);
    ASSERT_TRUE(result) << i;
    const Pose tip = target.inverse() * chain.forward(result->joints);
    const Eigen::AngleAxisd rotation(tip.linear());
    const Eigen::Vector3d vector = rotation.axis() * rotation.angle();
    EXPECT_LE(std::abs(tip.translation().x()), 0.05);
    EXPECT_LE(tip.translation().tail<2>().cwiseAbs().maxCoeff(), 1.001e-5);
    EXPECT_LE(std::abs(vector.x()), 0.1);
    EXPECT_LE(std::abs(vector.y()), 1.1e-5);
    EXPECT_LE(std::abs(vector.z()), 0.2);
    if (std::abs(tip.translation().x()) > 1e-3) ++off_target;
  }
  EXPECT_GT(off_target, 0);
}

TEST(TwoLinks, BendEitherWay) {
  const InverseKinematics kinematics(two_links());
  IkOptions options = patient();
  options.tolerance = any_orientation();
  // Law of cosines: a target 0.6 m away needs cos q2 = (0.36 - 0.25 - 0.09) / (2 * 0.5 * 0.3).
  const double q2 = std::acos(0.02 / 0.3);
  for (const double sign : {-1.0, 1.0}) {
    const auto result = kinematics.solve(make_pose({0.6, 0, 0}), joints({0, sign * 0.5}), options);
    ASSERT_TRUE(result);
    EXPECT_NEAR(result->joints[1], sign * q2, 1e-4);
  }
}

TEST(Objective, NearSeedAndMidRangeAreNoWorseThanNone) {
  const InverseKinematics kinematics(baxter_arm("left"));
  const ArmChain& chain = kinematics.chain();
  const JointVector half = 0.5 * (chain.limits().upper - chain.limits().lower);
  const auto off_middle = [&](const JointVector& q) {
    return (q - chain.mid_range()).cwiseQuotient(half).norm();
  };
  Rng rng(19);
  double plain_seed = 0, near_seed = 0, plain_middle = 0, mid_range = 0;
  for (int i = 0; i < 300; ++i) {
    const JointVector seed = random_joints(chain, rng);
    const Pose target = chain.forward(random_joints(chain, rng));
    IkOptions options = patient();
    const auto plain = kinematics.solve(target, seed, options);
    options.objective = IkObjective::kNearSeed;
    const auto near = kinematics.solve(target, seed, options);
    options.objective = IkObjective::kMidRange;
    const auto middle = kinematics.solve(target, seed, options);
    ASSERT_TRUE(plain && near && middle);
    for (const auto& result : {near, middle}) {
      EXPECT_TRUE(chain.within_limits(result->joints));
      EXPECT_LT(position_error(target, chain.forward(result->joints)), 2e-5);
      EXPECT_LT(orientation_error(target, chain.forward(result->joints)), 2e-5);
    }
    EXPECT_LE((near->joints - seed).norm(), (plain->joints - seed).norm() + 1e-12);
    EXPECT_LE(off_middle(middle->joints), off_middle(plain->joints) + 1e-12);
    plain_seed += (plain->joints - seed).norm();
    near_seed += (near->joints - seed).norm();
    plain_middle += off_middle(plain->joints);
    mid_range += off_middle(middle->joints);
  }
  EXPECT_LT(near_seed, plain_seed);
  EXPECT_LT(mid_range, plain_middle);
}

/// At a minimum along the self-motion, or at a limit, no neighbour on the curve is nearer.
TEST(Objective, EndsAtAMinimumOfTheSelfMotion) {
  const InverseKinematics kinematics(baxter_arm("right"));
  const ArmChain& chain = kinematics.chain();
  Rng rng(20);
  int neighbours = 0;
  for (int i = 0; i < 50; ++i) {
    const JointVector seed = random_joints(chain, rng);
    const Pose target = chain.forward(random_joints(chain, rng));
    IkOptions options = patient();
    options.objective = IkObjective::kNearSeed;
    const auto result = kinematics.solve(target, seed, options);
    ASSERT_TRUE(result);
    const Eigen::MatrixXd columns = chain.jacobian(result->joints);
    const JointVector along = columns.fullPivLu().kernel().col(0).normalized();
    for (const double step_rad : {-0.03, -0.01, 0.01, 0.03}) {
      const auto beside = kinematics.solve(target, result->joints + step_rad * along, patient());
      if (!beside || (beside->joints - result->joints).norm() > 0.1) continue;  // another piece of the curve
      ++neighbours;
      EXPECT_GE((beside->joints - seed).norm(), (result->joints - seed).norm() - 1e-4) << "case " << i;
    }
  }
  EXPECT_GT(neighbours, 100);
}

}  // namespace
}  // namespace extperfc::arm
