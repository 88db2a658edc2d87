#include <algorithm>

#include <gtest/gtest.h>

#include "test/unit/translate/bridge/bridge_fixture.hpp"
#include "translate/bridge/topic_route.hpp"

namespace extperfc::translate::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

class TopicRouteTest : public BridgeFixture {
 protected:
  TopicRoute& make(TopicRoute::Params params) {
    params.topic = params.topic.empty() ? "/value" : params.topic;
    params.type = params.type.empty() ? kType : params.type;
    topic_ = params.topic;
    route_ = std::make_unique<TopicRoute>(context_, std::move(params));
    return *route_;
  }
  TopicRoute& make() { return make({}); }
  FakePublication& publication() { return *workstation_.topics.publications.at(topic_); }
  FakeSubscription& subscription() { return *robot_.topics.subscriptions.at(topic_); }
  [[nodiscard]] bool subscribed() const { return robot_.topics.subscriptions.count(topic_) != 0; }
  [[nodiscard]] std::vector<Bytes> received(const Handshake& handshake) {
    std::vector<Bytes> all;
    for (const auto& frame : publication().sent.at(handshake.link)) all.push_back(bytes_of(frame->payload()));
    return all;
  }

  std::string topic_;
  std::unique_ptr<TopicRoute> route_;
};

TEST_F(TopicRouteTest, EachSubscriberGetsTheVersionItAskedFor) {
  make();
  const auto same = publication().request(subscriber(robot_schema_));
  const auto changed = publication().request(subscriber(workstation_schema_));
  EXPECT_FALSE(same->accepted) << "the publisher's definition is not known yet";
  const auto link = subscription().connect(publisher(robot_schema_));
  ASSERT_TRUE(same->accepted && changed->accepted);
  EXPECT_EQ(same->md5, robot_schema_->md5());
  EXPECT_EQ(changed->md5, workstation_schema_->md5());
  const auto frame = frame_of({7, 0, 0, 0});
  subscription().message(link, frame);
  EXPECT_EQ(publication().sent.at(same->link).at(0), frame) << "the very buffer";
  EXPECT_EQ(received(*changed), (std::vector<Bytes>{{7, 0, 0, 0, 0, 0}}));
  const auto status = route_->status();
  ASSERT_EQ(status.to.size(), 2U);
  EXPECT_EQ(status.messages, 1U);
  EXPECT_EQ(status.failed, 0U);
}

TEST_F(TopicRouteTest, TwoPublishersOfDifferentVersionsReachOneSubscriber) {
  make();
  const auto listener = publication().request(subscriber(workstation_schema_));
  const auto first = subscription().connect(publisher(robot_schema_, "/a"));
  const auto second = subscription().connect(publisher(workstation_schema_, "/b"));
  subscription().message(first, frame_of({1, 0, 0, 0}));
  subscription().message(second, frame_of({2, 0, 0, 0, 9, 0}));
  EXPECT_EQ(received(*listener), (std::vector<Bytes>{{1, 0, 0, 0, 0, 0}, {2, 0, 0, 0, 9, 0}}));
}

TEST_F(TopicRouteTest, WhoTakesAnythingGetsThePublishersVersion) {
  make();
  const auto recorder = publication().request({{"type", "*"}, {"md5sum", "*"}, {"callerid", "/rosbag"}});
  subscription().connect(publisher(robot_schema_));
  ASSERT_TRUE(recorder->accepted);
  EXPECT_EQ(recorder->md5, robot_schema_->md5());
  EXPECT_EQ(recorder->type, kType);
}

TEST_F(TopicRouteTest, AnUnknownVersionIsRefusedWithTheRemedy) {
  make();
  const auto listener = publication().request(subscriber(workstation_schema_, false));
  subscription().connect(publisher(robot_schema_));
  EXPECT_TRUE(listener->refused);
  EXPECT_NE(listener->reason.find(workstation_schema_->md5()), std::string::npos);
  EXPECT_NE(listener->reason.find("add its package"), std::string::npos);
  ASSERT_EQ(problems_.size(), 1U);
  EXPECT_EQ(route_->status().problem, problems_[0]);
}

TEST_F(TopicRouteTest, EqualMd5OfAnotherLayoutDoesNotPass) {
  const std::string point = "================\nMSG: demo/P\nint8 x\n";
  const auto one = schema("P p\n" + point);
  const auto many = schema("P[] p\n" + point);
  ASSERT_EQ(one->md5(), many->md5());
  make();
  const auto listener = publication().request(subscriber(many));
  subscription().connect(publisher(one));
  EXPECT_FALSE(listener->accepted);
  EXPECT_TRUE(listener->refused);
}

TEST_F(TopicRouteTest, IsSubscribedOnlyWhileThereAreSubscribers) {
  auto& route = make();
  route.update(false, 1);
  EXPECT_FALSE(subscribed());
  route.update(true, 2);
  EXPECT_TRUE(subscribed());
  EXPECT_EQ(subscription().compared, 2U) << "the count is passed on";
}

TEST_F(TopicRouteTest, EagerRoutesSubscribeAtOnce) {
  TopicRoute::Params params;
  params.eager = true;
  make(std::move(params));
  EXPECT_TRUE(subscribed());
}

TEST_F(TopicRouteTest, ASubscriberDoesNotWaitForeverForAPublisher) {
  make();
  const auto listener = publication().request(subscriber(workstation_schema_));
  run_for(std::chrono::milliseconds(150));
  EXPECT_TRUE(listener->accepted) << "its own version will do";
  const auto link = subscription().connect(publisher(robot_schema_));
  subscription().message(link, frame_of({1, 0, 0, 0}));
  EXPECT_EQ(received(*listener).size(), 1U);
}

TEST_F(TopicRouteTest, ALateSubscriberGetsTheLastMessageOfEachLatchingPublisher) {
  make();
  const auto early = publication().request(subscriber(workstation_schema_));
  const auto a = subscription().connect(publisher(robot_schema_, "/a", true));
  const auto b = subscription().connect(publisher(robot_schema_, "/b", true));
  subscription().message(a, frame_of({1, 0, 0, 0}));
  subscription().message(b, frame_of({2, 0, 0, 0}));
  subscription().message(a, frame_of({3, 0, 0, 0}));
  const auto late = publication().request(subscriber(workstation_schema_));
  EXPECT_TRUE(late->latching);
  EXPECT_EQ(received(*late), (std::vector<Bytes>{{2, 0, 0, 0, 0, 0}, {3, 0, 0, 0, 0, 0}}));
  subscription().gone(b);
  const auto latest = publication().request(subscriber(workstation_schema_));
  EXPECT_EQ(received(*latest), (std::vector<Bytes>{{3, 0, 0, 0, 0, 0}}));
}

TEST_F(TopicRouteTest, StaticTransformsOfSeveralNodesComeAsOne) {
  TopicRoute::Params params;
  params.topic = "/tf_static";
  params.type = "tf2_msgs/TFMessage";
  const auto transforms =
      schema("T[] transforms\n================\nMSG: tf2_msgs/T\nuint8 id\n", "tf2_msgs/TFMessage");
  make(std::move(params));
  const auto early = publication().request(subscriber(transforms));
  const auto a = subscription().connect(publisher(transforms, "/a", true));
  const auto b = subscription().connect(publisher(transforms, "/b", true));
  subscription().message(a, frame_of({1, 0, 0, 0, 10}));
  subscription().message(b, frame_of({2, 0, 0, 0, 20, 21}));
  const auto late = publication().request(subscriber(transforms));
  EXPECT_EQ(received(*late), (std::vector<Bytes>{{3, 0, 0, 0, 10, 20, 21}}));
  EXPECT_EQ(received(*early).back(), (Bytes{3, 0, 0, 0, 10, 20, 21})) << "what its process keeps for others";
}

TEST_F(TopicRouteTest, ARateLimitDropsWhatComesTooSoonAndCountsIt) {
  TopicRoute::Params params;
  params.profile.max_rate_hz = 1.0;
  make(std::move(params));
  const auto listener = publication().request(subscriber(robot_schema_));
  const auto link = subscription().connect(publisher(robot_schema_));
  for (std::uint8_t i = 0; i < 10; ++i) subscription().message(link, frame_of({i, 0, 0, 0}));
  EXPECT_EQ(received(*listener).size(), 1U);
  EXPECT_EQ(route_->status().dropped, 9U);
}

TEST_F(TopicRouteTest, ADamagedMessageIsCountedAndReported) {
  make();
  const auto listener = publication().request(subscriber(workstation_schema_));
  const auto link = subscription().connect(publisher(robot_schema_));
  subscription().message(link, frame_of({1, 0}));
  EXPECT_TRUE(received(*listener).empty());
  EXPECT_EQ(route_->status().failed, 1U);
  ASSERT_EQ(problems_.size(), 1U);
  EXPECT_NE(problems_[0].find("/value"), std::string::npos);
}

TEST_F(TopicRouteTest, OtherRulesBeginEveryConnectionAnew) {
  auto& route = make();
  const auto listener = publication().request(subscriber(robot_schema_));
  subscription().connect(publisher(robot_schema_));
  ASSERT_TRUE(listener->accepted);
  route.restart();
  EXPECT_EQ(publication().announced_again, 1);
  EXPECT_TRUE(publication().sent.empty());
}

TEST_F(TopicRouteTest, LogsBelowTheLevelStay) {
  const auto log = schema(
      "Header header\nbyte level\n================\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\n"
      "string frame_id\n",
      "rosgraph_msgs/Log");
  TopicRoute::Params params;
  params.topic = "/rosout";
  params.type = "rosgraph_msgs/Log";
  make(std::move(params));
  const auto listener = publication().request(subscriber(log));
  const auto link = subscription().connect(publisher(log));
  for (const std::uint8_t level : {std::uint8_t{2}, std::uint8_t{4}, std::uint8_t{8}})
    subscription().message(link, frame_of({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 'x', level}));
  const auto all = received(*listener);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].back(), 4);
  EXPECT_EQ(all[1].back(), 8);
  subscription().message(link, frame_of({1, 2, 3}));
  EXPECT_EQ(received(*listener).size(), 2U) << "damaged";
}

TEST_F(TopicRouteTest, StampsAreShiftedOnRequest) {
  params_.clocks.shift_stamps = true;
  shift_ns_ = 2'000'000'000;
  const auto stamped = schema("time stamp\n");
  make();
  const auto listener = publication().request(subscriber(stamped));
  const auto link = subscription().connect(publisher(stamped));
  subscription().message(link, frame_of({10, 0, 0, 0, 5, 0, 0, 0}));
  subscription().message(link, frame_of({0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(received(*listener), (std::vector<Bytes>{{12, 0, 0, 0, 5, 0, 0, 0}, {0, 0, 0, 0, 0, 0, 0, 0}}));
}

TEST_F(TopicRouteTest, CommandsDoNotWaitInTheKernelEither) {
  TopicRoute::Params params;
  params.profile.max_age_s = 0.2;
  params.profile.queue = 1;
  params.profile.priority = Priority::kControl;
  make(std::move(params));
  EXPECT_EQ(publication().params_.max_age.count(), 200);
  EXPECT_EQ(publication().params_.queue, 1U);
  EXPECT_EQ(publication().params_.priority, Priority::kControl);
  ASSERT_TRUE(publication().params_.unacknowledged.has_value());
  EXPECT_EQ(publication().params_.unacknowledged->count(), 300)
      << "a lost packet, which is sent again after 0.2 s, must not end the connection";
}

TEST_F(TopicRouteTest, AConnectionThatEndsAgainAndAgainShowsWhileItDoes) {
  auto& route = make();
  (void)publication().request(subscriber(robot_schema_));
  subscription().connect(publisher(robot_schema_));
  EXPECT_EQ(route.status().problem, "");
  subscription().trouble = "publisher http://robot/: it ends again and again";
  EXPECT_EQ(route.status().problem, "/value: publisher http://robot/: it ends again and again");
}

TEST_F(TopicRouteTest, APublisherOfLogsThatEndedIsNoProblem) {
  TopicRoute::Params params;
  params.topic = "/rosout";
  params.eager = true;
  auto& route = make(std::move(params));
  subscription().complain("http://ended/", "Connection refused");
  EXPECT_EQ(route.status().problem, "");
  EXPECT_TRUE(problems_.empty());
}

}  // namespace
}  // namespace extperfc::translate::test
