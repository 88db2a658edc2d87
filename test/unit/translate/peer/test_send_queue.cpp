#include <string>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include "test/unit/translate/peer/raw_socket.hpp"
#include "translate/peer/tcpros_send_queue.hpp"

namespace extperfc::translate {
namespace {

using testing::little_endian;
using testing::RawSocket;
using Outcome = SendQueue::Outcome;

FramePtr frame_of(const std::string& text) {
  auto frame = std::make_shared<Frame>();
  frame->buffer().append(text.data(), text.size());
  frame->seal();
  return frame;
}

class SendQueueTest : public ::testing::Test {
 protected:
  void SetUp() override {
    int pair[2];
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, pair), 0);
    ours = RawSocket(pair[0]);
    theirs = RawSocket(pair[1]);
  }
  /// Until the socket takes no more.
  void block() {
    queue.push(frame_of(std::string(8U << 20U, 'x')), EventLoop::now());
    ASSERT_EQ(queue.write(ours.get()), Outcome::kBlocked);
  }
  /// What the other end receives in the end, without the message that blocked.
  std::string received_after_block() {
    while (queue.write(ours.get()) == Outcome::kBlocked) theirs.drain();
    theirs.drain();
    return theirs.received.substr(4 + (8U << 20U));
  }
  void configure(std::size_t messages, std::size_t bytes, std::chrono::milliseconds age) {
    SendParams params;
    params.queue = messages;
    params.queue_bytes = bytes;
    params.max_age = age;
    queue.configure(params);
  }

  RawSocket ours, theirs;
  SendQueue queue;
};

TEST_F(SendQueueTest, ManyLeaveInOrderWithTheirLengths) {
  configure(1000, 1U << 20U, {});
  std::string expected;
  for (int i = 0; i < 300; ++i) {
    const auto text = "message " + std::to_string(i);
    queue.push(frame_of(text), EventLoop::now());
    expected += little_endian(static_cast<std::uint32_t>(text.size())) + text;
  }
  while (!queue.empty()) {
    ASSERT_NE(queue.write(ours.get()), Outcome::kBroken);
    theirs.drain();
  }
  EXPECT_EQ(theirs.received, expected);
  EXPECT_EQ(queue.stats().messages, 300U);
  EXPECT_EQ(queue.stats().bytes, expected.size() - 300 * 4);
  EXPECT_EQ(queue.stats().waiting, 0U);
}

TEST_F(SendQueueTest, TheOldestIsDroppedButNeverTheOneUnderWay) {
  configure(2, 1U << 20U, {});
  block();
  for (const auto* text : {"a", "b", "c", "d"}) queue.push(frame_of(text), EventLoop::now());
  EXPECT_EQ(queue.stats().dropped_queue, 2U);
  EXPECT_EQ(queue.stats().waiting, 3U);
  EXPECT_EQ(received_after_block(), little_endian(1) + "c" + little_endian(1) + "d");
}

TEST_F(SendQueueTest, ALengthOfZeroKeepsTheLatest) {
  configure(0, 1U << 20U, {});
  block();
  for (const auto* text : {"a", "b", "c"}) queue.push(frame_of(text), EventLoop::now());
  EXPECT_EQ(received_after_block(), little_endian(1) + "c");
}

TEST_F(SendQueueTest, BytesAreBoundedButOneMessageIsAlwaysTaken) {
  configure(100, 1000, {});
  block();
  for (int i = 0; i < 5; ++i)
    queue.push(frame_of(std::string(400, static_cast<char>('a' + i))), EventLoop::now());
  EXPECT_EQ(queue.stats().dropped_queue, 3U);
  queue.push(frame_of(std::string(5000, 'z')), EventLoop::now());
  EXPECT_EQ(queue.stats().waiting, 2U);
  EXPECT_EQ(received_after_block(), little_endian(5000) + std::string(5000, 'z'));
}

TEST_F(SendQueueTest, OldOnesAreDroppedInsteadOfSent) {
  configure(100, 1U << 20U, std::chrono::milliseconds(200));
  block();
  const auto now = EventLoop::now();
  queue.push(frame_of("stale"), now - std::chrono::milliseconds(300));
  queue.push(frame_of("fresh"), now + std::chrono::seconds(100));
  EXPECT_EQ(received_after_block(), little_endian(5) + "fresh");
  EXPECT_EQ(queue.stats().dropped_age, 1U);
}

TEST_F(SendQueueTest, TheHeaderIsNeitherCountedNorDropped) {
  configure(1, 10, std::chrono::milliseconds(1));
  queue.push_header(frame_of(std::string(100, 'h')));
  for (const auto* text : {"a", "b"})
    queue.push(frame_of(text), EventLoop::now() + std::chrono::seconds(100));
  ASSERT_EQ(queue.write(ours.get()), Outcome::kEmpty);
  theirs.drain();
  EXPECT_EQ(theirs.received, little_endian(100) + std::string(100, 'h') + little_endian(1) + "b");
  EXPECT_EQ(queue.stats().messages, 1U);
}

TEST_F(SendQueueTest, AClosedSocketIsBrokenWithoutASignal) {
  configure(1, 10, {});
  theirs.close();
  queue.push(frame_of("a"), EventLoop::now());
  EXPECT_EQ(queue.write(ours.get()), Outcome::kBroken);
  EXPECT_FALSE(queue.problem().empty());
}

}  // namespace
}  // namespace extperfc::translate
