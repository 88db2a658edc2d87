// What a spline through knots must be: through them, smooth where it must be, equal to what it is made
// of.
#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/simulate/joint_spline.hpp"

namespace extperfc::simulate {
namespace {

constexpr double kTiny = 1e-9;

Eigen::VectorXd vector(std::initializer_list<double> values) {
  Eigen::VectorXd result(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), result.begin());
  return result;
}

/// Any knots of three joints, with velocities and accelerations if wanted.
std::vector<JointKnot> random_knots(Rng& rng, bool velocities, bool accelerations) {
  const auto random = [&] { return vector({rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(-2, 2)}); };
  std::vector<JointKnot> knots;
  double time_s = rng.uniform(-1, 1);
  for (int i = 0; i < 5; ++i) {
    JointKnot knot{time_s, random(), std::nullopt, std::nullopt};
    if (velocities) knot.velocity = random();
    if (accelerations) knot.acceleration = random();
    knots.push_back(knot);
    time_s += rng.uniform(0.1, 1.5);
  }
  return knots;
}

TEST(JointSpline, GoesThroughItsKnots) {
  Rng rng(7);
  for (const bool velocities : {false, true}) {
    for (const bool accelerations : {false, velocities}) {
      const auto knots = random_knots(rng, velocities, accelerations);
      const JointSpline spline(knots);
      EXPECT_EQ(spline.start_s(), knots.front().time_s);
      EXPECT_EQ(spline.end_s(), knots.back().time_s);
      for (const auto& knot : knots) {
        for (const double beside : {-1e-10, 1e-10}) {  // from both parts that meet there
          const auto motion = spline.sample(knot.time_s + beside);
          EXPECT_TRUE(motion.position.isApprox(knot.position, 1e-8)) << knot.time_s;
        }
      }
    }
  }
}

TEST(JointSpline, KeepsVelocityAndAccelerationOfItsKnots) {
  Rng rng(8);
  const auto knots = random_knots(rng, true, true);
  const JointSpline spline(knots);
  for (std::size_t i = 1; i + 1 < knots.size(); ++i) {
    for (const double beside : {-1e-10, 1e-10}) {
      const auto motion = spline.sample(knots[i].time_s + beside);
      EXPECT_TRUE(motion.velocity.isApprox(*knots[i].velocity, 1e-7));
      EXPECT_TRUE(motion.acceleration.isApprox(*knots[i].acceleration, 1e-6));
    }
  }
}

TEST(JointSpline, DerivativesAreThoseOfThePosition) {
  Rng rng(9);
  constexpr double kStep = 1e-5;
  for (const bool accelerations : {false, true}) {
    const JointSpline spline(random_knots(rng, true, accelerations));
    for (int i = 0; i < 200; ++i) {
      const double t = rng.uniform(spline.start_s() + 0.01, spline.end_s() - 0.01);
      const auto before = spline.sample(t - kStep);
      const auto after = spline.sample(t + kStep);
      const auto motion = spline.sample(t);
      EXPECT_LT(((after.position - before.position) / (2 * kStep) - motion.velocity).norm(), 1e-3) << t;
      if (accelerations) {
        EXPECT_LT(((after.velocity - before.velocity) / (2 * kStep) - motion.acceleration).norm(), 0.2) << t;
      }
    }
  }
}

TEST(JointSpline, RebuildsACubicFromTwoOfItsPoints) {
  const auto position = [](double t) { return 1 - 2 * t + 3 * t * t - 0.5 * t * t * t; };
  const auto velocity = [](double t) { return -2 + 6 * t - 1.5 * t * t; };
  const JointSpline spline({{1, vector({position(1)}), vector({velocity(1)}), std::nullopt},
                            {3, vector({position(3)}), vector({velocity(3)}), std::nullopt}});
  for (double t = 1; t < 3; t += 0.1) {
    EXPECT_NEAR(spline.sample(t).position[0], position(t), kTiny) << t;
    EXPECT_NEAR(spline.sample(t).velocity[0], velocity(t), kTiny) << t;
    EXPECT_NEAR(spline.sample(t).acceleration[0], 6 - 3 * t, kTiny) << t;
  }
}

TEST(JointSpline, RebuildsAQuinticFromTwoOfItsPoints) {
  const auto position = [](double t) { return 2 + t - t * t + 0.3 * std::pow(t, 4) - 0.1 * std::pow(t, 5); };
  const auto velocity = [](double t) { return 1 - 2 * t + 1.2 * std::pow(t, 3) - 0.5 * std::pow(t, 4); };
  const auto acceleration = [](double t) { return -2 + 3.6 * t * t - 2 * std::pow(t, 3); };
  const auto knot = [&](double t) {
    return JointKnot{t, vector({position(t)}), vector({velocity(t)}), vector({acceleration(t)})};
  };
  const JointSpline spline({knot(-1), knot(0.5), knot(2)});
  for (double t = -1; t < 2; t += 0.1) {
    EXPECT_NEAR(spline.sample(t).position[0], position(t), kTiny) << t;
    EXPECT_NEAR(spline.sample(t).velocity[0], velocity(t), kTiny) << t;
    EXPECT_NEAR(spline.sample(t).acceleration[0], acceleration(t), 10 * kTiny) << t;
  }
}

TEST(JointSpline, IsStraightWhereAVelocityIsMissing) {
  const JointSpline spline({{0, vector({0}), vector({5}), std::nullopt},
                            {2, vector({4}), std::nullopt, std::nullopt},
                            {3, vector({4}), vector({0}), std::nullopt}});
  EXPECT_NEAR(spline.sample(0.5).position[0], 1, kTiny);
  EXPECT_NEAR(spline.sample(0.5).velocity[0], 2, kTiny);
  EXPECT_NEAR(spline.sample(2.5).velocity[0], 0, kTiny);
}

TEST(JointSpline, RestsBeforeAndAfter) {
  const JointSpline spline(
      {{1, vector({0.5}), vector({5}), std::nullopt}, {2, vector({4}), vector({5}), std::nullopt}});
  EXPECT_EQ(spline.sample(0.9).position[0], 0.5);
  EXPECT_EQ(spline.sample(0.9).velocity[0], 0);
  EXPECT_EQ(spline.sample(2.1).position[0], 4);
  EXPECT_EQ(spline.sample(2.1).velocity[0], 0);
}

TEST(JointSpline, OneKnotIsAPlace) {
  const JointSpline spline({{1, vector({0.5, -0.5}), std::nullopt, std::nullopt}});
  for (const double t : {0.0, 1.0, 2.0}) {
    EXPECT_EQ(spline.sample(t).position, vector({0.5, -0.5}));
    EXPECT_EQ(spline.sample(t).velocity, vector({0, 0}));
  }
}

}  // namespace
}  // namespace extperfc::simulate
