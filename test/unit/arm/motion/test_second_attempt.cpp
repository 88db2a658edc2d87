#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "arm/motion/second_attempt.hpp"

namespace extperfc::arm {
namespace {

/// Attempts with given ends; notes the seeds that they were asked with.
class Attempts {
 public:
  explicit Attempts(std::vector<std::pair<ArmCode, bool>> ends) : ends_(std::move(ends)) {}

  ArmCode plan(bool time_left = true) {
    const auto attempt = [this](std::uint64_t seed) {
      const auto [code, unproven] = ends_.at(seeds.size());
      seeds.push_back(seed);
      Attempt made;
      made.outcome.code = code;
      made.unproven = unproven;
      return made;
    };
    return plan_up_to_twice(7, attempt, [time_left] { return time_left; }).code;
  }

  std::vector<std::uint64_t> seeds;

 private:
  std::vector<std::pair<ArmCode, bool>> ends_;
};

TEST(SecondAttempt, IsNotMadeWhereTheFirstOneIsProvenOrFindsNoPath) {
  for (const auto code : {ArmCode::kSuccess, ArmCode::kPlanningTimeout, ArmCode::kInternal}) {
    Attempts attempts({{code, false}});
    EXPECT_EQ(attempts.plan(), code);
    EXPECT_EQ(attempts.seeds, std::vector<std::uint64_t>{7});
  }
}

TEST(SecondAttempt, HasAnotherSeed) {
  Attempts attempts({{ArmCode::kInternal, true}, {ArmCode::kSuccess, false}});
  EXPECT_EQ(attempts.plan(), ArmCode::kSuccess);
  ASSERT_EQ(attempts.seeds.size(), 2U);
  EXPECT_NE(attempts.seeds[0], attempts.seeds[1]);
}

TEST(SecondAttempt, IsTheLastOne) {
  Attempts attempts({{ArmCode::kInternal, true}, {ArmCode::kInternal, true}});
  EXPECT_EQ(attempts.plan(), ArmCode::kInternal);
  EXPECT_EQ(attempts.seeds.size(), 2U);
}

TEST(SecondAttempt, NeedsTime) {
  Attempts attempts({{ArmCode::kInternal, true}});
  EXPECT_EQ(attempts.plan(false), ArmCode::kInternal);
  EXPECT_EQ(attempts.seeds.size(), 1U);
}

TEST(SecondAttempt, DoesNotHideWhyTheFirstOneFailed) {
  Attempts no_path({{ArmCode::kInternal, true}, {ArmCode::kPlanningTimeout, false}});
  EXPECT_EQ(no_path.plan(), ArmCode::kInternal);
  Attempts cancelled({{ArmCode::kInternal, true}, {ArmCode::kCancelled, false}});
  EXPECT_EQ(cancelled.plan(), ArmCode::kCancelled);
}

}  // namespace
}  // namespace extperfc::arm
