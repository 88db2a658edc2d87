// What is proven of the spline that a controller follows is free wherever it is looked at.
#include <cmath>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/arm/timed_path.hpp"
#include "extperfc/base/rng.hpp"

#include "arm/motion/spline_proof.hpp"
#include "test/unit/arm/motion/baxter_arms.hpp"

namespace extperfc::arm {
namespace {

constexpr double kLook_s = 1e-3;

/// The left arm over a table, with a post on it.
class SplineProof : public testing::Test {
 protected:
  SplineProof() {
    CollisionWorld world = test::table_world(0.75);
    Shape post;
    post.geometry = Cylinder{0.05, 0.5};
    if (auto added = world.add({"post", {post}, make_pose({0.75, 0.35, 1.0})}); !added)
      throw std::runtime_error(added.error().message);
    checker_.emplace(pipeline_.checker("left_arm", test::standing("neutral"), world, false).value());
  }

  [[nodiscard]] const std::vector<std::string>& joints() const { return checker_->model().joint_names(); }

  TrajectoryPoint random_point(double time_s, Rng& rng) const {
    TrajectoryPoint point{time_s, neutral(), JointVector(7), std::nullopt};
    for (auto& value : point.position) value += rng.uniform(-0.6, 0.6);
    for (auto& value : point.velocity) value = rng.uniform(-1.5, 1.5);
    return point;
  }

  [[nodiscard]] JointVector neutral() const {
    return RobotArms::select(**test::baxter_arms().group("left_arm"), test::standing("neutral")).value();
  }

  MotionPipeline pipeline_{test::baxter_arms(), {}};
  std::optional<CollisionChecker> checker_;
};

TEST_F(SplineProof, WhatIsProvenIsFreeAndMostOfWhatIsFreeIsProven) {
  Rng rng(5);
  int proven = 0, in_part = 0, refused = 0;
  for (int i = 0; i < 150; ++i) {
    const auto path = TimedPath::make(joints(), {random_point(0, rng), random_point(1, rng)}).value();
    const double until_s = path.free_until(*checker_, 0);
    for (double t = 0; t < until_s; t += kLook_s)
      ASSERT_TRUE(checker_->is_free(path.position(t))) << "spline " << i << " at " << t << " of " << until_s;
    const bool free_behind = checker_->is_free(path.position(std::min(until_s + 0.02, 1.0)));
    proven += until_s >= 1 ? 1 : 0;
    in_part += until_s > 0 && until_s < 1 ? 1 : 0;
    refused += until_s < 1 && free_behind ? 1 : 0;
  }
  EXPECT_GT(proven, 20);
  EXPECT_GT(in_part, 20);
  EXPECT_LT(refused, in_part / 5) << "proofs end long before a collision";
}

TEST_F(SplineProof, BeginsWhereItIsAsked) {
  Rng rng(6);
  for (int i = 0; i < 50; ++i) {
    const auto path =
        TimedPath::make(joints(), {random_point(0, rng), random_point(1, rng), random_point(2, rng)}).value();
    const double begin_s = rng.uniform(0, 2);
    const double until_s = path.free_until(*checker_, begin_s);
    EXPECT_GE(until_s, begin_s);
    for (double t = begin_s; t < until_s; t += kLook_s) ASSERT_TRUE(checker_->is_free(path.position(t)));
  }
}

TEST_F(SplineProof, ABulgeIsSeenThoughItsEndsAreFree) {
  // Ends in one place, free; the velocities bring the arm far down in between.
  TrajectoryPoint start{0, neutral(), JointVector::Zero(7), std::nullopt};
  start.velocity[1] = 4;
  TrajectoryPoint end{1, neutral(), -start.velocity, std::nullopt};
  ASSERT_TRUE(checker_->is_free(neutral()));
  const auto path = TimedPath::make(joints(), {start, end}).value();
  ASSERT_FALSE(checker_->is_free(path.position(0.5)));
  const double until_s = path.free_until(*checker_, 0);
  double contact_s = 0;
  while (checker_->is_free(path.position(contact_s))) contact_s += kLook_s;
  EXPECT_LT(until_s, contact_s);
  EXPECT_GT(until_s, contact_s - 0.03);
}

}  // namespace
}  // namespace extperfc::arm
