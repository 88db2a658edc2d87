#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/pending_work.hpp"

namespace extperfc {
namespace {

struct Work {
  int newest{0};
  std::vector<int> all;
};

TEST(PendingWork, ChangesAreTakenTogether) {
  PendingWork<Work> pending;
  for (const int value : {1, 2, 3})
    pending.change([value](Work& work) {
      work.newest = value;
      work.all.push_back(value);
    });
  const auto work = pending.take();
  ASSERT_TRUE(work);
  EXPECT_EQ(3, work->newest);
  EXPECT_EQ((std::vector<int>{1, 2, 3}), work->all);
}

TEST(PendingWork, TheWorkerWaitsAndLosesNothing) {
  PendingWork<Work> pending;
  std::vector<int> taken;
  std::thread worker([&] {
    while (taken.size() < 100) {
      const auto work = pending.take();
      taken.insert(taken.end(), work->all.begin(), work->all.end());
    }
  });
  for (int value = 0; value < 100; ++value)
    pending.change([value](Work& work) { work.all.push_back(value); });
  worker.join();
  ASSERT_EQ(100U, taken.size());
  for (int value = 0; value < 100; ++value) EXPECT_EQ(value, taken[static_cast<std::size_t>(value)]);
}

TEST(PendingWork, AfterCloseThereIsNoWork) {
  PendingWork<Work> pending;
  pending.change([](Work& work) { work.newest = 1; });
  pending.close();
  EXPECT_FALSE(pending.take());
  pending.change([](Work& work) { work.newest = 2; });
  EXPECT_FALSE(pending.take());
}

}  // namespace
}  // namespace extperfc
