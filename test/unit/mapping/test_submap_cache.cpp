#include <algorithm>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "mapping/submap_cache.hpp"

namespace extperfc::mapping {
namespace {

/// Key frames a metre apart on the x axis that see one point each, a metre to their left.
class SubmapCacheTest : public testing::Test {
 protected:
  SubmapCacheTest() {
    for (std::size_t i = 0; i < 200; ++i) {
      KeyFrame frame;
      frame.scan = i;
      frame.travelled_m = static_cast<double>(i);
      frame.points.surface.push_back({{0.04F, 1.0F}, {0, -1}});
      frames_.push_back(frame);
      poses_.push_back({static_cast<double>(i), 0, 0});
    }
  }

  /// x of what a submap holds, from its key frame.
  static std::vector<double> seen(const Submap& submap) {
    std::vector<double> xs;
    submap.map.visit(
        [&](const SurfaceMap::Surface& surface) { xs.push_back(static_cast<double>(surface.mean.x())); });
    std::sort(xs.begin(), xs.end());
    return xs;
  }

  Submap& at(std::size_t key_frame, std::size_t end = 200) {
    return cache_.at(key_frame, end, frames_, poses_);
  }

  std::vector<KeyFrame> frames_;
  std::vector<Pose2> poses_;
  SubmapCache cache_;
};

TEST_F(SubmapCacheTest, HoldsItsNeighbourhoodInItsOwnFrame) {
  poses_[50].yaw = 0.5;
  poses_[51] = compose(poses_[50], {1, 0, 0});
  const Submap& submap = at(50);
  EXPECT_EQ(submap.key_frame, 50U);
  EXPECT_EQ(submap.first, 50 - SubmapCache::kHalfWidth);
  EXPECT_EQ(submap.last, 50 + SubmapCache::kHalfWidth);
  EXPECT_EQ(seen(submap).size(), 2 * SubmapCache::kHalfWidth);
  EXPECT_NE(submap.map.nearest({0.04F, 1}, {0, -1}, 1), nullptr);
  EXPECT_NE(submap.map.nearest({1.04F, 1}, {0, -1}, 1), nullptr) << "seen from the key frame, turned or not";
}

TEST_F(SubmapCacheTest, EndsAreRespected) {
  const auto early = seen(at(2));
  EXPECT_EQ(early.size(), 2 + SubmapCache::kHalfWidth);
  EXPECT_NEAR(early.front(), -2 + 0.04, 1e-5);
  const auto before_end = seen(at(100, 103));
  EXPECT_EQ(before_end.size(), SubmapCache::kHalfWidth + 3);
  EXPECT_NEAR(before_end.back(), 2 + 0.04, 1e-5) << "key frame 103 is not part of it";
  EXPECT_EQ(seen(at(100, 104)).size(), SubmapCache::kHalfWidth + 4) << "a later end shows more";
  EXPECT_EQ(seen(at(0, 1)).size(), 1U);
}

TEST_F(SubmapCacheTest, IsDrawnAnewWhenKeyFramesMove) {
  EXPECT_NEAR(seen(at(50)).back(), 7.04, 1e-5);
  at(50).pyramid = std::make_unique<SearchPyramid>(at(50).map);
  poses_[57].x += 0.5;
  EXPECT_NEAR(seen(at(50)).back(), 7.54, 1e-5);
  EXPECT_EQ(at(50).pyramid, nullptr) << "what was made of the old map is gone";
}

TEST_F(SubmapCacheTest, IsKeptWhenAllMoveAsOne) {
  at(50).pyramid = std::make_unique<SearchPyramid>(at(50).map);
  const auto before = seen(at(50));
  for (Pose2& pose : poses_) pose = compose({3, -2, 1}, pose);
  EXPECT_EQ(seen(at(50)), before);
  EXPECT_NE(at(50).pyramid, nullptr) << "it was not drawn again";
}

TEST_F(SubmapCacheTest, ForgetsWhatWasNotUsedLately) {
  const auto mark = [&](std::size_t key_frame) {
    Submap& submap = at(key_frame);
    submap.pyramid = std::make_unique<SearchPyramid>(submap.map);
  };
  const auto is_marked = [&](std::size_t key_frame) { return at(key_frame).pyramid != nullptr; };
  mark(10);
  mark(20);
  for (std::size_t i = 0; i < SubmapCache::kMaxSubmaps - 2; ++i) (void)at(30 + i);
  EXPECT_TRUE(is_marked(10)) << "there is room for all of them";
  (void)at(150);
  EXPECT_TRUE(is_marked(10)) << "used a moment ago";
  EXPECT_FALSE(is_marked(20)) << "the one used longest ago had to go";
  for (std::size_t i = 0; i < SubmapCache::kMaxSubmaps; ++i) {
    (void)at(100 + i);
    EXPECT_TRUE(is_marked(10)) << "used all the time";
  }
  for (std::size_t i = 0; i < SubmapCache::kMaxSubmaps; ++i) (void)at(60 + i);
  EXPECT_FALSE(is_marked(10));
}

/// What was made of a submap is made again when its key frames moved in its frame.
TEST(SubmapShape, ChangesWithItsKeyFramesAndNotWithItsPose) {
  constexpr std::size_t kMiddle = 20;
  std::vector<Pose2> poses;
  for (std::size_t i = 0; i < 40; ++i) poses.push_back({0.3 * static_cast<double>(i), 0, 0});
  const auto shape_of = [](std::size_t key_frame, const std::vector<Pose2>& at) {
    return SubmapCache::shape_of(key_frame, at.size(), at);
  };
  const SubmapShape then = shape_of(kMiddle, poses);
  EXPECT_FALSE(is_unchanged(shape_of(kMiddle + 1, poses), then));
  EXPECT_FALSE(is_unchanged(SubmapCache::shape_of(kMiddle, kMiddle + 4, poses), then));
  auto moved = poses;
  for (Pose2& pose : moved) pose = compose({5, -3, 1}, pose);
  EXPECT_TRUE(is_unchanged(shape_of(kMiddle, moved), then));
  for (const std::size_t end : {then.first, then.last - 1}) {
    for (const auto& [shift, is_still] :
         {std::pair{Pose2{0.005, 0, 0}, true}, std::pair{Pose2{0.02, 0, 0}, false},
          std::pair{Pose2{0, 0, 0.001}, true}, std::pair{Pose2{0, 0, 0.004}, false}}) {
      auto shifted = moved;
      shifted[end] = compose(shifted[end], shift);
      EXPECT_EQ(is_unchanged(shape_of(kMiddle, shifted), then), is_still)
          << end << " " << shift.x << " " << shift.yaw;
    }
  }
}

}  // namespace
}  // namespace extperfc::mapping
