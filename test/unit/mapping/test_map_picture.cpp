#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "mapping/map_picture.hpp"

namespace extperfc::mapping {
namespace {

using Extent = MapPicture::Extent;

constexpr std::size_t kUnbounded = std::numeric_limits<std::size_t>::max();
constexpr double kResolutionM = 0.5;

/// Everything that was ever drawn, by column and row.
using Drawing = std::map<std::pair<int, int>, std::int8_t>;

void draw(MapPicture& picture, Drawing& drawing, int column, int row, std::int8_t value) {
  *picture.cells_at(column, row) = value;
  drawing[{column, row}] = value;
}

void expect_shows(const OccupancyGrid& grid, const Extent& extent, const Drawing& drawing) {
  ASSERT_EQ(grid.width, static_cast<std::size_t>(extent.width));
  ASSERT_EQ(grid.height, static_cast<std::size_t>(extent.height));
  ASSERT_EQ(grid.cells.size(), grid.width * grid.height);
  EXPECT_EQ(grid.resolution_m, kResolutionM);
  EXPECT_EQ(grid.origin.x, extent.column * kResolutionM);
  EXPECT_EQ(grid.origin.y, extent.row * kResolutionM);
  for (int row = 0; row < extent.height; ++row)
    for (int column = 0; column < extent.width; ++column) {
      const auto drawn = drawing.find({extent.column + column, extent.row + row});
      const auto expected = drawn == drawing.end() ? OccupancyGrid::kUnknown : drawn->second;
      ASSERT_EQ(grid.at(static_cast<std::size_t>(column), static_cast<std::size_t>(row)), expected)
          << column << " " << row;
    }
}

TEST(MapPicture, IsEmptyAtFirst) {
  MapPicture picture(kResolutionM);
  EXPECT_TRUE(picture.show()->empty());
  EXPECT_EQ(picture.show()->width, 0U);
}

TEST(MapPicture, IsDrawnOnInPlaceWhileNobodyHoldsIt) {
  MapPicture picture(kResolutionM);
  Drawing drawing;
  const Extent extent{-3, -2, 7, 5};
  ASSERT_TRUE(picture.open(extent, kUnbounded));
  const OccupancyGrid* address = picture.show().get();
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(picture.open(extent, 1)) << "nothing is to be copied";
    draw(picture, drawing, -3 + i, 2 - i, 100);
    const auto shown = picture.show();
    EXPECT_EQ(shown.get(), address);
    expect_shows(*shown, extent, drawing);
  }
}

TEST(MapPicture, WhatSomebodyHoldsStaysAsItWas) {
  MapPicture picture(kResolutionM);
  Drawing drawing;
  const Extent extent{0, 0, 4, 3};
  std::vector<std::pair<std::shared_ptr<const OccupancyGrid>, Drawing>> held;
  for (int i = 0; i < 12; ++i) {
    ASSERT_TRUE(picture.open(extent, kUnbounded));
    draw(picture, drawing, i % 4, i / 4, static_cast<std::int8_t>(i));
    held.emplace_back(picture.show(), drawing);
  }
  for (const auto& [shown, then] : held) expect_shows(*shown, extent, then);
}

TEST(MapPicture, OutlivesWhatShowedIt) {
  std::shared_ptr<const OccupancyGrid> shown;
  Drawing drawing;
  {
    MapPicture picture(kResolutionM);
    ASSERT_TRUE(picture.open({1, 2, 3, 4}, kUnbounded));
    draw(picture, drawing, 2, 3, 100);
    shown = picture.show();
  }
  expect_shows(*shown, {1, 2, 3, 4}, drawing);
}

TEST(MapPicture, CopyingTakesAsManyCallsAsTheBoundAsks) {
  MapPicture picture(kResolutionM);
  Drawing drawing;
  const Extent small{0, 0, 10, 10};
  const Extent large{-5, -5, 20, 20};
  ASSERT_TRUE(picture.open(small, kUnbounded));
  draw(picture, drawing, 9, 9, 100);
  for (int call = 1; call < 10; ++call) {
    ASSERT_FALSE(picture.open(large, 40)) << call;
    expect_shows(*picture.show(), small, drawing);
  }
  ASSERT_TRUE(picture.open(large, 40)) << "400 cells, 40 a call";
  draw(picture, drawing, -5, 14, 0);
  const auto held = picture.show();
  expect_shows(*held, large, drawing);
  ASSERT_FALSE(picture.open(large, 380)) << "it is held, so it is copied";
  ASSERT_TRUE(picture.open(large, 1)) << "one row is left";
}

TEST(MapPicture, HeldNoMoreNeedsNoCopy) {
  MapPicture picture(kResolutionM);
  Drawing drawing;
  const Extent extent{0, 0, 100, 100};
  ASSERT_TRUE(picture.open(extent, kUnbounded));
  auto held = picture.show();
  const OccupancyGrid* address = held.get();
  ASSERT_FALSE(picture.open(extent, 1000)) << "it is held, and being copied";
  held.reset();
  ASSERT_TRUE(picture.open(extent, 1000));
  draw(picture, drawing, 50, 50, 100);
  EXPECT_EQ(picture.show().get(), address);
  expect_shows(*picture.show(), extent, drawing);
}

// Growing faster than it can be copied: what was begun is finished first, and shown.
TEST(MapPicture, KeepsUpWithAnExtentThatAlwaysGrows) {
  constexpr int kHeight = 10;
  constexpr int kWidest = 200;
  constexpr int kBound = 400;
  constexpr int kCallsPerCopy = kWidest * kHeight / kBound;
  MapPicture picture(kResolutionM);
  for (int width = 10; width <= kWidest; ++width) {  // a column a call
    (void)picture.open({0, 0, width, kHeight}, kBound);
    const int shown = static_cast<int>(picture.show()->width);
    EXPECT_GE(shown + 2 * kCallsPerCopy + 1, width) << "a copy began in vain, another had to follow it";
  }
}

// Against a plain model: random growth, drawing, holding and letting go, with random bounds.
TEST(MapPicture, ShowsWhatWasDrawn) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    MapPicture picture(kResolutionM);
    Extent wanted{rng.integer(-20, 20), rng.integer(-20, 20), rng.integer(1, 5), rng.integer(1, 5)};
    Drawing drawing;
    std::vector<std::pair<std::shared_ptr<const OccupancyGrid>, std::pair<Extent, Drawing>>> held;
    for (int call = 0; call < 100; ++call) {
      if (rng.chance(0.1)) {
        const int left = rng.integer(0, 3);
        const int down = rng.integer(0, 3);
        wanted = {wanted.column - left, wanted.row - down, wanted.width + left + rng.integer(0, 3),
                  wanted.height + down + rng.integer(0, 3)};
      }
      if (picture.open(wanted, static_cast<std::size_t>(rng.integer(1, 400)))) {
        const Extent& extent = picture.extent();
        for (int i = 0; i < 5; ++i)
          draw(picture, drawing, extent.column + rng.integer(0, extent.width - 1),
               extent.row + rng.integer(0, extent.height - 1),
               static_cast<std::int8_t>(rng.integer(-1, 100)));
      }
      expect_shows(*picture.show(), picture.extent(), drawing);
      if (rng.chance(0.3)) held.emplace_back(picture.show(), std::pair(picture.extent(), drawing));
      if (rng.chance(0.2)) held.clear();
    }
    for (const auto& [shown, then] : held) expect_shows(*shown, then.first, then.second);
  }
}

TEST(MapPicture, IsLookedAtByOtherThreads) {
  constexpr int kFewestPictures = 2000;
  constexpr int kFewestLooks = 100;  // of all threads
  const Extent extent{0, 0, 16, 16};
  MapPicture picture(kResolutionM);
  std::shared_ptr<const OccupancyGrid> handed;  // guarded by mutex
  std::mutex mutex;
  std::atomic<bool> done{false};
  std::atomic<int> looks{0};
  std::atomic<int> torn{0};
  const auto look = [&] {
    while (!done) {
      std::shared_ptr<const OccupancyGrid> mine;
      {
        const std::lock_guard lock(mutex);
        mine = handed;
      }
      for (int again = 0; mine && again < 3; ++again)
        for (const std::int8_t cell : mine->cells)
          if (cell != mine->cells.front()) ++torn;
      if (mine) ++looks;
      std::this_thread::yield();
    }
  };
  std::thread first(look);
  std::thread second(look);
  for (int i = 0; i < kFewestPictures || looks < kFewestLooks; ++i) {  // else the time limit of tests ends it
    EXPECT_TRUE(picture.open(extent, kUnbounded));
    std::fill_n(picture.cells_at(0, 0), 256, static_cast<std::int8_t>(i % 100));
    auto next = picture.show();
    {
      const std::lock_guard lock(mutex);
      handed = i % 3 == 0 ? nullptr : std::move(next);
    }
    std::this_thread::yield();
  }
  done = true;
  first.join();
  second.join();
  EXPECT_EQ(torn, 0) << "a picture changed while somebody held it";
}

}  // namespace
}  // namespace extperfc::mapping
