#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "test/unit/translate/peer/topic_helpers.hpp"

namespace extperfc::translate {
namespace {

using std::chrono::milliseconds;
using testing::frame_of;
using testing::Topics;

TEST_F(Topics, AMessageArrivesWithThePublishersHeader) {
  const auto robot = make_plain("/robot");
  const auto translator = make("/translator");
  const auto subscription = subscribe(*translator, "/chat");
  const auto publication = publish(*robot, "/chat");
  ASSERT_TRUE(until([&] { return ups.size() == 1; }));
  send_all(*publication, frame_of("hello"));
  ASSERT_TRUE(until([&] { return messages.size() == 1; }));
  EXPECT_EQ(messages[0], "hello");
  EXPECT_EQ(value_of(ups[0].header, "type"), "std_msgs/String");
  EXPECT_EQ(value_of(ups[0].header, "md5sum"), testing::kMd5);
  EXPECT_EQ(value_of(ups[0].header, "message_definition"), "string data\n");
  EXPECT_EQ(value_of(ups[0].header, "latching"), "1");
  EXPECT_EQ(value_of(ups[0].header, "callerid"), "/robot");
  EXPECT_EQ(ups[0].uri, robot->uri());
  EXPECT_EQ(value_of(requests.at(0), "md5sum"), "*");
  EXPECT_EQ(value_of(requests.at(0), "callerid"), "/translator");
  EXPECT_EQ(value_of(requests.at(0), "tcp_nodelay"), "1");
  EXPECT_EQ(value_of(requests.at(0), kTranslatorKey), "/translator");
  EXPECT_EQ(subscription->connected(), 1U);
}

TEST_F(Topics, WhatIsSentWithinTheRequestComesFirst) {
  const auto robot = make_plain("/robot");
  const auto translator = make("/translator");
  Publication* sender = nullptr;
  greet = [&](LinkId id) { sender->send(id, frame_of("latched"), EventLoop::now()); };
  const auto publication = publish(*translator, "/map");
  sender = publication.get();
  const auto subscription = subscribe(*robot, "/map");
  ASSERT_TRUE(until([&] { return messages.size() == 1; }));
  EXPECT_EQ(messages[0], "latched");
}

TEST_F(Topics, TenThousandMessagesKeepTheirOrder) {
  const auto robot = make_plain("/robot");
  const auto translator = make("/translator");
  const auto subscription = subscribe(*translator, "/chat");
  SendParams with;
  with.queue = 20'000;
  const auto publication = publish(*robot, "/chat", with);
  ASSERT_TRUE(until([&] { return ups.size() == 1; }));
  for (int i = 0; i < 10'000; ++i) send_all(*publication, frame_of(std::to_string(i)));
  ASSERT_TRUE(until([&] { return messages.size() == 10'000; }));
  for (int i = 0; i < 10'000; ++i) ASSERT_EQ(messages[static_cast<std::size_t>(i)], std::to_string(i));
  EXPECT_EQ(publication->stats(publication->links().at(0)).messages, 10'000U);
}

TEST_F(Topics, SixMegabytesArriveAtEverySubscriberFromOneFrame) {
  const auto robot = make_plain("/robot");
  const auto translator = make("/translator");
  const auto publication = publish(*robot, "/image");
  const auto first = subscribe(*translator, "/image");
  const auto second = subscribe(*translator, "/image");
  ASSERT_TRUE(until([&] { return ups.size() == 2; }));
  std::string large(6U << 20U, '\0');
  for (std::size_t i = 0; i < large.size(); ++i) large[i] = static_cast<char>(i * 7 + i / 251);
  const auto frame = frame_of(large);
  send_all(*publication, frame);
  send_all(*publication, frame_of("after"));
  ASSERT_TRUE(until([&] { return messages.size() == 4; }));
  EXPECT_EQ(std::count(messages.begin(), messages.end(), large), 2);
  EXPECT_EQ(std::count(messages.begin(), messages.end(), "after"), 2);
}

TEST_F(Topics, APublisherThatComesLaterOrAgainIsFound) {
  auto robot = make_plain("/robot");
  const auto translator = make("/translator");
  const auto subscription = subscribe(*translator, "/chat");
  ASSERT_TRUE(until([&] { return master.subscriber_count("/chat") == 1; }));
  auto publication = publish(*robot, "/chat");
  ASSERT_TRUE(until([&] { return ups.size() == 1; }));
  publication.reset();
  ASSERT_TRUE(until([&] { return gone.size() == 1; }));
  EXPECT_EQ(downs.size(), 1U);
  EXPECT_EQ(subscription->connected(), 0U);
  publication = publish(*robot, "/chat");
  ASSERT_TRUE(until([&] { return ups.size() == 2; }));
  send_all(*publication, frame_of("again"));
  EXPECT_TRUE(until([&] { return messages.size() == 1; }));
}

TEST_F(Topics, ALostConnectionIsMadeAgain) {
  const auto robot = make_plain("/robot");
  const auto translator = make("/translator");
  const auto subscription = subscribe(*translator, "/chat");
  const auto publication = publish(*robot, "/chat");
  ASSERT_TRUE(until([&] { return ups.size() == 1; }));
  publication->close(publication->links().at(0));
  ASSERT_TRUE(until([&] { return ups.size() == 2; }));
  EXPECT_EQ(downs.size(), 1U);
  EXPECT_TRUE(gone.empty());
  EXPECT_NE(ups[0].id, ups[1].id);
}

TEST_F(Topics, AnnouncingAgainBringsSubscribersBack) {
  const auto robot = make_plain("/robot");
  const auto translator = make("/translator");
  const auto publication = publish(*translator, "/chat");
  const auto subscription = subscribe(*robot, "/chat");
  ASSERT_TRUE(until([&] { return ups.size() == 1; }));
  publication->announce_again();
  EXPECT_TRUE(publication->links().empty());
  ASSERT_TRUE(until([&] { return ups.size() >= 2 && left.size() == 1; }));
  EXPECT_GE(master.calls["unregisterPublisher"], 1);
  EXPECT_TRUE(until([&] { return publication->links().size() == 1; }));
}

TEST_F(Topics, AnUnwantedPublisherIsLeftAloneUntilItRegistersAgain) {
  const auto robot = make_plain("/robot");
  const auto translator = make("/translator");
  wanted = false;
  const auto subscription = subscribe(*translator, "/chat");
  auto publication = publish(*robot, "/chat");
  ASSERT_TRUE(until([&] { return ups.size() == 1 && left.size() == 1; }));
  for_a_while(milliseconds(400));
  EXPECT_EQ(ups.size(), 1U);
  EXPECT_EQ(subscription->connected(), 0U);
  wanted = true;
  publication.reset();
  publication = publish(*robot, "/chat");
  EXPECT_TRUE(until([&] { return subscription->connected() == 1; }));
}

TEST_F(Topics, TranslatorsRefuseEachOther) {
  const auto one = make("/one");
  const auto other = make("/other");
  const auto publication = publish(*one, "/chat");
  const auto subscription = subscribe(*other, "/chat");
  ASSERT_TRUE(until([&] { return problems.size() == 1; }));
  for_a_while(milliseconds(300));
  EXPECT_EQ(problems.size(), 1U);
  EXPECT_NE(problems[0].find("/one"), std::string::npos) << problems[0];
  EXPECT_TRUE(requests.empty());
  EXPECT_TRUE(ups.empty());
}

TEST_F(Topics, AMarkedPublisherIsClosedAndNotAskedAgain) {
  testing::FakePublisher fake(loop);
  const auto translator = make("/translator");
  master.set_publishers("/chat", {fake.uri});
  const auto subscription = subscribe(*translator, "/chat");
  testing::RawSocket accepted;
  ASSERT_TRUE(until([&] { return static_cast<bool>(accepted = fake.listening.accept()); }));
  accepted.send(ConnectionHeader{{"type", "a/B"}, {"md5sum", "0"}, {kTranslatorKey, "/far"}});
  ASSERT_TRUE(until([&] { return accepted.drain(); }));
  for_a_while(milliseconds(300));
  EXPECT_EQ(fake.asked, 1);
  EXPECT_EQ(problems.size(), 1U);
  EXPECT_TRUE(ups.empty());
}

TEST_F(Topics, OurOwnPublicationIsNotSubscribed) {
  const auto translator = make("/translator");
  const auto publication = publish(*translator, "/chat");
  const auto subscription = subscribe(*translator, "/chat");
  ASSERT_TRUE(
      until([&] { return master.subscriber_count("/chat") == 1 && master.publisher_count("/chat") == 1; }));
  for_a_while(milliseconds(200));
  EXPECT_TRUE(problems.empty());
  EXPECT_TRUE(requests.empty());
}

TEST_F(Topics, ARefusalIsReportedOnceAndTriedAgain) {
  const auto robot = make_plain("/robot");
  const auto translator = make("/translator");
  int asked = 0;
  Publication::Handlers handlers;
  handlers.on_request = [&](const std::shared_ptr<SubscriberRequest>& request) {
    ++asked;
    request->refuse("the md5 is wrong");
  };
  const auto publication = robot->advertise("/chat", "std_msgs/String", handlers, {});
  const auto subscription = subscribe(*translator, "/chat");
  ASSERT_TRUE(until([&] { return asked >= 3; }));
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_NE(problems[0].find("the md5 is wrong"), std::string::npos) << problems[0];
}

TEST_F(Topics, ARequestLetGoIsRefusedAndALateOneIsClosed) {
  auto robot_params = params("/robot");
  robot_params.marked = false;
  robot_params.tcpros.handshake = milliseconds(200);
  const auto robot = make(robot_params);
  std::vector<std::shared_ptr<SubscriberRequest>> held;
  bool hold = false;
  Publication::Handlers handlers;
  handlers.on_request = [&](const std::shared_ptr<SubscriberRequest>& request) {
    if (hold) held.push_back(request);
  };
  const auto publication = robot->advertise("/chat", "std_msgs/String", handlers, {});
  const auto port = stream_port(robot->uri(), "/chat");
  const ConnectionHeader header{{"topic", "/chat"}, {"md5sum", "*"}, {"type", "*"}, {"callerid", "/c"}};
  auto first = testing::RawSocket::connect_to(port);
  first.send(header);
  ASSERT_TRUE(until([&] { return first.drain(); }));
  EXPECT_FALSE(value_of(first.header(), "error").empty());
  hold = true;
  auto second = testing::RawSocket::connect_to(port);
  second.send(header);
  ASSERT_TRUE(until([&] { return second.drain(); }));
  ASSERT_EQ(held.size(), 1U);
  EXPECT_EQ(held[0]->accept("std_msgs/String", testing::kMd5, "", false), 0U);
  EXPECT_EQ(value_of(held[0]->header(), "callerid"), "/c");
  EXPECT_EQ(held[0]->remote_address(), "127.0.0.1");
}

TEST_F(Topics, ASlowReaderGetsTheNewestAndIsBounded) {
  const auto translator = make("/translator");
  SendParams with;
  with.queue = 3;
  const auto publication = publish(*translator, "/chat", with);
  auto reader = testing::RawSocket::connect_to(stream_port(translator->uri(), "/chat"));
  reader.send(ConnectionHeader{{"topic", "/chat"}, {"md5sum", "*"}, {"type", "*"}, {"callerid", "/slow"}});
  ASSERT_TRUE(until([&] { return publication->links().size() == 1; }));
  const auto id = publication->links()[0];
  const int count = 400;
  for (int i = 0; i < count; ++i) {
    publication->send(id, frame_of(std::string(100'000, 'x') + std::to_string(i)), EventLoop::now());
    loop.run_once(std::chrono::nanoseconds(0));
    ASSERT_LE(publication->stats(id).waiting, 4U);
  }
  const auto stats = publication->stats(id);
  EXPECT_GT(stats.dropped_queue, 0U);
  const auto ending = std::string("x") + std::to_string(count - 1);
  ASSERT_TRUE(until([&] {
    reader.drain();
    return reader.received.size() > ending.size() && publication->stats(id).waiting == 0 &&
           reader.received.compare(reader.received.size() - ending.size(), ending.size(), ending) == 0;
  }));
  EXPECT_EQ(publication->stats(id).messages + stats.dropped_queue, static_cast<std::uint64_t>(count));
}

TEST_F(Topics, AReaderThatStopsIsCutAfterItsPatience) {
  const auto translator = make("/translator");
  SendParams with;
  with.unacknowledged = milliseconds(300);
  const auto publication = publish(*translator, "/chat", with);
  auto reader = testing::RawSocket::connect_to(stream_port(translator->uri(), "/chat"));
  reader.send(ConnectionHeader{{"topic", "/chat"}, {"md5sum", "*"}, {"type", "*"}, {"callerid", "/dead"}});
  ASSERT_TRUE(until([&] { return publication->links().size() == 1; }));
  const auto id = publication->links()[0];
  for (int i = 0; i < 20; ++i) publication->send(id, frame_of(std::string(2'000'000, 'x')), EventLoop::now());
  ASSERT_GT(publication->stats(id).waiting, 0U);
  const auto begin = EventLoop::now();
  ASSERT_TRUE(until([&] { return left.size() == 1; }));
  EXPECT_GE(EventLoop::now() - begin, milliseconds(200));
  EXPECT_TRUE(publication->links().empty());
}

TEST_F(Topics, ASubscriberThatTalksChangesNothing) {
  const auto translator = make("/translator");
  const auto publication = publish(*translator, "/chat");
  auto talker = testing::RawSocket::connect_to(stream_port(translator->uri(), "/chat"));
  talker.send(ConnectionHeader{{"topic", "/chat"}, {"md5sum", "*"}, {"type", "*"}, {"callerid", "/t"}});
  ASSERT_TRUE(until([&] { return publication->links().size() == 1; }));
  for (int i = 0; i < 200; ++i) {
    talker.send(std::string(100'000, 't'));
    loop.run_once(std::chrono::nanoseconds(0));
  }
  const auto before = talker.received.size();
  send_all(*publication, frame_of("still here"));
  ASSERT_TRUE(until([&] {
    talker.drain();
    return talker.received.size() > before && talker.received.find("still here") != std::string::npos;
  }));
  EXPECT_TRUE(left.empty());
}

TEST_F(Topics, ASubscriberThatLeavesIsReported) {
  const auto robot = make_plain("/robot");
  const auto translator = make("/translator");
  const auto publication = publish(*translator, "/chat");
  auto subscription = subscribe(*robot, "/chat");
  ASSERT_TRUE(until([&] { return publication->links().size() == 1; }));
  subscription.reset();
  ASSERT_TRUE(until([&] { return left.size() == 1; }));
  EXPECT_TRUE(until([&] { return master.subscriber_count("/chat") == 0; }));
}

TEST_F(Topics, EverythingMayBeDestroyedInItsOwnCallbacks) {
  const auto robot = make_plain("/robot");
  const auto translator = make("/translator");
  for (const std::string when : {"up", "message", "down", "request", "left"}) {
    std::unique_ptr<Publication> publication;
    std::unique_ptr<Subscription> subscription;
    int ended = 0;
    Publication::Handlers out;
    out.on_request = [&](const std::shared_ptr<SubscriberRequest>& request) {
      if (when == "request") publication.reset(), ++ended;
      request->accept("std_msgs/String", testing::kMd5, "", false);
    };
    out.on_down = [&](LinkId, const std::string&) {
      if (when == "left") publication.reset(), ++ended;
    };
    Subscription::Handlers in;
    in.on_up = [&](const PublisherLink&) {
      if (when == "up") subscription.reset(), ++ended;
      return true;
    };
    in.on_message = [&](const PublisherLink&, const FramePtr&, SteadyTime) {
      if (when == "message") subscription.reset(), ++ended;
    };
    in.on_down = [&](const PublisherLink&, const std::string&) {
      if (when == "down") subscription.reset(), ++ended;
    };
    publication = robot->advertise("/" + when, "std_msgs/String", out, {});
    subscription = translator->subscribe("/" + when, in, {});
    const auto act = [&] {
      if (!publication || publication->links().empty()) return;
      for (int i = 0; i < 5; ++i) send_all(*publication, frame_of("x"));
      if (when == "down") publication->close(publication->links()[0]);
      if (when == "left" && subscription && subscription->connected() == 1) subscription.reset();
    };
    EXPECT_TRUE(until([&] {
      act();
      return ended > 0;
    })) << when;
    for_a_while(milliseconds(30));
    EXPECT_EQ(ended, 1) << when;
  }
}

TEST_F(Topics, ConnectionsOutliveTheMaster) {
  const auto robot = make_plain("/robot");
  const auto translator = make("/translator");
  const auto subscription = subscribe(*translator, "/chat");
  const auto publication = publish(*robot, "/chat");
  ASSERT_TRUE(until([&] { return ups.size() == 1; }));
  master.stop();
  ASSERT_TRUE(until([&] { return !translator->master().reachable; }));
  send_all(*publication, frame_of("without a master"));
  ASSERT_TRUE(until([&] { return messages.size() == 1; }));
  master.start();
  ASSERT_TRUE(
      until([&] { return master.publisher_count("/chat") == 1 && master.subscriber_count("/chat") == 1; }));
  for_a_while(milliseconds(100));
  send_all(*publication, frame_of("with another"));
  ASSERT_TRUE(until([&] { return messages.size() == 2; }));
  EXPECT_TRUE(downs.empty());
  EXPECT_EQ(translator->master().restarts, 1U);
}

TEST_F(Topics, APublisherThatANewMasterDoesNotKnowIsKeptUntilItLeaves) {
  testing::FakePublisher fake(loop);
  const auto translator = make("/translator");
  master.set_publishers("/chat", {fake.uri});
  const auto subscription = subscribe(*translator, "/chat");
  testing::RawSocket accepted;
  ASSERT_TRUE(until([&] { return static_cast<bool>(accepted = fake.listening.accept()); }));
  accepted.send(ConnectionHeader{{"type", "a/B"}, {"md5sum", "0"}});
  ASSERT_TRUE(until([&] { return ups.size() == 1; }));
  master.stop();
  ASSERT_TRUE(until([&] { return !translator->master().reachable; }));
  master.start();
  ASSERT_TRUE(until([&] { return master.subscriber_count("/chat") == 1; }));
  for_a_while(milliseconds(100));
  accepted.send(testing::little_endian(2) + "ok");
  ASSERT_TRUE(until([&] { return messages.size() == 1; }));
  EXPECT_TRUE(gone.empty());
  accepted.close();
  EXPECT_TRUE(until([&] { return gone.size() == 1 && downs.size() == 1; }));
}

}  // namespace
}  // namespace extperfc::translate
