#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "arm/planning/tree.hpp"

namespace extperfc::arm {
namespace {

JointVector random_state(Rng& rng) {
  JointVector state(7);
  for (Eigen::Index j = 0; j < 7; ++j) state[j] = rng.uniform(-3, 3);
  return state;
}

TEST(Tree, NearestIsTheNearest) {
  Rng rng(3);
  Tree tree(7);
  for (int i = 0; i < 1000; ++i) tree.add(random_state(rng), i - 1);
  for (int i = 0; i < 200; ++i) {
    const JointVector target = random_state(rng);
    double smallest = 1e9;
    for (int k = 0; k < tree.size(); ++k) smallest = std::min(smallest, (tree.state(k) - target).norm());
    // Single precision: of two that are equally near to 1e-5 rad, either may be named.
    EXPECT_NEAR(tree.nearest(target).distance_rad, smallest, 1e-5);
  }
}

TEST(Tree, BranchRunsFromTheRoot) {
  Tree tree(1);
  const auto at = [](double x) { return JointVector(JointVector::Constant(1, x)); };
  const int root = tree.add(at(0), -1);
  const int a = tree.add(at(1), root);
  tree.add(at(-1), root);
  const int b = tree.add(at(2), a);
  EXPECT_EQ(tree.branch(b), (std::vector<JointVector>{at(0), at(1), at(2)}));
}

TEST(Tree, BranchHasTheStatesOnItsEdges) {
  Tree tree(1);
  const auto at = [](double x) { return JointVector(JointVector::Constant(1, x)); };
  const int root = tree.add(at(0), -1);
  const int a = tree.add(at(3), root, {at(1), at(2)});
  tree.add(at(-2), root, {at(-1)});
  const int b = tree.add(at(5), a, {at(4)});
  EXPECT_EQ(tree.branch(b), (std::vector<JointVector>{at(0), at(1), at(2), at(3), at(4), at(5)}));
  EXPECT_EQ(tree.size(), 4);
  EXPECT_EQ(tree.states(), 8);
}

TEST(Tree, DomainsNarrowAndWiden) {
  Tree tree(1);
  tree.add(JointVector::Zero(1), -1);
  EXPECT_GT(tree.domain_rad(0), 1e9);
  tree.narrow_domain(0);
  const double first = tree.domain_rad(0);
  EXPECT_LT(first, 1e9);
  tree.narrow_domain(0);
  EXPECT_LT(tree.domain_rad(0), first);
  for (int i = 0; i < 3; ++i) tree.widen_domain(0);
  EXPECT_GT(tree.domain_rad(0), first);
}

}  // namespace
}  // namespace extperfc::arm
