#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/socket.h>

#include "test/unit/translate/peer/raw_socket.hpp"
#include "translate/peer/tcpros_frame_reader.hpp"

namespace extperfc::translate {
namespace {

using testing::little_endian;
using testing::RawSocket;
using Outcome = FrameReader::Outcome;

std::string message(const std::string& text) {
  return little_endian(static_cast<std::uint32_t>(text.size())) + text;
}

class FrameReaderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    int pair[2];
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, pair), 0);
    far = RawSocket(pair[0]);
    near = RawSocket(pair[1]);
    const int bytes = 4 << 20;
    ::setsockopt(far.get(), SOL_SOCKET, SO_SNDBUF, &bytes, sizeof(bytes));
  }
  Outcome read(FrameReader& reader, std::size_t at_most = 1U << 20U) {
    return reader.read(near.get(), at_most,
                       [this](std::shared_ptr<Frame> frame, std::uint8_t status, SteadyTime) {
                         const auto payload = frame->payload();
                         got.emplace_back(reinterpret_cast<const char*>(payload.data), payload.size);
                         const auto wire = frame->wire();
                         EXPECT_EQ(std::string(reinterpret_cast<const char*>(wire.data), 4),
                                   little_endian(static_cast<std::uint32_t>(payload.size)));
                         statuses.push_back(status);
                         return got.size() < stop_after;
                       });
  }

  RawSocket far, near;
  FramePool pool;
  ByteBuffer scratch;
  FrameReader::Params params{1U << 20U, false, false};
  std::vector<std::string> got;
  std::vector<int> statuses;
  std::size_t stop_after{1'000'000};
};

TEST_F(FrameReaderTest, ManySmallOnesComeFromOneRead) {
  FrameReader reader(pool, scratch, params);
  std::string all;
  for (int i = 0; i < 500; ++i) all += message("number " + std::to_string(i));
  ASSERT_TRUE(far.send(all));
  EXPECT_EQ(read(reader), Outcome::kWaiting);
  ASSERT_EQ(got.size(), 500U);
  EXPECT_EQ(got[499], "number 499");
}

TEST_F(FrameReaderTest, EverySplitGivesTheSameMessages) {
  const auto all = message("first") + message("") + message("third one") + message("x");
  for (std::size_t cut = 1; cut < all.size(); ++cut) {
    got.clear();
    FrameReader reader(pool, scratch, params);
    ASSERT_TRUE(far.send(all.substr(0, cut)));
    EXPECT_EQ(read(reader), Outcome::kWaiting);
    ASSERT_TRUE(far.send(all.substr(cut)));
    EXPECT_EQ(read(reader), Outcome::kWaiting);
    EXPECT_EQ(got, (std::vector<std::string>{"first", "", "third one", "x"})) << cut;
  }
}

TEST_F(FrameReaderTest, LargeAndSmallOnesAlternate) {
  FrameReader reader(pool, scratch, params);
  const std::string large(100'000, 'L');
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(far.send(message(large) + message("small")));
    while (got.size() < static_cast<std::size_t>(2 * (i + 1)))
      ASSERT_EQ(read(reader, 10'000), Outcome::kWaiting);
    EXPECT_EQ(got[got.size() - 2], large);
    EXPECT_EQ(got.back(), "small");
  }
}

TEST_F(FrameReaderTest, ReadsNoMoreThanAskedFor) {
  FrameReader reader(pool, scratch, params);
  ASSERT_TRUE(far.send(message(std::string(500'000, 'a'))));
  EXPECT_EQ(read(reader, 100'000), Outcome::kWaiting);
  EXPECT_TRUE(got.empty());
}

TEST_F(FrameReaderTest, AnAbsurdLengthBreaksTheStreamBeforeMemoryIsTaken) {
  FrameReader reader(pool, scratch, params);
  ASSERT_TRUE(far.send(message("fine") + little_endian(0xfffffff0U) + "and so on"));
  EXPECT_EQ(read(reader), Outcome::kBroken);
  EXPECT_EQ(got, std::vector<std::string>{"fine"});
  EXPECT_NE(reader.problem().find("4294967280"), std::string::npos) << reader.problem();
}

TEST_F(FrameReaderTest, AnEndAmidAMessageIsReported) {
  FrameReader reader(pool, scratch, params);
  ASSERT_TRUE(far.send(little_endian(100) + "half"));
  far.close();
  EXPECT_EQ(read(reader), Outcome::kWaiting);
  EXPECT_EQ(read(reader), Outcome::kClosed);
  EXPECT_NE(reader.problem().find("middle"), std::string::npos) << reader.problem();
  EXPECT_TRUE(got.empty());
}

TEST_F(FrameReaderTest, AnExactReaderLeavesTheNextMessageInTheSocket) {
  params.exact = true;
  stop_after = 1;
  FrameReader reader(pool, scratch, params);
  const auto second = message("second");
  ASSERT_TRUE(far.send(message("first") + second));
  EXPECT_EQ(read(reader), Outcome::kStopped);
  EXPECT_EQ(got, std::vector<std::string>{"first"});
  near.drain();
  EXPECT_EQ(near.received, second);
}

TEST_F(FrameReaderTest, StatusBytesOfResponsesAreReported) {
  params = {1U << 20U, true, true};
  FrameReader reader(pool, scratch, params);
  ASSERT_TRUE(far.send(std::string("\x01", 1) + message("good") + std::string("\0", 1) + message("bad")));
  EXPECT_EQ(read(reader), Outcome::kWaiting);
  EXPECT_EQ(got, (std::vector<std::string>{"good", "bad"}));
  EXPECT_EQ(statuses, (std::vector<int>{1, 0}));
}

}  // namespace
}  // namespace extperfc::translate
