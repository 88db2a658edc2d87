#include <algorithm>

#include <gtest/gtest.h>

#include "mapping/place_cache.hpp"

namespace extperfc::mapping {
namespace {

/// Key frames a metre apart on the x axis that see one point each, a metre to their left.
class PlaceCacheTest : public testing::Test {
 protected:
  PlaceCacheTest() {
    for (std::size_t i = 0; i < 200; ++i) {
      KeyFrame frame;
      frame.scan = i;
      frame.travelled_m = static_cast<double>(i);
      frame.points.surface.push_back({{0.04F, 1.0F}, {0, -1}});
      frames_.push_back(frame);
      poses_.push_back({static_cast<double>(i), 0, 0});
    }
  }

  /// x of what a place holds, from its key frame.
  static std::vector<double> seen(const Place& place) {
    std::vector<double> xs;
    place.map.visit(
        [&](const SurfaceMap::Surface& surface) { xs.push_back(static_cast<double>(surface.mean.x())); });
    std::sort(xs.begin(), xs.end());
    return xs;
  }

  Place& at(std::size_t key_frame, std::size_t end = 200) {
    return cache_.at(key_frame, end, frames_, poses_);
  }

  std::vector<KeyFrame> frames_;
  std::vector<Pose2> poses_;
  PlaceCache cache_;
};

TEST_F(PlaceCacheTest, HoldsItsNeighbourhoodInItsOwnFrame) {
  poses_[50].yaw = 0.5;
  poses_[51] = compose(poses_[50], {1, 0, 0});
  const Place& place = at(50);
  EXPECT_EQ(place.key_frame, 50U);
  EXPECT_EQ(place.first, 50 - PlaceCache::kHalfWidth);
  EXPECT_EQ(place.last, 50 + PlaceCache::kHalfWidth);
  EXPECT_EQ(seen(place).size(), 2 * PlaceCache::kHalfWidth);
  EXPECT_NE(place.map.nearest({0.04F, 1}, {0, -1}, 1), nullptr);
  EXPECT_NE(place.map.nearest({1.04F, 1}, {0, -1}, 1), nullptr) << "seen from the key frame, turned or not";
}

TEST_F(PlaceCacheTest, EndsAreRespected) {
  const auto early = seen(at(2));
  EXPECT_EQ(early.size(), 2 + PlaceCache::kHalfWidth);
  EXPECT_NEAR(early.front(), -2 + 0.04, 1e-5);
  const auto before_end = seen(at(100, 103));
  EXPECT_EQ(before_end.size(), PlaceCache::kHalfWidth + 3);
  EXPECT_NEAR(before_end.back(), 2 + 0.04, 1e-5) << "key frame 103 is not part of it";
  EXPECT_EQ(seen(at(100, 104)).size(), PlaceCache::kHalfWidth + 4) << "a later end shows more";
  EXPECT_EQ(seen(at(0, 1)).size(), 1U);
}

TEST_F(PlaceCacheTest, IsDrawnAnewAfterBending) {
  EXPECT_NEAR(seen(at(50)).back(), 7.04, 1e-5);
  at(50).pyramid = std::make_unique<SearchPyramid>(at(50).map);
  poses_[57].x += 0.5;
  EXPECT_NEAR(seen(at(50)).back(), 7.54, 1e-5);
  EXPECT_EQ(at(50).pyramid, nullptr) << "what was made of the old map is gone";
}

TEST_F(PlaceCacheTest, MovingAsAWholeIsNoBending) {
  at(50).pyramid = std::make_unique<SearchPyramid>(at(50).map);
  const auto before = seen(at(50));
  for (Pose2& pose : poses_) pose = compose({3, -2, 1}, pose);
  EXPECT_EQ(seen(at(50)), before);
  EXPECT_NE(at(50).pyramid, nullptr) << "it was not drawn again";
}

TEST_F(PlaceCacheTest, ForgetsWhatWasNotUsedLately) {
  const auto mark = [&](std::size_t key_frame) {
    Place& place = at(key_frame);
    place.pyramid = std::make_unique<SearchPyramid>(place.map);
  };
  const auto is_marked = [&](std::size_t key_frame) { return at(key_frame).pyramid != nullptr; };
  mark(10);
  mark(20);
  for (std::size_t i = 0; i < PlaceCache::kMost - 2; ++i) (void)at(30 + i);
  EXPECT_TRUE(is_marked(10)) << "there is room for all of them";
  (void)at(150);
  EXPECT_TRUE(is_marked(10)) << "used a moment ago";
  EXPECT_FALSE(is_marked(20)) << "the one used longest ago had to go";
  for (std::size_t i = 0; i < PlaceCache::kMost; ++i) {
    (void)at(100 + i);
    EXPECT_TRUE(is_marked(10)) << "used all the time";
  }
  for (std::size_t i = 0; i < PlaceCache::kMost; ++i) (void)at(60 + i);
  EXPECT_FALSE(is_marked(10));
}

}  // namespace
}  // namespace extperfc::mapping
