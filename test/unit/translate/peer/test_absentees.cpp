#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "loop_until.hpp"
#include "translate/peer/absentees.hpp"

namespace extperfc::translate {
namespace {

using namespace std::chrono_literals;

class AbsenteesTest : public testing::Test {
 protected:
  [[nodiscard]] bool until_called(std::size_t count) {
    return loop_until(loop_, [&] { return called_.size() >= count; });
  }
  [[nodiscard]] SteadyTime::duration gap(std::size_t call) const { return called_[call] - called_[call - 1]; }

  EventLoop loop_;
  std::vector<SteadyTime> called_;
  Absentees absent_{loop_, [this] { called_.push_back(EventLoop::now()); }, 20ms, 80ms};
};

TEST_F(AbsenteesTest, CallsFurtherAndFurtherApart) {
  const auto begin = EventLoop::now();
  absent_.expect("/a");
  ASSERT_TRUE(until_called(6));
  EXPECT_GE(called_[0] - begin, 20ms);
  EXPECT_GE(gap(1), 40ms);
  for (std::size_t call = 2; call < 6; ++call) EXPECT_GE(gap(call), 80ms) << call;
  EXPECT_LT(called_[5] - begin, 5s) << "80 ms at most";
  EXPECT_EQ(absent_.calls(), 6);
}

TEST_F(AbsenteesTest, EndsWhenTheLastOneCame) {
  absent_.expect("/a");
  absent_.expect("/b");
  absent_.expect("/b");
  ASSERT_TRUE(until_called(1));
  absent_.forget("/b");
  absent_.forget("/unknown");
  ASSERT_TRUE(until_called(2));
  absent_.forget("/a");
  EXPECT_TRUE(absent_.empty());
  loop_for(loop_, 200ms);
  EXPECT_EQ(called_.size(), 2U);
}

TEST_F(AbsenteesTest, NobodyMissingNobodyCalled) {
  absent_.hurry();
  absent_.expect("/a");
  absent_.clear();
  loop_for(loop_, 60ms);
  EXPECT_TRUE(called_.empty());
}

TEST_F(AbsenteesTest, BeginsAnewForTheNext) {
  absent_.expect("/a");
  ASSERT_TRUE(until_called(3));
  absent_.forget("/a");
  const auto begin = EventLoop::now();
  absent_.expect("/b");
  EXPECT_EQ(absent_.calls(), 0);
  ASSERT_TRUE(until_called(5));
  EXPECT_GE(called_[3] - begin, 20ms);
  EXPECT_GE(gap(4), 40ms);
}

TEST_F(AbsenteesTest, HurryBringsTheNextCallForward) {
  Absentees slow(
      loop_, [this] { called_.push_back(EventLoop::now()); }, 1h, 2h);
  slow.expect("/a");
  slow.hurry();
  EXPECT_TRUE(until_called(1)) << "soon is not an hour";
  EXPECT_EQ(slow.calls(), 1);
}

TEST_F(AbsenteesTest, RemembersABoundedNumber) {
  for (std::size_t i = 0; i < 3 * Absentees::kMost; ++i) absent_.expect("/node" + std::to_string(i));
  EXPECT_EQ(absent_.names().size(), Absentees::kMost);
  EXPECT_TRUE(until_called(1));
}

TEST_F(AbsenteesTest, MayForgetWithinTheCall) {
  Absentees* self = nullptr;
  int calls = 0;
  Absentees once(
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

TEST_F(AbsenteesTest, NothingRunsAfterItsEnd) {
  {
    Absentees gone(
        loop_, [] { ADD_FAILURE(); }, 5ms, 5ms);
    gone.expect("/a");
  }
  loop_for(loop_, 50ms);
}

}  // namespace
}  // namespace extperfc::translate
