#include <cstring>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/translate/frame.hpp"

namespace extperfc::translate {
namespace {

constexpr std::size_t kImage = 6U << 20U;

TEST(FramePool, UsesTheMemoryOfALargeFrameAgain) {
  FramePool pool;
  auto frame = pool.take(kImage);
  const auto* memory = frame->resize_payload(kImage);
  frame.reset();
  EXPECT_GE(pool.kept_bytes(), kImage);
  const auto next = pool.take(kImage - 5'000);  // compressed images differ in size
  EXPECT_EQ(pool.kept_bytes(), 0U);
  EXPECT_EQ(next->resize_payload(kImage - 5'000), memory);
  EXPECT_EQ(next->payload().size, kImage - 5'000);
}

TEST(FramePool, AFrameBeginsEmptyWithItsLengthInFront) {
  FramePool pool;
  pool.take(kImage)->resize_payload(kImage);
  const auto frame = pool.take(kImage);
  EXPECT_EQ(frame->payload().size, 0U);
  EXPECT_EQ(frame->wire().size, Frame::kPrefix);
  frame->buffer().append("abc", 3);
  frame->seal();
  EXPECT_EQ(std::memcmp(frame->wire().data, "\3\0\0\0abc", 7), 0);
}

TEST(FramePool, SmallFramesAreNotKept) {
  FramePool pool;
  pool.take(200)->resize_payload(200);
  EXPECT_EQ(pool.kept_bytes(), 0U);
}

TEST(FramePool, ASmallMessageDoesNotOccupyALargeBuffer) {
  FramePool pool;
  pool.take(kImage)->resize_payload(kImage);
  const auto kept = pool.kept_bytes();
  const auto small = pool.take(100'000);
  EXPECT_EQ(pool.kept_bytes(), kept);
  EXPECT_LT(small->buffer().capacity(), 200'000U);
}

TEST(FramePool, KeepsNoMoreThanItMayAndForgetsTheOldestSizes) {
  FramePool pool({10U << 20U, 16U << 10U});
  std::vector<std::shared_ptr<Frame>> frames;
  for (int i = 0; i < 100; ++i) frames.push_back(pool.take(1U << 20U));
  frames.clear();
  EXPECT_LE(pool.kept_bytes(), 10U << 20U);
  EXPECT_GE(pool.kept_bytes(), 8U << 20U);
  pool.take(kImage)->resize_payload(kImage);
  const auto before = pool.kept_bytes();
  EXPECT_LE(before, 10U << 20U);
  const auto image = pool.take(kImage);
  EXPECT_LE(pool.kept_bytes() + kImage, before) << "the image's buffer was kept, older ones went";
  pool.take(20U << 20U)->resize_payload(20U << 20U);
  EXPECT_LE(pool.kept_bytes(), 10U << 20U);
}

TEST(FramePool, FramesOutliveThePool) {
  std::shared_ptr<Frame> frame;
  {
    FramePool pool;
    frame = pool.take(kImage);
  }
  frame->resize_payload(kImage)[kImage - 1] = 1;
  EXPECT_EQ(frame->payload().size, kImage);
}

TEST(FramePool, RandomUseStaysWithinBoundsAndNeverSharesMemory) {
  FramePool pool({4U << 20U, 16U << 10U});
  Rng rng(17);
  std::vector<std::shared_ptr<Frame>> held;
  for (int i = 0; i < 2'000; ++i) {
    if (held.size() < 20 && rng.chance(0.6)) {
      const auto size = static_cast<std::size_t>(rng.integer(0, 400'000));
      auto frame = pool.take(size);
      std::memset(frame->resize_payload(size), static_cast<int>(held.size()), size);
      held.push_back(std::move(frame));
    } else if (!held.empty()) {
      const auto& last = held.back()->payload();
      for (std::size_t k = 0; k < last.size; k += 997) ASSERT_EQ(last.data[k], held.size() - 1);
      held.pop_back();
    }
    ASSERT_LE(pool.kept_bytes(), 4U << 20U);
  }
}

}  // namespace
}  // namespace extperfc::translate
