#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "ros/mapping/scan_queue.hpp"

namespace extperfc::ros_mapping {
namespace {

TEST(ScanQueue, KeepsTheOrder) {
  ScanQueue<int> queue(10);
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(queue.put(i));
  for (int i = 0; i < 10; ++i) EXPECT_EQ(queue.take().value(), i);
  EXPECT_EQ(queue.dropped(), 0U);
}

TEST(ScanQueue, TheOldestIsDropped) {
  ScanQueue<int> queue(3);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(queue.put(i), i >= 3);
  EXPECT_EQ(queue.dropped(), 7U);
  EXPECT_EQ(queue.waiting(), 3U);
  EXPECT_EQ(queue.take().value(), 7);
}

TEST(ScanQueue, ClosingEndsTheWaitAndDropsWhatWaits) {
  ScanQueue<int> queue(3);
  std::thread closer([&] { queue.close(); });
  EXPECT_FALSE(queue.take());
  closer.join();
  EXPECT_FALSE(queue.put(1));
  EXPECT_FALSE(queue.take());
}

TEST(ScanQueue, NothingIsLostBetweenThreads) {
  constexpr int kItems = 10000;
  ScanQueue<int> queue(kItems);
  std::thread giver([&] {
    for (int i = 0; i < kItems; ++i) (void)queue.put(i);
  });
  for (int i = 0; i < kItems; ++i) ASSERT_EQ(queue.take().value(), i);
  giver.join();
}

}  // namespace
}  // namespace extperfc::ros_mapping
