// Motions: what is proven free is free for Bullet every 0.002 rad, and what is free is nearly always proven.
#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "test/unit/arm/collision/baxter.hpp"
#include "test/unit/arm/collision/bullet_oracle.hpp"

namespace extperfc::arm {
namespace {

constexpr double kRecheck = 0.002;  // [rad]

bool oracle_free(test::BulletOracle& oracle, const JointVector& from, const JointVector& to) {
  const int steps = static_cast<int>(std::ceil((to - from).norm() / kRecheck));
  for (int i = 0; i <= steps; ++i)
    if (oracle.collides(from + (to - from) * (static_cast<double>(i) / std::max(1, steps)))) return false;
  return true;
}

struct Score {
  int proven{0};
  int free{0};
  int wrong{0};
};

/// Motions of 0.1 to 2 rad that start free; fewer than asked for in a world that leaves an arm no room at
/// all.
Score score_of(const std::string& group, const CollisionWorld& world, int motions, Rng& rng,
               bool spheres = true) {
  const auto params = test::group_params(group);
  const auto model = CollisionModel::make(test::baxter(), params).value();
  CollisionChecker checker = CollisionChecker::make(model, world, {1e-3, spheres}).value();
  test::BulletOracle oracle(test::baxter(), params, world);
  Score score;
  const int draws = 40 * motions;
  for (int draw = 0; draw < draws && motions > 0; ++draw) {
    const JointVector from = test::random_state(model.limits(), rng);
    if (!checker.is_free(from)) continue;
    --motions;
    JointVector delta = JointVector::Zero(model.joint_count());
    double square = 0;
    for (Eigen::Index k = 0; k < delta.size(); ++k) {
      delta[k] = rng.normal(0, 1);
      square += delta[k] * delta[k];
    }
    const double scale = rng.uniform(0.1, 2) / std::sqrt(square);
    const JointVector to = from + scale * delta;
    const bool proven = checker.motion_free(from, to);
    const bool free = oracle_free(oracle, from, to);
    score.proven += proven && free ? 1 : 0;
    score.free += free ? 1 : 0;
    score.wrong += proven && !free ? 1 : 0;
  }
  return score;
}

TEST(Motion, WhatIsProvenIsFreeAndMostOfWhatIsFreeIsProven) {
  Rng rng(21);
  Score all;
  for (int i = 0; i < 6; ++i) {
    const Score score = score_of(i % 2 == 0 ? "left_arm" : "both_arms", test::random_world(10, rng), 25, rng);
    all = {all.proven + score.proven, all.free + score.free, all.wrong + score.wrong};
  }
  RecordProperty("proven", all.proven);
  RecordProperty("free", all.free);
  EXPECT_EQ(0, all.wrong);
  EXPECT_GT(all.free, 30);
  EXPECT_GE(all.proven, 0.9 * all.free);
}

TEST(Motion, HoldsWithThingsInTheHandsAndPadding) {
  Rng rng(22);
  CollisionWorld world = test::random_world(6, rng);
  Shape rod;
  rod.geometry = Cylinder{0.01, 0.3};
  test::must(world.attach({"rod",
                           "left_gripper",
                           {rod},
                           test::random_pose(rng, {0, 0, 0.1}, {0, 0, 0.2}),
                           {"left_gripper_base", "left_hand", "l_gripper_l_finger", "l_gripper_r_finger",
                            "l_gripper_l_finger_tip", "l_gripper_r_finger_tip", "left_wrist"}}));
  const Score score = score_of("both_arms", world, 40, rng);
  EXPECT_EQ(0, score.wrong);
  EXPECT_GT(score.free, 5);
  EXPECT_GE(score.proven, 0.9 * score.free);
}

/// Random motions, some of which are free, among cylinders and cones, where axes are hard to find.
void for_motions_among_round_objects(int motions, Rng& rng,
                                     const std::function<void(const CollisionModel&, const CollisionWorld&,
                                                              const JointVector&, const JointVector&)>& use) {
  const auto model = CollisionModel::make(test::baxter(), test::group_params("left_arm")).value();
  CollisionWorld world;
  for (int i = 0; i < 8; ++i) {
    Shape shape;
    shape.geometry = test::random_geometry(i % 2 == 0 ? 1 : 3, rng);
    test::must(world.add(
        {"round_" + std::to_string(i), {shape}, test::random_pose(rng, {0.3, 0.0, 0.6}, {1.1, 1.0, 1.4})}));
  }
  for (int i = 0; i < motions; ++i) {
    const JointVector from = test::random_state(model.limits(), rng);
    use(model, world, from, from + 0.3 * (test::random_state(model.limits(), rng) - from));
  }
}

TEST(Motion, NoStateOfAProvenMotionIsFoundInContact) {
  Rng rng(27);
  int proven = 0;
  for_motions_among_round_objects(
      400, rng, [&](const auto& model, const auto& world, const auto& from, const auto& to) {
        if (!CollisionChecker::make(model, world).value().motion_free(from, to)) return;
        ++proven;
        // Each state by a checker that has seen nothing before, which would help it.
        for (int i = 0; i <= 20; ++i) {
          CollisionChecker exact = CollisionChecker::make(model, world, {1e-3, false}).value();
          const JointVector state = from + (to - from) * (i / 20.0);
          const auto contact = exact.contact(state);
          EXPECT_FALSE(contact) << contact->first << " and " << contact->second << ", "
                                << exact.nearest(state)->distance_m;
          EXPECT_TRUE(exact.is_free(state));
        }
      });
  EXPECT_GT(proven, 40);
}

TEST(Motion, ADeviationIsProvenFreeToo) {
  constexpr double kDeviation = 0.02;  // [rad]
  Rng rng(28);
  int proven = 0, refused = 0;
  for_motions_among_round_objects(
      400, rng, [&](const auto& model, const auto& world, const auto& from, const auto& to) {
        CollisionChecker checker = CollisionChecker::make(model, world).value();
        const bool straight = checker.motion_free(from, to);
        if (!checker.motion_free(from, to, kDeviation)) {
          refused += straight ? 1 : 0;
          return;
        }
        EXPECT_TRUE(straight);
        ++proven;
        for (int i = 0; i < 100; ++i) {
          JointVector aside(from.size());
          for (auto& value : aside) value = rng.normal(0, 1);
          const JointVector state = from + (to - from) * rng.uniform(0, 1) + kDeviation * aside.normalized();
          EXPECT_TRUE(checker.is_free(state));
        }
      });
  EXPECT_GT(proven, 30);
  EXPECT_GT(refused, 0) << "nothing was near enough to tell the difference";
  EXPECT_THROW((void)CollisionChecker::make(test::group_model("left_arm"), {})
                   .value()
                   .motion_free(JointVector::Zero(7), JointVector::Zero(7), -1),
               std::invalid_argument);
}

TEST(Motion, BulletAloneProvesTheSame) {
  Rng rng(23);
  const CollisionWorld world = test::random_world(6, rng);
  const CollisionModel model = test::group_model("left_arm");
  CollisionChecker spheres = CollisionChecker::make(model, world).value();
  CollisionChecker bullet = CollisionChecker::make(model, world, {1e-3, false}).value();
  int proven = 0;
  for (int i = 0; i < 60; ++i) {
    const JointVector from = test::random_state(model.limits(), rng);
    const JointVector to = from + 0.2 * test::random_state(model.limits(), rng);
    const bool free = spheres.motion_free(from, to);
    proven += free ? 1 : 0;
    EXPECT_EQ(free, bullet.motion_free(from, to));
  }
  EXPECT_GT(proven, 3);
}

// The stretched arm, whose cylinders of 6 cm radius all reach equally high, turns under a plate.
TEST(Motion, HalfAMillimetreDecides) {
  const CollisionModel model = test::group_model("left_arm");
  const JointVector from = JointVector::Zero(7);
  JointVector to = from;
  to[0] = 0.8;
  for (const double gap : {0.0005, -0.0005}) {
    CollisionWorld world;
    Shape plate;
    plate.geometry = Box{{3, 3, 0.02}};
    Pose pose = Pose::Identity();
    pose.translation() = model.link_pose(from, "left_upper_elbow_visual")->translation();
    pose.translation().z() += 0.06 + 0.01 + gap;
    test::must(world.add({"plate", {plate}, pose}));
    CollisionChecker checker = CollisionChecker::make(model, world).value();
    EXPECT_EQ(gap > 0, checker.motion_free(from, to)) << gap;
  }
}

TEST(Motion, FractionEndsBeforeTheCollision) {
  Rng rng(24);
  const CollisionModel model = test::group_model("left_arm");
  const CollisionWorld world = test::random_world(12, rng);
  CollisionChecker checker = CollisionChecker::make(model, world).value();
  test::BulletOracle oracle(test::baxter(), test::group_params("left_arm"), world);
  int partial = 0;
  for (int i = 0; i < 60; ++i) {
    const JointVector from = test::random_state(model.limits(), rng),
                      to = test::random_state(model.limits(), rng);
    const double fraction = checker.free_fraction(from, to);
    if (!checker.is_free(from)) {
      EXPECT_EQ(-1, fraction);
      continue;
    }
    EXPECT_EQ(fraction >= 1, checker.motion_free(from, to));
    partial += fraction > 0 && fraction < 1 ? 1 : 0;
    if (fraction > 0) {
      EXPECT_TRUE(oracle_free(oracle, from, from + fraction * (to - from)));
    }
  }
  EXPECT_GT(partial, 5);
}

TEST(Motion, OfNoLengthIsItsState) {
  const CollisionModel model = test::group_model("left_arm");
  Rng rng(25);
  CollisionChecker checker = CollisionChecker::make(model, test::random_world(8, rng)).value();
  for (int i = 0; i < 50; ++i) {
    const JointVector state = test::random_state(model.limits(), rng);
    EXPECT_EQ(checker.is_free(state), checker.motion_free(state, state));
  }
}

}  // namespace
}  // namespace extperfc::arm
