#include <gtest/gtest.h>

#include "test/support/random_message.hpp"
#include "test/unit/translate/plan/bytes_of.hpp"
#include "test/unit/translate/plan/random_schema.hpp"
#include "test/unit/translate/plan/reference.hpp"

using namespace extperfc;
using namespace extperfc::translate;

namespace {

struct Counts {
  int converted{0}, refused{0}, pass{0}, plans{0};
};

PlanOptions random_options(Rng& rng) {
  PlanOptions options;
  options.shift_times = rng.chance(0.5);
  options.frame_slash = static_cast<PlanOptions::Slash>(rng.integer(0, 2));
  return options;
}

void expect_same(const Plan& plan, const PlanOptions& options, const std::string& message,
                 std::int64_t shift_ns, Counts& counts) {
  const auto expected = reference::convert(*plan.from(), *plan.to(), message, options, shift_ns);
  const auto actual = converted(plan, message, shift_ns);
  ++(expected ? counts.converted : counts.refused);
  if (expected) {
    ASSERT_EQ(actual, *expected);
  } else {
    ASSERT_EQ(actual.rfind("error: ", 0), 0U) << "refused by the reference";
  }
  if (plan.kind() == Plan::Kind::kPass) {
    ASSERT_EQ(actual, message);
  }
}

void compare(std::uint64_t seed, Counts& counts) {
  Rng rng(seed);
  RandomSchema schemas(rng);
  const auto from = schemas.make();
  const auto to = schemas.evolve(*from);
  const auto options = random_options(rng);
  const auto plan = Plan::compile(from, to, RuleSet(), options);
  ASSERT_TRUE(plan) << plan.error().message;
  ++counts.plans;
  counts.pass += (*plan)->kind() == Plan::Kind::kPass ? 1 : 0;
  RandomMessage messages(rng, {4, 9, rng.chance(0.5) ? 0.0 : 0.2});
  for (int i = 0; i < 5; ++i) {
    const std::int64_t shift_ns = rng.chance(0.2) ? 0 : static_cast<std::int64_t>(rng.normal(0, 5e12));
    expect_same(**plan, options, string_of(messages.make(*from)), shift_ns, counts);
    if (testing::Test::HasFatalFailure()) {
      for (const auto& line : (*plan)->describe()) std::printf("  %s\n", line.c_str());
      std::printf("from:\n%s\nto:\n%s\n", from->full_text().c_str(), to->full_text().c_str());
      return;
    }
  }
}

}  // namespace

TEST(PlanReference, EqualsASlowConverterOnRandomDefinitions) {
  constexpr std::uint64_t kFirstSeed = 1;
  constexpr std::uint64_t kPairs = 6000;
  Counts counts;
  for (auto seed = kFirstSeed; seed < kFirstSeed + kPairs; ++seed) {
    compare(seed, counts);
    if (HasFatalFailure()) FAIL() << "seed " << seed;
  }
  std::printf("%d plans (%d pass), %d messages converted, %d refused\n", counts.plans, counts.pass,
              counts.converted, counts.refused);
  EXPECT_GT(counts.pass, 100);
  EXPECT_GT(counts.converted, 15000);
  EXPECT_GT(counts.refused, 500);
}
