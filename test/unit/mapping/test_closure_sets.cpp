// Which loop closures of a path are accepted together.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "mapping/closure_sets.hpp"

namespace extperfc::mapping {
namespace {

constexpr std::size_t kSteps = 40;
constexpr std::size_t kBack = 20;  // the path is driven there and back

Eigen::Matrix3d information(double sigma_m, double sigma_rad) {
  return Eigen::Vector3d(1 / (sigma_m * sigma_m), 1 / (sigma_m * sigma_m), 1 / (sigma_rad * sigma_rad))
      .asDiagonal();
}

/// A corridor, driven to its end and back, with steps of a metre.
class Corridor : public testing::Test {
 protected:
  Corridor() {
    graph_.add_node({0, 0, 0});
    frames_.resize(kSteps + 1);
    for (std::size_t i = 0; i < kSteps; ++i) {
      const Pose2 step{1, 0, i == kBack ? M_PI : 0.0};
      graph_.add_node(compose(graph_.poses().back(), step));
      graph_.add({i, i + 1, step, information(0.03, 0.005), false});
      frames_[i + 1].travelled_m = static_cast<double>(i + 1);
    }
  }

  /// What a query of the way back shows of the frame of the way there that it lies `off_m` from.
  void add(std::size_t query, double off_m, double distinctness, double reach_m = 1) {
    const std::size_t reference = kSteps - query;
    const Pose2 seen = between(graph_.poses()[reference], graph_.poses()[query]);
    SubmapClosure closure;
    closure.constraint = {
        reference, query, {seen.x + off_m, seen.y, seen.yaw}, information(0.02, 0.005), true};
    closure.support = 0.8;
    closure.distinctness = distinctness;
    closure.reach_m = reach_m;
    closures_.push_back(closure);
  }
  [[nodiscard]] ClosureSets::Members best(double min_weight, std::size_t first_new = 0) const {
    const RelativeUncertainties known(graph_);
    return ClosureSets(closures_, frames_, graph_.poses(), known).best(first_new, min_weight);
  }

  PoseGraph graph_;
  std::vector<KeyFrame> frames_;
  std::vector<SubmapClosure> closures_;
};

TEST_F(Corridor, WhatAgreesIsAcceptedWithoutWhatDoesNot) {
  add(30, 0.5, 0.8);
  add(32, 0.5, 0.8);
  add(34, -7.0, 1.0);  // looks like another place
  add(36, 0.5, 0.8);
  const RelativeUncertainties known(graph_);
  ClosureSets sets(closures_, frames_, graph_.poses(), known);
  EXPECT_TRUE(sets.agree(0, 1));
  EXPECT_FALSE(sets.agree(0, 2));
  EXPECT_EQ(sets.agree(2, 3), sets.agree(3, 2));
  EXPECT_NEAR(sets.weight({0, 1, 3}), 2.4, 1e-9);
  auto members = sets.best(0, 1.5);
  std::sort(members.begin(), members.end());
  EXPECT_EQ(members, (ClosureSets::Members{0, 1, 3}));
}

TEST_F(Corridor, TooLittleWeightIsNotEnough) {
  add(30, 0.5, 0.7);
  add(32, 0.5, 0.7);
  EXPECT_TRUE(best(1.5).empty());
  EXPECT_EQ(best(1.3).size(), 2U);
}

TEST_F(Corridor, TheFartherAQueryMayStandTheMoreIsAskedFor) {
  for (const std::size_t query : {30, 32, 34}) add(query, 0.5, 0.7, 30);
  EXPECT_TRUE(best(1.5).empty());
  for (SubmapClosure& closure : closures_) closure.reach_m = 3;
  EXPECT_EQ(best(1.5).size(), 3U);
}

TEST_F(Corridor, OneQueryCountsOnce) {
  add(30, 0.5, 0.8);
  add(30, 0.5, 0.7);
  EXPECT_TRUE(best(1.0).empty());
  EXPECT_EQ(best(0.8).size(), 2U);
}

TEST_F(Corridor, TwoStoriesNearlyAsGoodAreNone) {
  for (const std::size_t query : {28, 32, 36}) add(query, 0.5, 0.8);
  for (const std::size_t query : {30, 34}) add(query, -6.0, 0.9);
  EXPECT_TRUE(best(1.5).empty());
  closures_.pop_back();  // of the second story one alone is left
  EXPECT_EQ(best(1.5).size(), 3U);
}

TEST_F(Corridor, ASetNeedsANewMember) {
  for (const std::size_t query : {28, 30, 32}) add(query, 0.5, 0.8);
  add(36, -7.0, 0.5);
  EXPECT_EQ(best(1.5, 2).size(), 3U);
  EXPECT_TRUE(best(1.5, 3).empty());
  EXPECT_TRUE(best(1.5, 4).empty());
}

}  // namespace
}  // namespace extperfc::mapping
