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

#include "mapping/map_image.hpp"

namespace extperfc::mapping {
namespace {

using Extent = MapImage::Extent;

constexpr std::size_t kUnbounded = std::numeric_limits<std::size_t>::max();
constexpr double kResolutionM = 0.5;

/// Everything that was ever drawn, by column and row.
using Drawing = std::map<std::pair<int, int>, std::int8_t>;

void draw(MapImage& image, Drawing& drawing, int column, int row, std::int8_t value) {
  *image.cells_at(column, row) = value;
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

TEST(MapImage, IsEmptyAtFirst) {
  MapImage image(kResolutionM);
  EXPECT_TRUE(image.show()->empty());
  EXPECT_EQ(image.show()->width, 0U);
}

TEST(MapImage, IsChangedInPlaceWithoutReaders) {
  MapImage image(kResolutionM);
  Drawing drawing;
  const Extent extent{-3, -2, 7, 5};
  ASSERT_TRUE(image.open(extent, kUnbounded));
  const OccupancyGrid* address = image.show().get();
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(image.open(extent, 1)) << "nothing is to be copied";
    draw(image, drawing, -3 + i, 2 - i, 100);
    const auto shown = image.show();
    EXPECT_EQ(shown.get(), address);
    expect_shows(*shown, extent, drawing);
  }
}

TEST(MapImage, AnImageWithReadersStaysAsItWas) {
  MapImage image(kResolutionM);
  Drawing drawing;
  const Extent extent{0, 0, 4, 3};
  std::vector<std::pair<std::shared_ptr<const OccupancyGrid>, Drawing>> held;
  for (int i = 0; i < 12; ++i) {
    ASSERT_TRUE(image.open(extent, kUnbounded));
    draw(image, drawing, i % 4, i / 4, static_cast<std::int8_t>(i));
    held.emplace_back(image.show(), drawing);
  }
  for (const auto& [shown, then] : held) expect_shows(*shown, extent, then);
}

TEST(MapImage, OutlivesWhatShowedIt) {
  std::shared_ptr<const OccupancyGrid> shown;
  Drawing drawing;
  {
    MapImage image(kResolutionM);
    ASSERT_TRUE(image.open({1, 2, 3, 4}, kUnbounded));
    draw(image, drawing, 2, 3, 100);
    shown = image.show();
  }
  expect_shows(*shown, {1, 2, 3, 4}, drawing);
}

TEST(MapImage, CopyingTakesAsManyCallsAsTheBoundAsks) {
  MapImage image(kResolutionM);
  Drawing drawing;
  const Extent small{0, 0, 10, 10};
  const Extent large{-5, -5, 20, 20};
  ASSERT_TRUE(image.open(small, kUnbounded));
  draw(image, drawing, 9, 9, 100);
  for (int call = 1; call < 10; ++call) {
    ASSERT_FALSE(image.open(large, 40)) << call;
    expect_shows(*image.show(), small, drawing);
  }
  ASSERT_TRUE(image.open(large, 40)) << "400 cells, 40 a call";
  draw(image, drawing, -5, 14, 0);
  const auto held = image.show();
  expect_shows(*held, large, drawing);
  ASSERT_FALSE(image.open(large, 380)) << "it is held, so it is copied";
  ASSERT_TRUE(image.open(large, 1)) << "one row is left";
}

TEST(MapImage, HeldNoMoreNeedsNoCopy) {
  MapImage image(kResolutionM);
  Drawing drawing;
  const Extent extent{0, 0, 100, 100};
  ASSERT_TRUE(image.open(extent, kUnbounded));
  auto held = image.show();
  const OccupancyGrid* address = held.get();
  ASSERT_FALSE(image.open(extent, 1000)) << "it is held, and being copied";
  held.reset();
  ASSERT_TRUE(image.open(extent, 1000));
  draw(image, drawing, 50, 50, 100);
  EXPECT_EQ(image.show().get(), address);
  expect_shows(*image.show(), extent, drawing);
}

// Growing faster than it can be copied: what was begun is finished first, and shown.
TEST(MapImage, KeepsUpWithAnExtentThatAlwaysGrows) {
  constexpr int kHeight = 10;
  constexpr int kWidest = 200;
  constexpr int kBound = 400;
  constexpr int kCallsPerCopy = kWidest * kHeight / kBound;
  MapImage image(kResolutionM);
  for (int width = 10; width <= kWidest; ++width) {  // a column a call
    (void)image.open({0, 0, width, kHeight}, kBound);
    const int shown = static_cast<int>(image.show()->width);
    EXPECT_GE(shown + 2 * kCallsPerCopy + 1, width) << "a copy began in vain, another had to follow it";
  }
}

// Against a plain model: random growth, drawing, holding and letting go, with random bounds.
TEST(MapImage, ShowsWhatWasDrawn) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    MapImage image(kResolutionM);
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
      if (image.open(wanted, static_cast<std::size_t>(rng.integer(1, 400)))) {
        const Extent& extent = image.extent();
        for (int i = 0; i < 5; ++i)
          draw(image, drawing, extent.column + rng.integer(0, extent.width - 1),
               extent.row + rng.integer(0, extent.height - 1),
               static_cast<std::int8_t>(rng.integer(-1, 100)));
      }
      expect_shows(*image.show(), image.extent(), drawing);
      if (rng.chance(0.3)) held.emplace_back(image.show(), std::pair(image.extent(), drawing));
      if (rng.chance(0.2)) held.clear();
    }
    for (const auto& [shown, then] : held) expect_shows(*shown, then.first, then.second);
  }
}

TEST(MapImage, IsLookedAtByOtherThreads) {
  constexpr int kMinImages = 2000;
  constexpr int kMinLooks = 100;  // of all threads
  const Extent extent{0, 0, 16, 16};
  MapImage image(kResolutionM);
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
  for (int i = 0; i < kMinImages || looks < kMinLooks; ++i) {  // else the time limit of tests ends it
    EXPECT_TRUE(image.open(extent, kUnbounded));
    std::fill_n(image.cells_at(0, 0), 256, static_cast<std::int8_t>(i % 100));
    auto next = image.show();
    {
      const std::lock_guard lock(mutex);
      handed = i % 3 == 0 ? nullptr : std::move(next);
    }
    std::this_thread::yield();
  }
  done = true;
  first.join();
  second.join();
  EXPECT_EQ(torn, 0) << "an image changed while a reader held it";
}

}  // namespace
}  // namespace extperfc::mapping
