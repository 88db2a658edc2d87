#include <cerrno>

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include "test/unit/translate/peer/loop_until.hpp"
#include "translate/peer/tcpros_half_open.hpp"

namespace extperfc::translate {
namespace {

/// A connection from a subscriber to a listening port of ours.
class HalfOpen : public testing::Test {
 protected:
  HalfOpen() {
    auto listening = listen_on("127.0.0.1", 0);
    if (!listening) throw std::runtime_error(listening.error().message);
    listener_ = std::move(listening->socket);
    auto connecting = begin_connect("127.0.0.1", listening->port);
    if (!connecting) throw std::runtime_error(connecting.error().message);
    subscriber_ = std::move(*connecting);
    const bool accepted = loop_until(loop_, [this] {
      ours_ = LoopSocket(::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK));
      return static_cast<bool>(ours_);
    });
    if (!accepted) throw std::runtime_error("no connection");
    ends_ = ends_of(ours_.get());
  }
  /// As when the network is away: neither an end nor a reset leaves. Needs CAP_NET_ADMIN.
  [[nodiscard]] bool vanish() {
    const int on = 1;
    if (::setsockopt(ours_.get(), IPPROTO_TCP, TCP_REPAIR, &on, sizeof(on)) != 0) return false;
    ours_.close();
    return true;
  }
  /// What a subscriber that reads finds: 0 nothing yet, else errno.
  [[nodiscard]] int finds() const {
    char byte = 0;
    const auto got = ::recv(subscriber_.get(), &byte, 1, MSG_DONTWAIT);
    if (got == 0) return -1;
    return errno == EAGAIN ? 0 : errno;
  }

  EventLoop loop_;
  LoopSocket listener_, subscriber_, ours_;
  ConnectionEnds ends_;
};

TEST_F(HalfOpen, ASubscriberThatMissedOurEndLearnsOfIt) {
  if (!vanish()) GTEST_SKIP() << "TCP_REPAIR needs the capability CAP_NET_ADMIN";
  EXPECT_EQ(finds(), 0) << "it does not know yet";
  HalfOpenNotices notices(loop_);
  int notified = 0;
  notices.notify(ends_, [&] { ++notified; });
  EXPECT_TRUE(loop_until(loop_, [this] { return finds() == ECONNRESET; }));
  EXPECT_TRUE(loop_until(loop_, [&] { return notices.pending() == 0; }));
  EXPECT_EQ(notified, 1);
  auto other = begin_connect("127.0.0.1", ntohs(reinterpret_cast<const sockaddr_in&>(ends_.local).sin_port));
  EXPECT_TRUE(other) << "the port still takes subscribers";
}

TEST_F(HalfOpen, OneThatIsGoneNeedsNoNotice) {
  subscriber_.close();
  abort_connection(ours_);
  HalfOpenNotices notices(loop_);
  int notified = 0;
  notices.notify(ends_, [&] { ++notified; });
  EXPECT_TRUE(loop_until(loop_, [&] { return notified == 1; })) << "a new connection may begin";
  EXPECT_EQ(notices.pending(), 0U);
}

TEST_F(HalfOpen, AnAbortedConnectionIsResetAtOnce) {
  abort_connection(ours_);
  EXPECT_TRUE(loop_until(loop_, [this] { return finds() == ECONNRESET; }));
}

TEST_F(HalfOpen, UnknownEndsAreLeftAlone) {
  HalfOpenNotices notices(loop_);
  notices.notify(ends_of(-1), [] { ADD_FAILURE() << "no one was notified"; });
  EXPECT_EQ(notices.pending(), 0U);
}

TEST_F(HalfOpen, ACallbackMayNotifyAgain) {
  subscriber_.close();
  abort_connection(ours_);
  HalfOpenNotices notices(loop_);
  int notified = 0;
  notices.notify(ends_, [&] {
    ++notified;
    notices.notify(ends_, [&] { ++notified; });
  });
  EXPECT_TRUE(loop_until(loop_, [&] { return notified == 2; }));
}

}  // namespace
}  // namespace extperfc::translate
