// Why there is no solution.
#include <limits>

#include <gtest/gtest.h>

#include "test/unit/arm/kinematics/arms.hpp"

namespace extperfc::arm {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

const InverseKinematics& left() {
  static const InverseKinematics kinematics(baxter_arm("left"));
  return kinematics;
}

IkOptions patient() {
  IkOptions options;
  options.timeout_s = kInf;
  return options;
}

IkFailure failure_of(const Pose& target, const IkOptions& options = patient()) {
  const auto result = left().solve(target, left().chain().mid_range(), options);
  EXPECT_FALSE(result);
  return result ? IkFailure{} : result.error();
}

TEST(IkFailure, NamesTheReasons) {
  EXPECT_STREQ(to_string(IkReason::kInvalid), "invalid");
  EXPECT_STREQ(to_string(IkReason::kOutOfReach), "out_of_reach");
  EXPECT_STREQ(to_string(IkReason::kLimits), "limits");
  EXPECT_STREQ(to_string(IkReason::kCollision), "collision");
  EXPECT_STREQ(to_string(IkReason::kTimeout), "timeout");
}

TEST(IkFailure, ProvesThatATargetIsTooFar) {
  for (const double x : {2.0, 10.0, 1e6, 1e200}) {
    const IkFailure failure = failure_of(make_pose({x, 0.3, 0.2}));
    EXPECT_EQ(failure.reason, IkReason::kOutOfReach) << x;
    EXPECT_TRUE(failure.proven) << x;
    ASSERT_EQ(failure.closest.size(), 7);
    EXPECT_TRUE(left().chain().within_limits(failure.closest));
  }
  const IkFailure near_miss = failure_of(make_pose({2.0, 0.3, 0.2}));
  EXPECT_NEAR(near_miss.position_error_m,
              position_error(make_pose({2.0, 0.3, 0.2}), left().chain().forward(near_miss.closest)), 1e-9);
  EXPECT_LT(near_miss.position_error_m, 1.2);  // the arm stretches towards it
}

/// The proof never denies what is reachable, and holds beside the search.
TEST(IkFailure, NeverProvesAReachableTargetToBeFar) {
  Rng rng(31);
  const auto wrist = ArmChain::make(baxter(), "base_link", "right_lower_forearm").value();
  for (const ArmChain& chain : {left().chain(), baxter_arm("right"), wrist}) {
    const InverseKinematics kinematics(chain);
    IkOptions one = patient();
    one.max_restarts = 0;
    for (int i = 0; i < 2000; ++i) {
      const JointVector q = random_joints(chain, rng);
      const auto result = kinematics.solve(chain.forward(q), q, one);
      ASSERT_TRUE(result) << i;
    }
    JointVector straight = chain.mid_range();
    straight[3] = std::max(0.0, chain.limits().lower[3]);
    EXPECT_TRUE(kinematics.solve(chain.forward(straight), straight, one));
  }
}

TEST(IkFailure, SaysWhenOnlyTheLimitsForbidIt) {
  const ArmChain& chain = left().chain();
  Rng rng(32);
  int limits = 0, solved = 0;
  for (int i = 0; i < 40; ++i) {
    JointVector q = random_joints(chain, rng);
    q[3] = -rng.uniform(1.0, 2.0);  // the elbow bent backwards
    q[1] = rng.uniform(1.2, 2.0);   // the shoulder lower than it can
    const auto result = left().solve(chain.forward(q), chain.mid_range(), patient());
    if (result) {
      ++solved;
      EXPECT_TRUE(chain.within_limits(result->joints));
      continue;
    }
    EXPECT_EQ(result.error().reason, IkReason::kLimits) << to_string(result.error().reason);
    EXPECT_FALSE(result.error().proven);
    EXPECT_EQ(result.error().restarts, patient().max_restarts);
    ++limits;
  }
  EXPECT_GT(limits, 0) << solved << " of 40 can be reached otherwise";
}

/// Links of 0.5 m and 0.3 m in a plane leave out the 0.2 m around the base.
TEST(IkFailure, SaysWhenNothingIsFoundWithoutLimitsEither) {
  const InverseKinematics kinematics(
      chain_of(link("base") + link("upper") + link("lower") + link("tip") +
                   joint("q1", "revolute", "base", "upper", "<axis xyz='0 0 1'/>" + limit(-3, 3)) +
                   joint("q2", "revolute", "upper", "lower",
                         origin("0.5 0 0") + "<axis xyz='0 0 1'/>" + limit(-2.5, 2.5)) +
                   joint("end", "fixed", "lower", "tip", origin("0.3 0 0")),
               "tip"));
  IkOptions options = patient();
  options.tolerance.orientation_rad.setConstant(kInf);
  const auto inside = kinematics.solve(make_pose({0.1, 0, 0}), JointVector::Zero(2), options);
  ASSERT_FALSE(inside);
  EXPECT_EQ(inside.error().reason, IkReason::kOutOfReach) << to_string(inside.error().reason);
  EXPECT_FALSE(inside.error().proven);
  // Nearest with the elbow at its limit: law of cosines at 2.5 rad.
  const double nearest = std::sqrt(0.34 + 0.3 * std::cos(2.5));
  EXPECT_NEAR(inside.error().position_error_m, nearest - 0.1, 1e-3);
  // Beyond the elbow's limit but not beyond the links.
  const auto folded = kinematics.solve(make_pose({0.22, 0, 0}), JointVector::Zero(2), options);
  ASSERT_FALSE(folded);
  EXPECT_EQ(folded.error().reason, IkReason::kLimits) << to_string(folded.error().reason);
  const auto outside = kinematics.solve(make_pose({0.8001, 0, 0}), JointVector::Zero(2), options);
  ASSERT_FALSE(outside);
  EXPECT_EQ(outside.error().reason, IkReason::kOutOfReach);
  EXPECT_TRUE(outside.error().proven);
}

TEST(IkFailure, SaysWhenEverySolutionWasRefused) {
  const ArmChain& chain = left().chain();
  const Pose target = chain.forward(chain.mid_range());
  IkOptions options = patient();
  options.max_restarts = 20;
  int asked = 0;
  options.accept = [&](const JointVector& q) {
    ++asked;
    EXPECT_LT(position_error(chain.forward(q), target), 2e-5);
    return false;
  };
  const IkFailure failure = failure_of(target, options);
  EXPECT_EQ(failure.reason, IkReason::kCollision);
  EXPECT_EQ(failure.refused, asked);
  EXPECT_GT(asked, 1);
  EXPECT_LT(position_error(chain.forward(failure.closest), target), 2e-5);
}

TEST(IkFailure, GoesOnUntilASolutionIsAccepted) {
  const ArmChain& chain = left().chain();
  const Pose target = chain.forward(chain.mid_range());
  for (const IkObjective objective : {IkObjective::kNone, IkObjective::kNearSeed, IkObjective::kMidRange}) {
    IkOptions options = patient();
    options.objective = objective;
    options.accept = [&](const JointVector& q) { return q[2] > 0.3; };
    const auto result = left().solve(target, chain.mid_range(), options);
    ASSERT_TRUE(result) << to_string(result.error().reason);
    EXPECT_GT(result->joints[2], 0.3);
  }
}

TEST(IkFailure, SaysWhenTheTimeIsUp) {
  const ArmChain& chain = left().chain();
  Rng rng(33);
  IkOptions options;
  options.timeout_s = 0;
  int late = 0;
  for (int i = 0; i < 100; ++i) {
    const auto result = left().solve(chain.forward(random_joints(chain, rng)), chain.mid_range(), options);
    if (result) continue;  // the first descent is never cut off before its first steps
    EXPECT_EQ(result.error().reason, IkReason::kTimeout);
    EXPECT_EQ(result.error().restarts, 0);
    EXPECT_EQ(result.error().closest.size(), 7);
    ++late;
  }
  EXPECT_GT(late, 0);
}

TEST(IkFailure, RefusesBadInput) {
  const ArmChain& chain = left().chain();
  const Pose good = chain.forward(chain.mid_range());
  Pose bad = good;
  bad.translation().x() = kNan;
  EXPECT_EQ(failure_of(bad).reason, IkReason::kInvalid);
  bad = good;
  bad.translation().y() = kInf;
  EXPECT_EQ(failure_of(bad).reason, IkReason::kInvalid);
  bad = good;
  bad.linear()(1, 1) = kNan;
  EXPECT_EQ(failure_of(bad).reason, IkReason::kInvalid);
  bad = good;
  bad.linear() *= 1.01;
  EXPECT_EQ(failure_of(bad).reason, IkReason::kInvalid);
  bad = good;
  bad.linear().col(0) *= -1;
  EXPECT_EQ(failure_of(bad).reason, IkReason::kInvalid);
  EXPECT_TRUE(failure_of(bad).proven);

  JointVector seed = chain.mid_range();
  seed[4] = kNan;
  EXPECT_EQ(left().solve(good, seed).error().reason, IkReason::kInvalid);
  EXPECT_EQ(left().solve(good, JointVector::Zero(6)).error().reason, IkReason::kInvalid);
}

TEST(IkFailure, RefusesBadOptions) {
  const ArmChain& chain = left().chain();
  const Pose good = chain.forward(chain.mid_range());
  std::vector<IkOptions> bad(5, patient());
  bad[0].tolerance.position_m.x() = 0;
  bad[1].tolerance.orientation_rad.z() = kNan;
  bad[2].timeout_s = -1;
  bad[3].timeout_s = kNan;
  bad[4].max_restarts = -1;
  for (const IkOptions& options : bad) EXPECT_EQ(failure_of(good, options).reason, IkReason::kInvalid);
}

}  // namespace
}  // namespace extperfc::arm
