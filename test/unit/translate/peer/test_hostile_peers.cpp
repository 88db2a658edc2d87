#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "test/unit/translate/peer/topic_helpers.hpp"

namespace extperfc::translate {
namespace {

using std::chrono::milliseconds;
using testing::FakePublisher;
using testing::little_endian;
using testing::RawSocket;
using testing::Topics;

ConnectionHeader subscriber_header() {
  return {{"topic", "/chat"}, {"md5sum", "*"}, {"type", "*"}, {"callerid", "/stranger"}};
}

class HostilePeers : public Topics {
 protected:
  void SetUp() override {
    auto with = params("/translator");
    with.tcpros.handshake = milliseconds(300);
    with.tcpros.header_bytes = 100'000;
    with.tcpros.message_bytes = 1'000'000;
    with.tcpros.links = 8;
    translator = make(with);
    publication = publish(*translator, "/chat");
    port = stream_port(translator->uri(), "/chat");
  }
  /// What the node answers to these bytes before it closes.
  std::string answer_to(const std::string& bytes) {
    auto stranger = RawSocket::connect_to(port);
    stranger.send(bytes);
    EXPECT_TRUE(until([&] { return stranger.drain(); }));
    return value_of(stranger.header(), "error");
  }
  void expect_well() {
    auto good = RawSocket::connect_to(port);
    good.send(subscriber_header());
    ASSERT_TRUE(until([&] {
      good.drain();
      return !good.header().empty();
    }));
    EXPECT_EQ(value_of(good.header(), "md5sum"), testing::kMd5);
  }

  std::unique_ptr<Peer> translator;
  std::unique_ptr<Publication> publication;
  std::uint16_t port{0};
};

TEST_F(HostilePeers, HeadersThatAreNoneAreRefused) {
  EXPECT_NE(answer_to(little_endian(0xffffffffU)).find("4294967295"), std::string::npos);
  EXPECT_NE(answer_to(little_endian(100'001)).find("100001"), std::string::npos);
  EXPECT_NE(answer_to("GET / HTTP/1.1\r\n\r\n").find("bytes"), std::string::npos);
  EXPECT_NE(answer_to(little_endian(8) + little_endian(1'000) + "topi").find("1000"), std::string::npos);
  EXPECT_NE(answer_to(little_endian(0)).find("neither"), std::string::npos);
  std::string fields;
  for (int i = 0; i < 10'000; ++i) fields += little_endian(3) + "a=b";
  EXPECT_NE(answer_to(little_endian(static_cast<std::uint32_t>(fields.size())) + fields).find("fields"),
            std::string::npos);
  expect_well();
}

TEST_F(HostilePeers, UnknownTopicsAndServicesAreRefusedByName) {
  const auto ask = [&](const ConnectionHeader& header) {
    const auto bytes = encode_header(header);
    return answer_to({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  };
  EXPECT_NE(ask({{"topic", "/nothing"}, {"md5sum", "*"}}).find("/nothing"), std::string::npos);
  EXPECT_NE(ask({{"service", "/no_service"}, {"md5sum", "*"}}).find("/no_service"), std::string::npos);
  EXPECT_NE(ask({{"callerid", "/x"}}).find("neither"), std::string::npos);
}

TEST_F(HostilePeers, HalfAHandshakeIsClosedAfterItsDeadline) {
  auto silent = RawSocket::connect_to(port);
  auto half = RawSocket::connect_to(port);
  half.send(little_endian(50) + little_endian(46) + "topic=");
  const auto begin = EventLoop::now();
  ASSERT_TRUE(until([&] { return silent.drain() && half.drain(); }));
  EXPECT_GE(EventLoop::now() - begin, milliseconds(200));
  expect_well();
}

TEST_F(HostilePeers, AByteAtATimeIsFineWithinTheDeadline) {
  auto slow = RawSocket::connect_to(port);
  const auto bytes = encode_header(subscriber_header());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    slow.send(bytes.data() + i, 1);
    loop.run_once(std::chrono::nanoseconds(0));
  }
  EXPECT_TRUE(until([&] { return publication->links().size() == 1; }));
}

TEST_F(HostilePeers, AFloodOfConnectionsDoesNotKeepOthersOut) {
  std::vector<RawSocket> flood;
  for (int i = 0; i < 100; ++i) {
    flood.push_back(RawSocket::connect_to(port));
    loop.run_once(std::chrono::nanoseconds(0));
  }
  expect_well();
}

TEST_F(HostilePeers, HeaderBombsTogetherAreBounded) {
  auto with = params("/bombed");
  with.tcpros.header_bytes = 100'000;
  const auto bombed = make(with);
  const auto topic = publish(*bombed, "/bombed");
  const auto bombed_port = stream_port(bombed->uri(), "/bombed");
  std::vector<RawSocket> bombs;
  for (int i = 0; i < 30; ++i) {
    bombs.push_back(RawSocket::connect_to(bombed_port));
    bombs.back().send(little_endian(100'000) + std::string(99'000, 'b'));
  }
  const auto refused = [&] {
    return std::count_if(bombs.begin(), bombs.end(), [](RawSocket& bomb) { return bomb.drain(); });
  };
  EXPECT_TRUE(until([&] { return refused() >= 13; }, std::chrono::seconds(4)));  // before any deadline
}

TEST_F(HostilePeers, TooManySubscribersOfATopicAreRefused) {
  std::vector<RawSocket> many;
  for (int i = 0; i < 8; ++i) {
    many.push_back(RawSocket::connect_to(port));
    many.back().send(subscriber_header());
    const auto count = static_cast<std::size_t>(i) + 1;
    ASSERT_TRUE(until([&] { return publication->links().size() == count; }));
  }
  const auto bytes = encode_header(subscriber_header());
  EXPECT_NE(answer_to({reinterpret_cast<const char*>(bytes.data()), bytes.size()}).find("too many"),
            std::string::npos);
}

/// A publisher that sends these bytes after a proper header.
class HostilePublisher : public HostilePeers {
 protected:
  void meet(const std::string& bytes) {
    fake = std::make_unique<FakePublisher>(loop);
    master.set_publishers("/in", {fake->uri});
    subscription = subscribe(*translator, "/in");
    ASSERT_TRUE(until([&] { return static_cast<bool>(accepted = fake->listening.accept()); }));
    accepted.send(ConnectionHeader{{"type", "a/B"}, {"md5sum", "0"}});
    accepted.send(bytes);
  }
  RawSocket accepted;
  std::unique_ptr<FakePublisher> fake;
  std::unique_ptr<Subscription> subscription;
};

TEST_F(HostilePublisher, AnAbsurdMessageLengthEndsTheConnection) {
  meet(little_endian(2) + "ok" + little_endian(0x7fffffffU) + "xxx");
  ASSERT_TRUE(until([&] { return downs.size() == 1 && accepted.drain(); }));
  EXPECT_EQ(messages, std::vector<std::string>{"ok"});
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_NE(problems[0].find("2147483647"), std::string::npos) << problems[0];
  EXPECT_TRUE(until([&] { return static_cast<bool>(fake->listening.accept()); }));  // retried
}

TEST_F(HostilePublisher, ATruncatedMessageIsNotDelivered) {
  meet(little_endian(2) + "ok" + little_endian(10) + "half");
  ASSERT_TRUE(until([&] { return messages.size() == 1; }));
  accepted.close();
  ASSERT_TRUE(until([&] { return downs.size() == 1; }));
  EXPECT_NE(downs[0].find("middle"), std::string::npos) << downs[0];
  EXPECT_EQ(messages.size(), 1U);
}

TEST_F(HostilePublisher, EmptyMessagesAreMessages) {
  meet(little_endian(0) + little_endian(0) + little_endian(1) + "x");
  ASSERT_TRUE(until([&] { return messages.size() == 3; }));
  EXPECT_EQ(messages, (std::vector<std::string>{"", "", "x"}));
}

TEST_F(HostilePublisher, OneThatNeverAnswersIsGivenUpAndTriedAgain) {
  auto with = params("/impatient");
  with.node_timeout = milliseconds(200);
  const auto impatient = make(with);
  FakePublisher deaf(loop);
  master.set_publishers("/deaf", {deaf.uri});
  subscription = subscribe(*impatient, "/deaf");
  EXPECT_TRUE(until([&] { return deaf.asked >= 2; }));
  EXPECT_EQ(problems.size(), 1U);
}

TEST_F(HostilePublisher, NonsenseInsteadOfAnAddressIsAProblem) {
  RpcServer liar(loop);
  int asked = 0;
  const std::vector<XmlValue> answers{XmlValue(3), XmlArray{1, "", XmlArray{}}, XmlArray{0, "no", 0},
                                      XmlArray{1, "", XmlArray{"TCPROS", "127.0.0.1", 70'000}},
                                      XmlArray{1, "", XmlArray{"UDPROS", "127.0.0.1", 7'000}}};
  const auto opened = liar.open("127.0.0.1", 0, [&](const XmlCall&, const std::string&) {
    return answers[static_cast<std::size_t>(asked++) % answers.size()];
  });
  ASSERT_TRUE(opened);
  master.set_publishers("/lies", {"http://127.0.0.1:" + std::to_string(*opened) + "/", "not a uri", ""});
  subscription = subscribe(*translator, "/lies");
  EXPECT_TRUE(until([&] { return asked >= 5; }));
  EXPECT_TRUE(ups.empty());
  EXPECT_GE(problems.size(), 5U);
  expect_well();
}

}  // namespace
}  // namespace extperfc::translate
