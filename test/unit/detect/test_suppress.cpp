#include <limits>

#include <gtest/gtest.h>

#include "extperfc/detect/decode.hpp"

namespace extperfc::detect {
namespace {

const Thresholds kThresholds{0.3F, 0.5F, 100};

TEST(Suppress, KeepsTheBestOfOverlappingBoxesOfOneClass) {
  const Detections kept = suppress({{0, 0.6F, {0, 0, 10, 10}}, {0, 0.9F, {1, 0, 11, 10}}}, kThresholds);
  ASSERT_EQ(kept.size(), 1U);
  EXPECT_FLOAT_EQ(kept[0].score, 0.9F);
}

TEST(Suppress, OtherClassesAndDistantBoxesStay) {
  const Detections kept = suppress({{0, 0.6F, {0, 0, 10, 10}},  //
                                    {1, 0.9F, {0, 0, 10, 10}},
                                    {0, 0.7F, {30, 0, 40, 10}}},
                                   kThresholds);
  ASSERT_EQ(kept.size(), 3U);
  EXPECT_EQ(kept[0].class_index, 1);  // best first over all classes
  EXPECT_FLOAT_EQ(kept[1].score, 0.7F);
  EXPECT_FLOAT_EQ(kept[2].score, 0.6F);
}

TEST(Suppress, IouBelowTheThresholdStays) {
  // Intersection 5 x 10, union 150: 1/3.
  const Detections pair{{0, 0.6F, {0, 0, 10, 10}}, {0, 0.5F, {5, 0, 15, 10}}};
  EXPECT_EQ(suppress(pair, {0.3F, 0.34F, 100}).size(), 2U);
  EXPECT_EQ(suppress(pair, {0.3F, 0.33F, 100}).size(), 1U);
}

TEST(Suppress, ScoreThresholdIsInclusiveAndNanIsBelowIt) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Detections kept = suppress(
      {{0, 0.3F, {0, 0, 10, 10}}, {0, 0.29F, {20, 0, 30, 10}}, {0, nan, {40, 0, 50, 10}}}, kThresholds);
  ASSERT_EQ(kept.size(), 1U);
  EXPECT_FLOAT_EQ(kept[0].score, 0.3F);
}

TEST(Suppress, KeepsTheBestUpToTheLimit) {
  Detections many;
  for (int i = 0; i < 50; ++i) {
    const auto x = static_cast<float>(20 * i);
    many.push_back({i % 3, 0.4F + 0.01F * static_cast<float>(i), {x, 0, x + 10, 10}});
  }
  const Detections kept = suppress(many, {0.3F, 0.5F, 5});
  ASSERT_EQ(kept.size(), 5U);
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_FLOAT_EQ(kept[i].score, many[49 - i].score);
}

TEST(Suppress, NothingInNothingOut) {
  EXPECT_TRUE(suppress({}, kThresholds).empty());
}

}  // namespace
}  // namespace extperfc::detect
