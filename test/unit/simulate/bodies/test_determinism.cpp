#include <cstring>

#include "test/unit/simulate/bodies/story.hpp"

namespace extperfc::simulate {
namespace {

void expect_same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    ASSERT_EQ(std::memcmp(&a[i], &b[i], sizeof(double)), 0)
        << "value " << i << ": " << a[i] << " and " << b[i];
}

class Determinism : public ::testing::TestWithParam<bool> {};

TEST_P(Determinism, SameCallsGiveTheSameBits) {
  std::vector<double> first;
  {
    Story story(GetParam());
    story.run(600);
    first = story.state();
  }
  // Made again, and beside another one that moves meanwhile.
  Story other(GetParam());
  other.run(37);
  Story again(GetParam());
  for (int i = 0; i < 60; ++i) {
    other.run(3);
    again.run(10);
  }
  expect_same_bits(first, again.state());
}

INSTANTIATE_TEST_SUITE_P(Modes, Determinism, ::testing::Bool(),
                         [](const auto& mode) { return mode.param ? "dynamic" : "kinematic"; });

}  // namespace
}  // namespace extperfc::simulate
