#include "test/unit/simulate/bodies/story.hpp"

namespace extperfc::simulate {
namespace {

class Soak : public ::testing::TestWithParam<bool> {};

TEST_P(Soak, HalfAMinuteStaysFinite) {
  Story story(GetParam());
  for (int second = 0; second < 30; ++second) {
    story.run(240);
    for (const double value : story.state()) {
      ASSERT_TRUE(std::isfinite(value)) << "second " << second;
      ASSERT_LT(std::abs(value), 1e4) << "second " << second;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, Soak, ::testing::Bool(),
                         [](const auto& mode) { return mode.param ? "dynamic" : "kinematic"; });

}  // namespace
}  // namespace extperfc::simulate
