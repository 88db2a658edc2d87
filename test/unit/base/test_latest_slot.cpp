#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/latest_slot.hpp"

namespace extperfc {
namespace {

using namespace std::chrono_literals;

TEST(LatestSlot, NewestReplacesOlderAndCounts) {
  LatestSlot<int> slot;
  EXPECT_FALSE(slot.put(1));
  EXPECT_TRUE(slot.put(2));
  EXPECT_TRUE(slot.put(3));
  EXPECT_EQ(slot.take(), 3);
  EXPECT_EQ(slot.dropped(), 2U);
  EXPECT_FALSE(slot.put(4));
  EXPECT_EQ(slot.dropped(), 2U);
}

TEST(LatestSlot, TakeForTimesOut) {
  LatestSlot<int> slot;
  EXPECT_EQ(slot.take_for(1ms), std::nullopt);
}

TEST(LatestSlot, CloseWakesEveryTaker) {
  LatestSlot<int> slot;
  std::vector<std::thread> takers;
  takers.reserve(3);
  for (int i = 0; i < 3; ++i) takers.emplace_back([&slot] { EXPECT_EQ(slot.take(), std::nullopt); });
  slot.close();
  for (auto& taker : takers) taker.join();
  EXPECT_FALSE(slot.put(1));
  EXPECT_EQ(slot.take(), std::nullopt);
}

TEST(LatestSlot, EveryItemIsTakenOrCounted) {
  LatestSlot<std::unique_ptr<int>> slot;
  constexpr int kItems = 20000;
  int taken = 0;
  int last = -1;
  std::thread taker([&] {
    while (const auto item = slot.take()) {
      EXPECT_GT(**item, last);  // never backwards
      last = **item;
      ++taken;
      if (last == kItems - 1) return;
    }
  });
  for (int i = 0; i < kItems; ++i) slot.put(std::make_unique<int>(i));
  taker.join();
  EXPECT_EQ(static_cast<std::uint64_t>(taken) + slot.dropped(), static_cast<std::uint64_t>(kItems));
  EXPECT_EQ(last, kItems - 1);
}

}  // namespace
}  // namespace extperfc
