// All solutions, the nearest one, and sweeps along the self-motion.
#include <limits>

#include <gtest/gtest.h>

#include "arms.hpp"

namespace extperfc::arm {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

IkSearchOptions patient() {
  IkSearchOptions options;
  options.timeout_s = kInf;
  return options;
}

double distance_to(const IkSolutionSet& set, const ArmChain& chain, const JointVector& q) {
  double smallest = kInf;
  for (const IkBranch& branch : set.branches)
    for (const JointVector& joints : branch.joints)
      smallest = std::min(smallest, chain.difference(joints, q).norm());
  return smallest;
}

/// Links of 0.4 m in a plane, every joint turns about z without end: three positions for two coordinates.
ArmChain endless_plane() {
  return chain_of(link("base") + link("a") + link("b") + link("c") + link("tip") +
                      joint("q1", "continuous", "base", "a", "<axis xyz='0 0 1'/>") +
                      joint("q2", "continuous", "a", "b", origin("0.4 0 0") + "<axis xyz='0 0 1'/>") +
                      joint("q3", "continuous", "b", "c", origin("0.4 0 0") + "<axis xyz='0 0 1'/>") +
                      joint("end", "fixed", "c", "tip", origin("0.4 0 0")),
                  "tip");
}

class BaxterSelfMotion : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Baxter, BaxterSelfMotion, testing::Values("left", "right"),
                         [](const auto& side) { return std::string(side.param); });

TEST_P(BaxterSelfMotion, SweepHoldsTheTip) {
  const InverseKinematics kinematics(baxter_arm(GetParam()));
  const ArmChain& chain = kinematics.chain();
  const IkSweepOptions options;
  Rng rng(41);
  std::size_t total = 0;
  for (int i = 0; i < 50; ++i) {
    const JointVector start = random_joints(chain, rng);
    const Pose target = chain.forward(start);
    const auto branch = kinematics.sweep_redundancy(start);
    ASSERT_TRUE(branch) << branch.error().message;
    total += branch->joints.size();
    bool has_start = false;
    for (std::size_t k = 0; k < branch->joints.size(); ++k) {
      const JointVector& q = branch->joints[k];
      EXPECT_TRUE(chain.within_limits(q));
      EXPECT_LT(position_error(target, chain.forward(q)), 1e-9);
      EXPECT_LT(orientation_error(target, chain.forward(q)), 1e-9);
      if (k > 0) {
        EXPECT_LE((q - branch->joints[k - 1]).norm(), 1.31 * options.step_rad);
      }
      has_start = has_start || q == start;
    }
    EXPECT_TRUE(has_start);
    EXPECT_FALSE(branch->closed && branch->joints.size() < 10);
  }
  EXPECT_GT(total, 50u * 10);
}

/// An open curve ends where a joint meets its limit, so one more step would leave it.
TEST_P(BaxterSelfMotion, SweepEndsAtLimits) {
  const InverseKinematics kinematics(baxter_arm(GetParam()));
  const ArmChain& chain = kinematics.chain();
  Rng rng(42);
  int open = 0;
  for (int i = 0; i < 50; ++i) {
    const auto branch = kinematics.sweep_redundancy(random_joints(chain, rng));
    ASSERT_TRUE(branch);
    if (branch->closed) continue;
    ++open;
    for (const JointVector& end : {branch->joints.front(), branch->joints.back()}) {
      const double room =
          std::min((chain.limits().upper - end).minCoeff(), (end - chain.limits().lower).minCoeff());
      EXPECT_LT(room, 1e-3) << "case " << i;
    }
  }
  EXPECT_GT(open, 10);
}

TEST(Sweep, ClosesWhereNoLimitEndsIt) {
  const InverseKinematics kinematics(endless_plane());
  IkSweepOptions options;
  options.free_axes = {false, false, true, true, true, true};  // what the plane holds anyway, and the turn
  JointVector start(3);
  start << 0.2, 0.9, 0.7;
  const auto branch = kinematics.sweep_redundancy(start, options);
  ASSERT_TRUE(branch) << branch.error().message;
  EXPECT_TRUE(branch->closed);
  const double gap = kinematics.chain().difference(branch->joints.front(), branch->joints.back()).norm();
  EXPECT_LE(gap, 1.31 * options.step_rad);
  const Pose target = kinematics.chain().forward(start);
  for (const JointVector& q : branch->joints)
    EXPECT_LT(position_error(target, kinematics.chain().forward(q)), 1e-9);
}

TEST(Sweep, IsBoundedAndChecksItsInput) {
  const InverseKinematics kinematics(baxter_arm("left"));
  const JointVector start = kinematics.chain().mid_range();
  IkSweepOptions few;
  few.max_steps = 3;
  EXPECT_LE(kinematics.sweep_redundancy(start, few)->joints.size(), 7u);
  IkSweepOptions bad;
  bad.step_rad = 0;
  EXPECT_EQ(kinematics.sweep_redundancy(start, bad).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(kinematics.sweep_redundancy(JointVector::Zero(3)).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(kinematics.sweep_redundancy(kinematics.chain().limits().upper * 1.5).error().code,
            ErrorCode::kInvalidArgument);
  IkSweepOptions two;
  two.free_axes[5] = true;
  EXPECT_EQ(kinematics.sweep_redundancy(start, two).error().code, ErrorCode::kUnsupported);
}

/// Six joints whose tool may turn about its own axis have one degree of redundancy too.
TEST(Sweep, WalksAlongAFreeAxis) {
  const InverseKinematics kinematics(ArmChain::make(baxter(), "base", "left_lower_forearm").value());
  Rng rng(43);
  IkSweepOptions options;
  options.free_axes[5] = true;
  for (int i = 0; i < 20; ++i) {
    const JointVector start = random_joints(kinematics.chain(), rng);
    const Pose target = kinematics.chain().forward(start);
    const auto branch = kinematics.sweep_redundancy(start, options);
    ASSERT_TRUE(branch);
    for (const JointVector& q : branch->joints) {
      const Pose tip = kinematics.chain().forward(q);
      EXPECT_LT(position_error(target, tip), 1e-9);
      EXPECT_LT((target.linear().col(2) - tip.linear().col(2)).norm(), 1e-8);
    }
  }
}

TEST_P(BaxterSelfMotion, AllSolutionsHoldThePoseAndHaveTheOneItCameFrom) {
  const InverseKinematics kinematics(baxter_arm(GetParam()));
  const ArmChain& chain = kinematics.chain();
  Rng rng(44);
  int found = 0;
  constexpr int kPoses = 40;
  for (int i = 0; i < kPoses; ++i) {
    const JointVector q = random_joints(chain, rng);
    const Pose target = chain.forward(q);
    const auto set = kinematics.all_solutions(target, patient());
    ASSERT_TRUE(set) << to_string(set.error().reason);
    for (const IkBranch& branch : set->branches)
      for (const JointVector& joints : branch.joints) {
        ASSERT_TRUE(chain.within_limits(joints));
        ASSERT_LT(position_error(target, chain.forward(joints)), 2e-5);
        ASSERT_LT(orientation_error(target, chain.forward(joints)), 2e-5);
      }
    if (distance_to(*set, chain, q) < 0.75 * patient().step_rad) ++found;
  }
  // Sampling may miss a short branch next to a limit, but seldom.
  EXPECT_GE(found, kPoses - 4);
}

TEST(AllSolutions, AreTheTwoOfTwoLinks) {
  const InverseKinematics kinematics(
      chain_of(link("base") + link("upper") + link("lower") + link("tip") +
                   joint("q1", "revolute", "base", "upper", "<axis xyz='0 0 1'/>" + limit(-3, 3)) +
                   joint("q2", "revolute", "upper", "lower",
                         origin("0.5 0 0") + "<axis xyz='0 0 1'/>" + limit(-2.5, 2.5)) +
                   joint("end", "fixed", "lower", "tip", origin("0.3 0 0")),
               "tip"));
  IkSearchOptions options = patient();
  options.tolerance.orientation_rad.setConstant(kInf);
  const double bend = std::acos(0.02 / 0.3);  // law of cosines at 0.6 m
  const auto set = kinematics.all_solutions(make_pose({0.6, 0, 0}), options);
  ASSERT_TRUE(set);
  EXPECT_TRUE(set->complete);
  ASSERT_EQ(set->branches.size(), 2u);
  std::vector<double> bends;
  for (const IkBranch& branch : set->branches) {
    ASSERT_EQ(branch.joints.size(), 1u);
    bends.push_back(branch.joints.front()[1]);
  }
  std::sort(bends.begin(), bends.end());
  EXPECT_NEAR(bends[0], -bend, 1e-4);
  EXPECT_NEAR(bends[1], bend, 1e-4);
}

TEST(AllSolutions, LeaveOutWhatIsRefused) {
  const InverseKinematics kinematics(baxter_arm("left"));
  const ArmChain& chain = kinematics.chain();
  const Pose target = chain.forward(chain.mid_range());
  IkSearchOptions options = patient();
  options.accept = [](const JointVector& q) { return q[2] > 0; };
  const auto set = kinematics.all_solutions(target, options);
  ASSERT_TRUE(set);
  for (const IkBranch& branch : set->branches)
    for (const JointVector& q : branch.joints) EXPECT_GT(q[2], 0);
  options.accept = [](const JointVector&) { return false; };
  const auto none = kinematics.all_solutions(target, options);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().reason, IkReason::kCollision);
  EXPECT_GT(none.error().refused, 1);
  const auto far = kinematics.all_solutions(make_pose({5, 0, 0}), options);
  ASSERT_FALSE(far);
  EXPECT_EQ(far.error().reason, IkReason::kOutOfReach);
}

/// The configuration that a pose was made from is a solution, so the nearest one is no farther than it.
TEST_P(BaxterSelfMotion, NearestIsNoFartherThanTheGeneratingConfiguration) {
  const InverseKinematics kinematics(baxter_arm(GetParam()));
  const ArmChain& chain = kinematics.chain();
  Rng rng(45);
  for (int i = 0; i < 40; ++i) {
    const JointVector q = random_joints(chain, rng);
    JointVector seed = q;
    for (double& value : seed) value += rng.normal(0, 0.2);
    seed = chain.clamp(seed);
    const Pose target = chain.forward(q);
    const auto nearest = kinematics.nearest_solution(target, seed, patient());
    ASSERT_TRUE(nearest) << to_string(nearest.error().reason);
    EXPECT_TRUE(chain.within_limits(nearest->joints));
    EXPECT_LT(position_error(target, chain.forward(nearest->joints)), 2e-5);
    EXPECT_LE((nearest->joints - seed).norm(), (q - seed).norm() + 1e-4) << "case " << i;
  }
}

TEST(NearestSolution, IsNoFartherThanAnyOther) {
  const InverseKinematics kinematics(baxter_arm("left"));
  const ArmChain& chain = kinematics.chain();
  Rng rng(46);
  for (int i = 0; i < 15; ++i) {
    const Pose target = chain.forward(random_joints(chain, rng));
    const JointVector seed = random_joints(chain, rng);
    const auto nearest = kinematics.nearest_solution(target, seed, patient());
    ASSERT_TRUE(nearest);
    for (std::uint64_t k = 1; k <= 20; ++k) {
      IkOptions options;
      options.timeout_s = kInf;
      options.rng_seed = 100 + k;
      const auto other = kinematics.solve(target, random_joints(chain, rng), options);
      ASSERT_TRUE(other);
      EXPECT_LE((nearest->joints - seed).norm(), (other->joints - seed).norm() + 1e-4);
    }
  }
}

}  // namespace
}  // namespace extperfc::arm
