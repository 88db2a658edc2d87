#include <string>

#include <gtest/gtest.h>

#include "extperfc/base/stamp_matcher.hpp"

namespace extperfc {
namespace {

using Matcher = StampMatcher<std::string, int>;

TEST(StampMatcher, ResultAfterItsImage) {
  Matcher matcher({10, 3, 2});
  EXPECT_FALSE(matcher.add_fast(100, 1));
  EXPECT_FALSE(matcher.add_fast(200, 2));
  const auto pair = matcher.add_slow(195, "a");
  ASSERT_TRUE(pair);
  EXPECT_EQ(*pair, Matcher::Pair("a", 2));
}

TEST(StampMatcher, ImageAfterItsResult) {
  Matcher matcher({10, 3, 2});
  EXPECT_FALSE(matcher.add_slow(100, "a"));
  const auto pair = matcher.add_fast(101, 7);
  ASSERT_TRUE(pair);
  EXPECT_EQ(*pair, Matcher::Pair("a", 7));
  EXPECT_FALSE(matcher.add_fast(102, 8));  // once only
}

TEST(StampMatcher, NearestOfSeveral) {
  Matcher matcher({50, 9, 2});
  for (const int stamp : {100, 130, 160}) EXPECT_FALSE(matcher.add_fast(stamp, stamp));
  EXPECT_EQ(matcher.add_slow(126, "a")->second, 130);
}

TEST(StampMatcher, NeverMatchingStampsAreCountedAndBounded) {
  Matcher matcher({10, 3, 2});
  for (int i = 0; i < 1000; ++i) {
    EXPECT_FALSE(matcher.add_fast(i * 1000, i));
    EXPECT_FALSE(matcher.add_slow(i * 1000 + 500, "a"));
  }
  EXPECT_GE(matcher.unmatched(), 998U);
}

TEST(StampMatcher, ResultsWithoutAnyImageAreBounded) {
  Matcher matcher({10, 3, 2});
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(matcher.add_slow(i * 1000, "a"));
  EXPECT_EQ(matcher.unmatched(), 8U);
}

TEST(StampMatcher, LateResultWhoseImageIsGoneIsDropped) {
  Matcher matcher({10, 2, 2});
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(matcher.add_fast(i * 100, i));
  EXPECT_FALSE(matcher.add_slow(0, "late"));
  EXPECT_EQ(matcher.unmatched(), 1U);
}

TEST(StampMatcher, TimeThatJumpsBackStartsAgain) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  Matcher matcher({10, 9, 2});
  EXPECT_FALSE(matcher.add_fast(100 * kSecond, 1));
  EXPECT_FALSE(matcher.add_slow(100 * kSecond + 500, "old"));
  EXPECT_FALSE(matcher.add_fast(5 * kSecond, 2));  // the bag loops
  const auto pair = matcher.add_slow(5 * kSecond, "new");
  ASSERT_TRUE(pair);
  EXPECT_EQ(*pair, Matcher::Pair("new", 2));
}

}  // namespace
}  // namespace extperfc
