#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/in_order.hpp"

namespace extperfc {
namespace {

TEST(InOrder, ResultsLeaveInTheOrderOfTheirTickets) {
  InOrder order;
  std::vector<std::uint64_t> delivered;  // guarded by the order itself
  std::vector<std::thread> threads;
  threads.reserve(4);
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      for (int k = 0; k < 200; ++k) {
        const auto ticket = order.begin();
        if (ticket % 3 == 0) std::this_thread::yield();
        order.finish(ticket, [&] { delivered.push_back(ticket); });
      }
    });
  for (auto& thread : threads) thread.join();
  ASSERT_EQ(delivered.size(), 800U);
  for (std::size_t i = 0; i < delivered.size(); ++i) EXPECT_EQ(delivered[i], i);
}

}  // namespace
}  // namespace extperfc
