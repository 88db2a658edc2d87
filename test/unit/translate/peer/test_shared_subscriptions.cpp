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

/// Parts of one node that want the same topic.
class SharedSubscriptions : public Topics {
 protected:
  struct Consumer {
    std::vector<std::string> messages;
    int ups{0}, downs{0};
    bool wanted{true};
    std::unique_ptr<Subscription> subscription;
  };
  void begin(Consumer& consumer) {
    Subscription::Handlers handlers;
    handlers.on_up = [&](const PublisherLink&) {
      ++consumer.ups;
      return consumer.wanted;
    };
    handlers.on_message = [&](const PublisherLink&, const FramePtr& frame, SteadyTime) {
      consumer.messages.push_back(testing::text_of(frame));
    };
    handlers.on_down = [&](const PublisherLink&, const std::string&) { ++consumer.downs; };
    consumer.subscription = translator->subscribe("/chat", handlers, {});
  }

  std::unique_ptr<Peer> robot{make_plain("/robot")}, translator{make("/translator")};
  std::unique_ptr<Publication> publication{publish(*robot, "/chat")};
  Consumer clock, route;
};

TEST_F(SharedSubscriptions, OneConnectionServesEverybody) {
  begin(clock);
  begin(route);
  ASSERT_TRUE(until([&] { return clock.ups == 1 && route.ups == 1; }));
  for (int i = 0; i < 100; ++i) send_all(*publication, frame_of(std::to_string(i)));
  ASSERT_TRUE(until([&] { return clock.messages.size() == 100 && route.messages.size() == 100; }));
  EXPECT_EQ(clock.messages, route.messages);
  EXPECT_EQ(requests.size(), 1U) << "a second connection of one caller id makes rospy close the first";
  EXPECT_EQ(publication->links().size(), 1U);
}

TEST_F(SharedSubscriptions, OneThatComesLaterGetsTheLatchedMessage) {
  begin(clock);
  ASSERT_TRUE(until([&] { return clock.ups == 1; }));
  send_all(*publication, frame_of("old"));
  send_all(*publication, frame_of("latched"));
  ASSERT_TRUE(until([&] { return clock.messages.size() == 2; }));
  begin(route);
  ASSERT_TRUE(until([&] { return !route.messages.empty(); }));
  send_all(*publication, frame_of("new"));
  ASSERT_TRUE(until([&] { return route.messages.size() == 2; }));
  EXPECT_EQ(route.messages, (std::vector<std::string>{"latched", "new"}));
  EXPECT_EQ(clock.messages.size(), 3U);
  EXPECT_EQ(requests.size(), 1U);
}

TEST_F(SharedSubscriptions, TheConnectionLastsAsLongAsItHasSubscribers) {
  begin(clock);
  begin(route);
  ASSERT_TRUE(until([&] { return clock.ups == 1 && route.ups == 1; }));
  clock.subscription.reset();
  send_all(*publication, frame_of("still"));
  ASSERT_TRUE(until([&] { return route.messages.size() == 1; }));
  EXPECT_EQ(requests.size(), 1U);
  EXPECT_EQ(master.subscriber_count("/chat"), 1U);
  route.subscription.reset();
  EXPECT_TRUE(until([&] { return master.subscriber_count("/chat") == 0 && left.size() == 1; }));
}

TEST_F(SharedSubscriptions, WhatOneRefusesAnotherTakes) {
  clock.wanted = false;
  begin(clock);
  ASSERT_TRUE(until([&] { return left.size() == 1; })) << "no consumer was left";
  begin(route);
  ASSERT_TRUE(until([&] { return route.subscription->connected() == 1; }));
  send_all(*publication, frame_of("taken"));
  ASSERT_TRUE(until([&] { return route.messages.size() == 1; }));
  EXPECT_TRUE(clock.messages.empty());
  EXPECT_EQ(clock.subscription->connected(), 0U);
  route.subscription.reset();
  EXPECT_TRUE(until([&] { return left.size() == 2; })) << "no consumer is left";
}

TEST_F(SharedSubscriptions, OneMayLeaveWhileTheNextIsNotAskedYet) {
  Subscription::Handlers handlers;
  std::unique_ptr<Subscription> leaver;
  handlers.on_up = [&](const PublisherLink&) {
    leaver.reset();
    return true;
  };
  leaver = translator->subscribe("/chat", handlers, {});
  begin(route);
  ASSERT_TRUE(until([&] { return !leaver && route.ups == 1; }));
  for_a_while(milliseconds(50));
  send_all(*publication, frame_of("after"));
  EXPECT_TRUE(until([&] { return route.messages.size() == 1; }));
  EXPECT_EQ(requests.size(), 1U);
}

TEST_F(SharedSubscriptions, EverybodyHearsOfALostConnection) {
  begin(clock);
  begin(route);
  ASSERT_TRUE(until([&] { return clock.ups == 1 && route.ups == 1; }));
  publication->close(publication->links().at(0));
  ASSERT_TRUE(until([&] { return clock.ups == 2 && route.ups == 2; }));
  EXPECT_EQ(clock.downs, 1);
  EXPECT_EQ(route.downs, 1);
  EXPECT_EQ(clock.subscription->connected(), 1U);
}

TEST_F(SharedSubscriptions, OneMayEndWithinTheOthersHandler) {
  begin(clock);
  Subscription::Handlers handlers;
  std::unique_ptr<Subscription> ender;
  handlers.on_message = [&](const PublisherLink&, const FramePtr&, SteadyTime) {
    route.subscription.reset();
    clock.subscription.reset();
    ender.reset();
  };
  ender = translator->subscribe("/chat", handlers, {});
  begin(route);
  ASSERT_TRUE(until([&] { return clock.ups == 1 && route.ups == 1; }));
  send_all(*publication, frame_of("end"));
  ASSERT_TRUE(until([&] { return !ender; }));
  EXPECT_EQ(clock.messages.size(), 1U) << "it is older";
  EXPECT_TRUE(route.messages.empty()) << "it was gone already";
  EXPECT_TRUE(until([&] { return master.subscriber_count("/chat") == 0; }));
}

TEST_F(SharedSubscriptions, AConnectionThatEndsAgainAndAgainIsAProblem) {
  auto with = params("/watcher");
  with.tcpros.flap_window = milliseconds(1'000);
  const auto watcher = make(with);
  const auto subscription = subscribe(*watcher, "/chat");
  for (std::size_t life = 1; life <= 3; ++life) {
    ASSERT_TRUE(until([&] { return ups.size() == life && publication->links().size() == 1; }));
    EXPECT_TRUE(subscription->problem().empty()) << "once is no habit";
    publication->close(publication->links().at(0));
    ASSERT_TRUE(until([&] { return downs.size() == life; }));
  }
  EXPECT_NE(subscription->problem().find("again and again"), std::string::npos) << subscription->problem();
  EXPECT_NE(subscription->problem().find(robot->uri()), std::string::npos) << subscription->problem();
  ASSERT_FALSE(problems.empty());
  EXPECT_NE(problems.back().find("again and again"), std::string::npos) << problems.back();
  ASSERT_TRUE(until([&] { return ups.size() == 4; }));
  EXPECT_TRUE(until([&] { return subscription->problem().empty(); })) << "it has lasted";
}

}  // namespace
}  // namespace extperfc::translate
