#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"

#include "test/unit/arm/constrained/level_arm.hpp"

namespace extperfc::arm {
namespace {

using test::both_arms;
using test::constraint_on;
using test::left_arm;
using test::on;
using test::random_state;
using Kind = ToolConstraintKind;

struct Case {
  std::string name;
  PathConstraint constraint;
};

/// Every kind on both arms, and several at once; targets from a random state.
std::vector<Case> cases(std::uint64_t seed) {
  Rng rng(seed);
  const auto& model = both_arms();
  const JointVector reference = random_state(model.limits(), rng);
  const Eigen::Vector3d axis(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
  const ToolConstraint keep_axis{Kind::kKeepAxis, "left_gripper", "", axis, {}};
  const ToolConstraint keep_plane{Kind::kKeepPlane, "right_gripper", "", axis, {}};
  const ToolConstraint keep_line{Kind::kKeepLine, "left_gripper", "", axis, {}};
  const ToolConstraint keep_orientation{Kind::kKeepOrientation, "right_hand", "", axis, {}};
  const ToolConstraint keep_relative{Kind::kKeepRelative, "right_gripper", "left_gripper", axis, {}};
  const ToolConstraint keep_fixed{Kind::kKeepRelative, "right_gripper", "head", axis, {}};
  return {{"axis", constraint_on(model, {keep_axis}, reference)},
          {"plane", constraint_on(model, {keep_plane}, reference)},
          {"line", constraint_on(model, {keep_line}, reference)},
          {"orientation", constraint_on(model, {keep_orientation}, reference)},
          {"relative", constraint_on(model, {keep_relative}, reference)},
          {"relative to a standing link", constraint_on(model, {keep_fixed}, reference)},
          {"axis and plane", constraint_on(model, {keep_axis, keep_plane}, reference)},
          {"relative and axis", constraint_on(model, {keep_relative, keep_axis}, reference)}};
}

// Central differences err by h^2 F''' / 6 and by rounding 1e-16 / h: 1e-9 with h = 1e-5 and third derivatives
// up to 60 (which the rotation vector has well below the half turn).
TEST(PathConstraint, JacobiansAreThoseOfTheResiduals) {
  constexpr double kStep = 1e-5;
  Rng rng(1);
  for (std::uint64_t seed = 1; seed <= 5; ++seed)
    for (const auto& [name, constraint] : cases(seed))
      for (int i = 0; i < 20; ++i) {
        const JointVector at = random_state(both_arms().limits(), rng);
        if (constraint.error(at) > 2.8) continue;
        ConstraintResidual residual;
        const auto jacobian = constraint.jacobian(at, &residual);
        EXPECT_EQ(residual, constraint.residual(at));
        for (Eigen::Index j = 0; j < at.size(); ++j) {
          JointVector more = at, less = at;
          more[j] += kStep;
          less[j] -= kStep;
          const ConstraintResidual slope =
              (constraint.residual(more) - constraint.residual(less)) / (2 * kStep);
          EXPECT_LT((slope - jacobian.col(j)).cwiseAbs().maxCoeff(), 2e-8) << name << ", joint " << j;
        }
      }
}

TEST(PathConstraint, TheReferenceKeepsEveryKind) {
  Rng rng(7);  // as in cases(7)
  const JointVector reference = random_state(both_arms().limits(), rng);
  for (const auto& [name, constraint] : cases(7)) {
    EXPECT_LT(constraint.error(reference), 1e-7) << name;
    EXPECT_LT(constraint.residual(reference).norm(), 1e-7) << name;
  }
}

// Errors against the kinematics of RobotModel, which share no code with ArmChain.
TEST(PathConstraint, ErrorsAreDistancesAndAngles) {
  const auto& model = left_arm();
  Rng rng(3);
  const JointVector reference = random_state(model.limits(), rng);
  const Eigen::Vector3d axis(1, 2, -1);
  const Pose target = *model.link_pose(reference, "left_gripper");
  const auto of = [&](Kind kind) {
    return constraint_on(model, {{kind, "left_gripper", "", axis, {}}}, reference);
  };
  const auto plane = of(Kind::kKeepPlane), line = of(Kind::kKeepLine), tool = of(Kind::kKeepAxis),
             orientation = of(Kind::kKeepOrientation);
  for (int i = 0; i < 50; ++i) {
    const JointVector at = random_state(model.limits(), rng);
    const Pose pose = *model.link_pose(at, "left_gripper");
    const Eigen::Vector3d away = pose.translation() - target.translation();
    const Eigen::Vector3d unit = axis.normalized();
    EXPECT_NEAR(plane.error(at), std::abs(away.dot(unit)), 1e-9);
    EXPECT_NEAR(line.error(at), away.cross(unit).norm(), 1e-9);
    const Eigen::Vector3d now = pose.linear() * unit, then = target.linear() * unit;
    EXPECT_NEAR(tool.error(at), std::atan2(now.cross(then).norm(), now.dot(then)), 1e-7);
    const Eigen::AngleAxisd rotation(target.linear().transpose() * pose.linear());
    EXPECT_NEAR(orientation.error(at), rotation.angle(), 1e-6);
    for (const auto* constraint : {&plane, &line, &tool, &orientation})
      EXPECT_NEAR(constraint->residual(at).norm(), constraint->error(at), 1e-6);
  }
}

TEST(PathConstraint, AReversedAxisIsAnErrorOfPi) {
  const auto& model = left_arm();
  const auto down = constraint_on(model, {test::level()});
  const JointVector at = down.project(JointVector::Zero(7), model.limits()).value();
  auto rotated = test::level();
  rotated.target = Pose::Identity();
  const auto up = constraint_on(model, {rotated});
  EXPECT_NEAR(up.error(at), kPi, 1e-3);
  EXPECT_NEAR(up.residual(at).norm(), kPi, 1e-3);
  EXPECT_TRUE(up.jacobian(at).allFinite());
}

TEST(PathConstraint, TheBoundOfASegmentHolds) {
  Rng rng(11);
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    for (const auto& [name, constraint] : cases(seed))
      for (int i = 0; i < 30; ++i) {
        const JointVector from = random_state(both_arms().limits(), rng);
        const JointVector delta =
            random_state(both_arms().limits(), rng).normalized() * rng.uniform(0.01, 0.5);
        const double bound = constraint.segment_error(from, from + delta);
        for (int s = 0; s <= 40; ++s)
          EXPECT_LE(constraint.error(from + delta * (s / 40.0)), bound + 1e-12)
              << name << " " << delta.norm();
      }
}

// The bound is of use only when it is close to the truth: on segments of 0.03 rad between states that keep
// the constraint it exceeds the largest error by the cubic term alone, which is 0.008 (sum |d_j|)^3 times a
// reach of up to 6 m (both arms).
TEST(PathConstraint, TheBoundOfAShortSegmentIsTight) {
  Rng rng(13);
  int looked = 0;
  for (const auto& [name, constraint] : cases(2))
    for (int i = 0; i < 20; ++i) {
      const auto& limits = both_arms().limits();
      const auto from = constraint.project(random_state(limits, rng), limits);
      if (!from) continue;
      const auto to = constraint.project(*from + random_state(limits, rng).normalized() * 0.03, limits);
      if (!to || (*to - *from).norm() > 0.05) continue;
      double worst = 0;
      for (int s = 0; s <= 50; ++s)
        worst = std::max(worst, constraint.error(*from + (*to - *from) * (s / 50.0)));
      const double rotating = (*to - *from).cwiseAbs().sum();
      EXPECT_LT(constraint.segment_error(*from, *to),
                1.01 * worst + 0.0081 * 6 * std::pow(rotating, 3) + 1e-7)
          << name;
      EXPECT_GE(constraint.segment_error(*from, *to, 2e-8) + 1e-12, worst) << name;
      ++looked;
    }
  EXPECT_GT(looked, 50);
}

TEST(PathConstraint, TheBoundHoldsWithAJointThatSlides) {
  const std::string urdf =
      "<robot name='slider'><link name='base'/><link name='a'/><link name='b'/><link name='c'/>"
      "<joint name='turn' type='revolute'><parent link='base'/><child link='a'/><axis xyz='0 0 1'/>"
      "<limit lower='-3' upper='3' velocity='1' effort='1'/></joint>"
      "<joint name='slide' type='prismatic'><parent link='a'/><child link='b'/><origin xyz='0.3 0 0'/>"
      "<axis xyz='1 0 0'/><limit lower='0' upper='2' velocity='1' effort='1'/></joint>"
      "<joint name='wrist' type='revolute'><parent link='b'/><child link='c'/><origin xyz='0.2 0 0'/>"
      "<axis xyz='0 1 0'/><limit lower='-3' upper='3' velocity='1' effort='1'/></joint></robot>";
  const auto robot = RobotModel::from_urdf(urdf, ".").value();
  PathConstraintParams params;
  params.joints = {"turn", "slide", "wrist"};
  params.reference = JointVector::Ones(3);
  params.constraints = {{Kind::kKeepLine, "c", "", Eigen::Vector3d(1, 1, 0), {}}};
  const auto constraint = PathConstraint::make(robot, params).value();
  Rng rng(5);
  for (int i = 0; i < 200; ++i) {
    JointVector from(3), delta(3);
    for (int j = 0; j < 3; ++j) {
      from[j] = rng.uniform(0, 2);
      delta[j] = rng.uniform(-0.7, 0.7);
    }
    const double bound = constraint.segment_error(from, from + delta);
    for (int s = 0; s <= 20; ++s) EXPECT_LE(constraint.error(from + delta * (s / 20.0)), bound + 1e-12);
  }
}

TEST(PathConstraint, TheErrorGrowsNoFasterThanTheSteepness) {
  Rng rng(17);
  for (const auto& [name, constraint] : cases(4))
    for (int i = 0; i < 20; ++i) {
      const auto& limits = both_arms().limits();
      const auto from = constraint.project(random_state(limits, rng), limits);
      if (!from) continue;
      const double steepness = constraint.steepness(*from, 0.05);
      for (int k = 0; k < 20; ++k) {
        const JointVector away = random_state(limits, rng).normalized() * rng.uniform(0, 0.05);
        EXPECT_LE(constraint.error(*from + away), steepness * away.norm() + 1e-7) << name;
      }
    }
}

TEST(PathConstraint, ProjectionKeepsConstraintAndLimits) {
  Rng rng(19);
  for (const auto& [name, constraint] : cases(3)) {
    const auto& limits = both_arms().limits();
    int found = 0;
    for (int i = 0; i < 50; ++i) {
      const auto state = constraint.project(random_state(limits, rng), limits);
      if (!state) continue;
      ++found;
      EXPECT_LE(constraint.error(*state), 1e-8) << name;
      EXPECT_TRUE((state->array() >= limits.lower.array()).all() &&
                  (state->array() <= limits.upper.array()).all())
          << name;
    }
    EXPECT_GE(found, 10) << name;  // Newton's method needs no restart that often
  }
}

TEST(PathConstraint, ProjectionGoesToTheNearestStateNearby) {
  const auto& model = left_arm();
  const auto constraint = constraint_on(model, {test::level()});
  Rng rng(23);
  const auto at = constraint.project(random_state(model.limits(), rng), model.limits()).value();
  for (int i = 0; i < 50; ++i) {
    const JointVector away = at + random_state(model.limits(), rng).normalized() * 1e-3;
    const auto back = constraint.project(away, model.limits());
    ASSERT_TRUE(back.has_value());
    EXPECT_LE((*back - away).norm(),
              1.01e-3);  // `at` itself is a candidate, the limit's part is second order
  }
}

TEST(PathConstraint, ProjectionRefusesWhatIsNotFinite) {
  const auto& model = left_arm();
  const auto constraint = constraint_on(model, {test::level()});
  JointVector state = JointVector::Zero(7);
  state[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(constraint.project(state, model.limits()).has_value());
  EXPECT_FALSE(constraint.error(state) <= 1e9);
  EXPECT_FALSE(constraint.segment_error(state, state) <= 1e9);
}

TEST(PathConstraint, TangentsKeepTheConstraintToFirstOrder) {
  Rng rng(29);
  for (const auto& [name, constraint] : cases(5))
    for (int i = 0; i < 10; ++i) {
      const auto& limits = both_arms().limits();
      const auto at = constraint.project(random_state(limits, rng), limits);
      if (!at) continue;
      const JointVector wish = random_state(limits, rng);
      const JointVector along = constraint.tangent(*at, wish, limits);
      EXPECT_LT((constraint.jacobian(*at) * along).norm(), 1e-6 * wish.norm()) << name;
      EXPECT_GE(along.dot(wish), -1e-9) << name;
      for (Eigen::Index j = 0; j < at->size(); ++j) {
        EXPECT_FALSE((*at)[j] >= limits.upper[j] && along[j] > 1e-9) << name;
        EXPECT_FALSE((*at)[j] <= limits.lower[j] && along[j] < -1e-9) << name;
      }
    }
}

TEST(PathConstraint, SaysWhatIsWrong) {
  const auto& model = left_arm();
  const auto code = [&](const PathConstraintParams& params) {
    const auto made = PathConstraint::make(test::baxter(), params);
    EXPECT_FALSE(made.has_value());
    return made ? ErrorCode::kFailed : made.error().code;
  };
  EXPECT_EQ(code(on(model, {})), ErrorCode::kInvalidArgument);
  auto constraint = test::level();
  constraint.link = "no_such_link";
  EXPECT_EQ(code(on(model, {constraint})), ErrorCode::kNotFound);
  constraint.link = "right_gripper";  // stands in this group
  EXPECT_EQ(code(on(model, {constraint})), ErrorCode::kInvalidArgument);
  constraint = test::level();
  constraint.axis.setZero();
  EXPECT_EQ(code(on(model, {constraint})), ErrorCode::kInvalidArgument);
  constraint.axis.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(code(on(model, {constraint})), ErrorCode::kInvalidArgument);
  constraint = test::level();
  constraint.target.reset();
  EXPECT_EQ(code(on(model, {constraint})), ErrorCode::kInvalidArgument) << "neither target nor reference";
  EXPECT_EQ(code(on(model, {constraint}, JointVector::Zero(3))), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code(on(model, {constraint}, JointVector::Constant(7, std::nan("")))),
            ErrorCode::kInvalidArgument);
  constraint.target = Pose::Identity();
  constraint.target->linear() *= 2.0;
  EXPECT_EQ(code(on(model, {constraint})), ErrorCode::kInvalidArgument);
  constraint = {Kind::kKeepRelative, "left_gripper", "left_gripper", Eigen::Vector3d::UnitZ(), {}};
  EXPECT_EQ(code(on(model, {constraint}, JointVector::Zero(7))), ErrorCode::kInvalidArgument);
  constraint.other_link = "nothing";
  EXPECT_EQ(code(on(model, {constraint}, JointVector::Zero(7))), ErrorCode::kNotFound);
  EXPECT_EQ(code(on(model, std::vector<ToolConstraint>(13, test::level()))), ErrorCode::kInvalidArgument);
  auto params = on(model, {test::level()});
  params.joints[1] = "no_such_joint";
  EXPECT_EQ(code(params), ErrorCode::kNotFound);
  const auto made = constraint_on(model, {test::level()});
  EXPECT_THROW((void)made.error(JointVector::Zero(6)), std::invalid_argument);
}

}  // namespace
}  // namespace extperfc::arm
