#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "test/unit/translate/peer/loop_until.hpp"
#include "translate/peer/missing_subscribers.hpp"

namespace extperfc::translate {
namespace {

using namespace std::chrono_literals;

class MissingSubscribersTest : public testing::Test {
 protected:
  [[nodiscard]] bool until_called(std::size_t count) {
    return loop_until(loop_, [&] { return called_.size() >= count; });
  }
  [[nodiscard]] SteadyTime::duration gap(std::size_t call) const { return called_[call] - called_[call - 1]; }

  EventLoop loop_;
  std::vector<SteadyTime> called_;
  MissingSubscribers missing_{loop_, [this] { called_.push_back(EventLoop::now()); }, 20ms, 80ms};
};

TEST_F(MissingSubscribersTest, CallsFurtherAndFurtherApart) {
  const auto begin = EventLoop::now();
  missing_.expect("/a");
  ASSERT_TRUE(until_called(6));
  EXPECT_GE(called_[0] - begin, 20ms);
  EXPECT_GE(gap(1), 40ms);
  for (std::size_t call = 2; call < 6; ++call) EXPECT_GE(gap(call), 80ms) << call;
  EXPECT_LT(called_[5] - begin, 5s) << "80 ms at most";
  EXPECT_EQ(missing_.calls(), 6);
}

TEST_F(MissingSubscribersTest, EndsWhenTheLastOneCame) {
  missing_.expect("/a");
  missing_.expect("/b");
  missing_.expect("/b");
  ASSERT_TRUE(until_called(1));
  missing_.forget("/b");
  missing_.forget("/unknown");
  ASSERT_TRUE(until_called(2));
  missing_.forget("/a");
  EXPECT_TRUE(missing_.empty());
  loop_for(loop_, 200ms);
  EXPECT_EQ(called_.size(), 2U);
}

TEST_F(MissingSubscribersTest, CallsNoOneWhenNoneIsMissing) {
  missing_.hurry();
  missing_.expect("/a");
  missing_.clear();
  loop_for(loop_, 60ms);
  EXPECT_TRUE(called_.empty());
}

TEST_F(MissingSubscribersTest, BeginsAnewForTheNext) {
  missing_.expect("/a");
  ASSERT_TRUE(until_called(3));
  missing_.forget("/a");
  const auto begin = EventLoop::now();
  missing_.expect("/b");
  EXPECT_EQ(missing_.calls(), 0);
  ASSERT_TRUE(until_called(5));
  EXPECT_GE(called_[3] - begin, 20ms);
  EXPECT_GE(gap(4), 40ms);
}

TEST_F(MissingSubscribersTest, HurryBringsTheNextCallForward) {
  MissingSubscribers slow(
      loop_, [this] { called_.push_back(EventLoop::now()); }, 1h, 2h);
  slow.expect("/a");
  slow.hurry();
  EXPECT_TRUE(until_called(1)) << "soon is not an hour";
  EXPECT_EQ(slow.calls(), 1);
}

TEST_F(MissingSubscribersTest, RemembersABoundedNumber) {
  for (std::size_t i = 0; i < 3 * MissingSubscribers::kMax; ++i) missing_.expect("/node" + std::to_string(i));
  EXPECT_EQ(missing_.names().size(), MissingSubscribers::kMax);
  EXPECT_TRUE(until_called(1));
}

TEST_F(MissingSubscribersTest, MayForgetWithinTheCall) {
  MissingSubscribers* self = nullptr;
  int calls = 0;
  MissingSubscribers once(
      loop_,
      [&] {
        ++calls;
        self->clear();
      },
      5ms, 5ms);
  self = &once;
  once.expect("/a");
  ASSERT_TRUE(loop_until(loop_, [&] { return calls == 1; }));
  loop_for(loop_, 50ms);
  EXPECT_EQ(calls, 1);
}

TEST_F(MissingSubscribersTest, NothingRunsAfterItsEnd) {
  {
    MissingSubscribers gone(
        loop_, [] { ADD_FAILURE(); }, 5ms, 5ms);
    gone.expect("/a");
  }
  loop_for(loop_, 50ms);
}

}  // namespace
}  // namespace extperfc::translate
