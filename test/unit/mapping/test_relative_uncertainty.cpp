#include <cmath>

#include <gtest/gtest.h>

#include "mapping/relative_uncertainty.hpp"

namespace extperfc::mapping {
namespace {

constexpr double kSigmaM = 0.01;
constexpr double kSigmaRad = 0.002;

Eigen::Matrix3d information(double sigma_m, double sigma_rad) {
  return Eigen::Vector3d(1 / (sigma_m * sigma_m), 1 / (sigma_m * sigma_m), 1 / (sigma_rad * sigma_rad))
      .asDiagonal();
}

/// `steps` steps of a metre straight ahead along `yaw`.
PoseGraph straight(std::size_t steps, double yaw) {
  PoseGraph graph;
  graph.add_node({2, -1, yaw});
  for (std::size_t i = 0; i < steps; ++i) {
    graph.add_node(compose(graph.poses().back(), {1, 0, 0}));
    graph.add({i, i + 1, {1, 0, 0}, information(kSigmaM, kSigmaRad), false});
  }
  return graph;
}

// Along a straight chain of n steps of length l: n s^2 along it, and across it the sum of (k l s_yaw)^2 for
// k = 0 ... n - 1 besides.
TEST(RelativeUncertainty, GrowsAlongAChainAsInClosedForm) {
  constexpr std::size_t kSteps = 20;
  const auto known = relative_uncertainty(straight(kSteps, 0.7), 0);
  ASSERT_EQ(known.size(), kSteps + 1);
  EXPECT_TRUE(known[0].covariance.isZero());
  for (std::size_t n = 1; n <= kSteps; ++n) {
    const auto count = static_cast<double>(n);
    double lever = 0;
    for (std::size_t k = 0; k < n; ++k) lever += static_cast<double>(k * k) * kSigmaRad * kSigmaRad;
    EXPECT_TRUE(known[n].connected);
    EXPECT_NEAR(known[n].covariance(0, 0), count * kSigmaM * kSigmaM, 1e-9);
    EXPECT_NEAR(known[n].covariance(1, 1), count * kSigmaM * kSigmaM + lever, 1e-9);
    EXPECT_NEAR(known[n].covariance(2, 2), count * kSigmaRad * kSigmaRad, 1e-9);
    EXPECT_GT(known[n].systematic_m, known[n - 1].systematic_m);
    EXPECT_GE(known[n].reach_m(), 3 * std::sqrt(known[n].covariance(1, 1)));
  }
}

TEST(RelativeUncertainty, IsTheSameInWhateverDirectionTheMapLies) {
  const auto one = relative_uncertainty(straight(12, 0), 3);
  const auto other = relative_uncertainty(straight(12, -2.5), 3);
  for (std::size_t i = 0; i < one.size(); ++i)
    EXPECT_LT((one[i].covariance - other[i].covariance).norm(), 1e-9) << i;
}

TEST(RelativeUncertainty, ALoopClosureIsAShortCut) {
  auto graph = straight(40, 0);
  const double open = relative_uncertainty(graph, 0)[40].reach_m();
  graph.add({0, 40, between(graph.poses()[0], graph.poses()[40]), information(0.02, 0.005), true});
  const auto closed = relative_uncertainty(graph, 0);
  EXPECT_LT(closed[40].reach_m(), 0.5 * open);
  EXPECT_NEAR(closed[40].covariance(0, 0), 0.02 * 0.02, 1e-9);
  EXPECT_LT(closed[38].reach_m(), 0.5 * open) << "from behind, too";
}

TEST(RelativeUncertainty, AContradictedLoopClosureIsNoLink) {
  auto graph = straight(40, 0);
  const auto open = relative_uncertainty(graph, 0);
  graph.add({0, 40, {35, 3, 0}, information(0.02, 0.005), true});
  const auto still = relative_uncertainty(graph, 0);
  EXPECT_EQ(still[40].covariance, open[40].covariance);
}

TEST(RelativeUncertainty, ExtendedStepByStepItIsTheSame) {
  const auto graph = straight(15, 0.4);
  const auto known = relative_uncertainty(graph, 0);
  RelativeUncertainty last = known[0];
  for (const Constraint& constraint : graph.constraints()) last = extend(last, graph, constraint);
  EXPECT_LT((last.covariance - known[15].covariance).norm(), 1e-9);
  EXPECT_NEAR(last.systematic_m, known[15].systematic_m, 1e-9);
  EXPECT_GT(last.sigma_m(), std::sqrt(last.covariance(1, 1))) << "the bias counts, too";
}

TEST(RelativeUncertainty, WithoutAChainNothingIsKnown) {
  auto graph = straight(3, 0);
  graph.add_node({9, 9, 0});
  EXPECT_FALSE(relative_uncertainty(graph, 0)[4].connected);
}

}  // namespace
}  // namespace extperfc::mapping
