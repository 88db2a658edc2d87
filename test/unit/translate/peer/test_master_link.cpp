#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "test/unit/translate/peer/fake_master.hpp"
#include "test/unit/translate/peer/loop_until.hpp"
#include "test/unit/translate/peer/raw_server.hpp"
#include "translate/peer/http_message.hpp"
#include "translate/peer/master_calls.hpp"
#include "translate/peer/master_link.hpp"

namespace extperfc::translate {
namespace {

using namespace std::chrono_literals;

class MasterLinkTest : public ::testing::Test {
 protected:
  std::unique_ptr<MasterLink> connect(const std::string& uri, std::chrono::milliseconds timeout = 5s) {
    MasterLink::Params params;
    params.master_uri = uri;
    params.caller_id = "/translator";
    params.caller_api = "http://127.0.0.1:1/";
    params.period = 20ms;
    params.timeout = timeout;
    MasterLink::Handlers handlers;
    handlers.on_master = [this](const Peer::MasterStatus& status) { seen_.push_back(status); };
    handlers.on_log = [this](const std::string& line) { lines_.push_back(line); };
    return std::make_unique<MasterLink>(loop_, client_, params, handlers);
  }
  bool until_reachable(const MasterLink& link, bool reachable = true) {
    return loop_until(loop_, [&] { return link.status().reachable == reachable; });
  }

  EventLoop loop_;
  Resolver resolver_{loop_, {}};
  RpcClient client_{loop_, resolver_};
  std::vector<Peer::MasterStatus> seen_;
  std::vector<std::string> lines_;
};

MasterLink::Done ignore() {
  return [](const Result<XmlValue>&) {};
}

TEST_F(MasterLinkTest, RegistersEverythingWithTheRightArguments) {
  FakeMaster master(loop_);
  master.publishers["/scan"] = {"http://a:1/", "http://b:2/"};
  const auto link = connect(master.uri());
  std::vector<XmlValue> results;
  const auto collect = [&](Result<XmlValue> value) {
    ASSERT_TRUE(value) << value.error().message;
    results.push_back(*value);
  };
  link->keep_subscriber("/scan", "sensor_msgs/LaserScan", collect);
  link->keep_publisher("/chatter", "std_msgs/String", collect);
  link->keep_service("/add", "rosrpc://127.0.0.1:9", collect);
  link->keep_param_watch("/robot", collect);
  ASSERT_TRUE(loop_until(loop_, [&] { return results.size() == 4; }));
  EXPECT_EQ(results[0], XmlValue(XmlArray{"http://a:1/", "http://b:2/"}));
  const XmlValue api = "http://127.0.0.1:1/";
  std::map<std::string, XmlArray> made;
  for (const auto& call : master.log) made[call.method] = call.arguments;
  EXPECT_EQ(XmlValue(made["registerSubscriber"]),
            XmlValue(XmlArray{"/translator", "/scan", "sensor_msgs/LaserScan", api}));
  EXPECT_EQ(XmlValue(made["registerPublisher"]),
            XmlValue(XmlArray{"/translator", "/chatter", "std_msgs/String", api}));
  EXPECT_EQ(XmlValue(made["registerService"]),
            XmlValue(XmlArray{"/translator", "/add", "rosrpc://127.0.0.1:9", api}));
  EXPECT_EQ(XmlValue(made["subscribeParam"]), XmlValue(XmlArray{"/translator", api, "/robot"}));
  ASSERT_FALSE(seen_.empty());
  EXPECT_TRUE(seen_[0].reachable);
  EXPECT_EQ(seen_[0].pid, 1000);
}

TEST_F(MasterLinkTest, WhatIsKeptBeforeTheMasterComesIsMadeWhenItDoes) {
  FakeMaster master(loop_);
  master.stop();
  const auto link = connect(master.uri());
  link->keep_publisher("/chatter", "std_msgs/String", ignore());
  ASSERT_TRUE(loop_until(loop_, [&] { return !seen_.empty(); }));
  EXPECT_FALSE(seen_[0].reachable);
  EXPECT_NE(seen_[0].problem.find("refused"), std::string::npos) << seen_[0].problem;
  EXPECT_NE(seen_[0].problem.find(master.uri()), std::string::npos) << seen_[0].problem;
  loop_for(loop_, 150ms);
  EXPECT_EQ(seen_.size(), 1U) << "said once";
  master.start();
  ASSERT_TRUE(loop_until(loop_, [&] { return master.has("registerPublisher", "/chatter"); }));
  EXPECT_EQ(link->status().restarts, 0U);
  EXPECT_EQ(seen_.size(), 2U);
}

TEST_F(MasterLinkTest, AfterARestartFiveHundredAreMadeAgain) {
  FakeMaster master(loop_);
  const auto link = connect(master.uri());
  constexpr int kTopics = 500;
  int made = 0;
  for (int i = 0; i < kTopics; ++i)
    link->keep_subscriber("/topic" + std::to_string(i), "*", [&](const Result<XmlValue>&) { ++made; });
  ASSERT_TRUE(loop_until(loop_, [&] { return made == kTopics; }));
  master.pid = 1001;
  master.forget();
  ASSERT_TRUE(loop_until(loop_, [&] { return made == 2 * kTopics; }));
  EXPECT_EQ(master.registered.size(), static_cast<std::size_t>(kTopics));
  EXPECT_EQ(link->status().restarts, 1U);
  EXPECT_EQ(link->status().pid, 1001);
  loop_for(loop_, 100ms);
  EXPECT_EQ(master.calls("registerSubscriber"), 2 * kTopics) << "and not more often";
}

TEST_F(MasterLinkTest, AfterAnOutageWithTheSamePidToo) {
  FakeMaster master(loop_);
  const auto link = connect(master.uri());
  link->keep_publisher("/chatter", "std_msgs/String", ignore());
  ASSERT_TRUE(loop_until(loop_, [&] { return master.has("registerPublisher", "/chatter"); }));
  master.stop();
  ASSERT_TRUE(until_reachable(*link, false));
  master.forget();
  master.start();
  ASSERT_TRUE(loop_until(loop_, [&] { return master.has("registerPublisher", "/chatter"); }));
  EXPECT_EQ(link->status().restarts, 0U);
}

TEST_F(MasterLinkTest, NoticesAMasterThatForgotUsThoughItsPidIsTheSame) {
  FakeMaster master(loop_);
  const auto link = connect(master.uri());
  link->keep_publisher("/chatter", "std_msgs/String", ignore());
  ASSERT_TRUE(loop_until(loop_, [&] { return master.has("registerPublisher", "/chatter"); }));
  master.forget();
  ASSERT_TRUE(loop_until(loop_, [&] { return master.has("registerPublisher", "/chatter"); }));
  EXPECT_EQ(link->status().restarts, 1U);
}

TEST_F(MasterLinkTest, DropUnregistersAndAgainDoesBoth) {
  FakeMaster master(loop_);
  const auto link = connect(master.uri());
  int made = 0;
  const auto first = link->keep_publisher("/a", "t/A", [&](const Result<XmlValue>&) { ++made; });
  const auto second =
      link->keep_service("/s", "rosrpc://127.0.0.1:9", [&](const Result<XmlValue>&) { ++made; });
  ASSERT_TRUE(loop_until(loop_, [&] { return made == 2; }));
  link->again(first);
  ASSERT_TRUE(loop_until(loop_, [&] { return made == 3; }));
  EXPECT_EQ(master.calls("unregisterPublisher"), 1);
  EXPECT_EQ(master.calls("registerPublisher"), 2);
  EXPECT_TRUE(master.has("registerPublisher", "/a"));
  link->drop(first);
  link->drop(second);
  link->drop(second);
  ASSERT_TRUE(loop_until(loop_, [&] { return master.registered.empty(); }));
  const auto& last = master.log.back();
  EXPECT_EQ(XmlValue(last.arguments), XmlValue(XmlArray{"/translator", "/s", "rosrpc://127.0.0.1:9"}));
  loop_for(loop_, 100ms);
  EXPECT_EQ(made, 3);
  EXPECT_EQ(master.calls("unregisterService"), 1);
}

TEST_F(MasterLinkTest, RenewRegistersOnceMoreAndNeverUnregisters) {
  FakeMaster master(loop_);
  const auto link = connect(master.uri());
  int made = 0;
  const auto id = link->keep_publisher("/a", "t/A", [&](const Result<XmlValue>&) { ++made; });
  link->renew(id);  // not registered yet: nothing to renew
  ASSERT_TRUE(loop_until(loop_, [&] { return made == 1; }));
  loop_for(loop_, 60ms);
  EXPECT_EQ(master.calls("registerPublisher"), 1);
  link->renew(id);
  link->renew(id);  // under way already
  ASSERT_TRUE(loop_until(loop_, [&] { return made == 2; }));
  loop_for(loop_, 60ms);
  EXPECT_EQ(master.calls("registerPublisher"), 2);
  EXPECT_EQ(master.calls("unregisterPublisher"), 0);
  link->renew(id + 1);  // an unknown id
  link->drop(id);
  link->renew(id);
  ASSERT_TRUE(loop_until(loop_, [&] { return master.registered.empty(); }));
  loop_for(loop_, 60ms);
  EXPECT_EQ(master.calls("registerPublisher"), 2);
}

TEST_F(MasterLinkTest, WhatIsRenewedDuringAnOutageIsMadeOnceAfterIt) {
  FakeMaster master(loop_);
  const auto link = connect(master.uri());
  const auto id = link->keep_publisher("/a", "t/A", ignore());
  ASSERT_TRUE(loop_until(loop_, [&] { return master.has("registerPublisher", "/a"); }));
  master.stop();
  ASSERT_TRUE(until_reachable(*link, false));
  for (int i = 0; i < 5; ++i) link->renew(id);
  master.log.clear();
  master.start();
  ASSERT_TRUE(loop_until(loop_, [&] { return master.calls("registerPublisher") == 1; }));
  loop_for(loop_, 100ms);
  EXPECT_EQ(master.calls("registerPublisher"), 1);
}

TEST_F(MasterLinkTest, DropAndKeepOfOneTopicEndsRegistered) {
  FakeMaster master(loop_);
  const auto link = connect(master.uri());
  auto id = link->keep_publisher("/a", "t/A", ignore());
  ASSERT_TRUE(loop_until(loop_, [&] { return master.has("registerPublisher", "/a"); }));
  for (int i = 0; i < 20; ++i) {
    link->drop(id);
    if (i % 2 == 1) loop_.run_once(1ms);
    bool made = false;
    id = link->keep_publisher("/a", "t/A", [&](const Result<XmlValue>&) { made = true; });
    if (i % 3 != 0) {
      ASSERT_TRUE(loop_until(loop_, [&] { return made; }));
    }
    made = false;
    loop_for(loop_, 60ms);
    EXPECT_TRUE(master.has("registerPublisher", "/a")) << "round " << i;
  }
}

TEST_F(MasterLinkTest, TwoKeepOneTopicUntilTheLastIsDropped) {
  FakeMaster master(loop_);
  const auto link = connect(master.uri());
  int made = 0;
  const auto count = [&](const Result<XmlValue>&) { ++made; };
  const auto first = link->keep_subscriber("/a", "*", count);
  const auto second = link->keep_subscriber("/a", "*", count);
  ASSERT_TRUE(loop_until(loop_, [&] { return made == 2; }));
  link->drop(first);
  loop_for(loop_, 60ms);
  EXPECT_TRUE(master.has("registerSubscriber", "/a"));
  link->drop(second);
  EXPECT_TRUE(loop_until(loop_, [&] { return !master.has("registerSubscriber", "/a"); }));
}

TEST_F(MasterLinkTest, WhatWasDroppedDuringAnOutageIsUnregisteredAfterIt) {
  FakeMaster master(loop_);
  const auto link = connect(master.uri());
  const auto id = link->keep_publisher("/a", "t/A", ignore());
  ASSERT_TRUE(loop_until(loop_, [&] { return master.has("registerPublisher", "/a"); }));
  master.stop();
  ASSERT_TRUE(until_reachable(*link, false));
  link->drop(id);
  master.start();  // it still knows us
  EXPECT_TRUE(loop_until(loop_, [&] { return !master.has("registerPublisher", "/a"); }));
}

TEST_F(MasterLinkTest, RefusalsAreReportedAndNotRepeatedInAStorm) {
  FakeMaster master(loop_);
  master.refused.insert("/bad");
  master.faulty.insert("registerService");
  const auto link = connect(master.uri());
  std::vector<std::string> errors;
  link->keep_publisher("/bad", "t/A", [&](const Result<XmlValue>& value) {
    errors.push_back(value ? "" : value.error().message);
  });
  link->keep_service("/s", "rosrpc://127.0.0.1:9", ignore());
  ASSERT_TRUE(loop_until(loop_, [&] { return !errors.empty(); }));
  EXPECT_NE(errors[0].find("not that one"), std::string::npos);
  loop_for(loop_, 150ms);
  EXPECT_LE(master.calls("registerPublisher"), 2);
  EXPECT_LE(master.calls("registerService"), 9) << "once in a period";
  EXPECT_TRUE(link->status().reachable) << "a refusal is not an outage";
  master.refused.clear();
  master.faulty.clear();
  EXPECT_TRUE(loop_until(loop_, [&] { return master.registered.size() == 2; }));
}

TEST_F(MasterLinkTest, AMasterThatAcceptsAndNeverAnswersIsNotReachable) {
  const RawServer mute(loop_, [](RawServer::Connection&) {});
  const auto link = connect(mute.uri(), 50ms);
  const auto id = link->keep_publisher("/a", "t/A", ignore());
  ASSERT_TRUE(loop_until(loop_, [&] { return !seen_.empty(); }));
  EXPECT_NE(link->status().problem.find("50 ms"), std::string::npos) << link->status().problem;
  link->drop(id);
  bool ended = false;
  link->shut_down(10s, [&] { ended = true; });
  EXPECT_TRUE(loop_until(
      loop_, [&] { return ended; }, 2s))
      << "nothing to wait for";
}

TEST_F(MasterLinkTest, GarbageIsAClearProblem) {
  for (const auto& [body, part] : std::vector<std::pair<std::string, std::string>>{
           {"<html>", "XML-RPC"},
           {encode_response(1), "ROS master"},
           {encode_response(XmlArray{1, "text"}), "ROS master"},
           {encode_response(XmlArray{1, "", "pid"}), "not a number"},
           {encode_response(XmlArray{0, "tired", 0}), "tired"},
           {encode_fault(1, "no such method"), "no such method"}}) {
    const RawServer server(loop_, [text = body](RawServer::Connection& connection) {
      connection.send(http_response(200, true, text));
    });
    seen_.clear();
    const auto link = connect(server.uri());
    ASSERT_TRUE(loop_until(loop_, [&] { return !seen_.empty(); }));
    EXPECT_FALSE(seen_[0].reachable);
    EXPECT_NE(seen_[0].problem.find(part), std::string::npos) << seen_[0].problem;
  }
}

TEST_F(MasterLinkTest, CallsGiveTheValueOrTheMastersText) {
  FakeMaster master(loop_);
  master.refused.insert("/missing");
  const auto link = connect(master.uri());
  std::vector<Result<XmlValue>> results;
  const auto collect = [&](Result<XmlValue> value) { results.push_back(std::move(value)); };
  link->call("getPid", {}, collect);
  link->call("getParam", {"/missing"}, collect);
  ASSERT_TRUE(loop_until(loop_, [&] { return results.size() == 2; }));
  EXPECT_EQ(*results[0], XmlValue(1000));
  ASSERT_FALSE(results[1]);
  EXPECT_EQ(results[1].error().code, ErrorCode::kNotFound);
  EXPECT_NE(results[1].error().message.find("not that one"), std::string::npos);
}

TEST_F(MasterLinkTest, MergesTheGraph) {
  FakeMaster master(loop_);
  master.system_state = XmlArray{XmlArray{XmlArray{"/a", XmlArray{"/p", "/q"}}},
                                 XmlArray{XmlArray{"/a", XmlArray{"/r"}}, XmlArray{"/b", XmlArray{"/s"}}},
                                 XmlArray{XmlArray{"/srv", XmlArray{"/p"}}}};
  master.topic_types = XmlArray{XmlArray{"/a", "std_msgs/String"}, XmlArray{"/old", "std_msgs/Int8"}};
  const auto link = connect(master.uri());
  std::vector<Result<GraphState>> results;
  link->graph([&](Result<GraphState> graph) { results.push_back(std::move(graph)); });
  ASSERT_TRUE(loop_until(loop_, [&] { return !results.empty(); }));
  ASSERT_TRUE(results[0]) << results[0].error().message;
  const auto& topics = results[0]->topics;
  ASSERT_EQ(topics.size(), 2U);
  EXPECT_EQ(topics.at("/a").type, "std_msgs/String");
  EXPECT_EQ(topics.at("/a").publishers, (std::vector<std::string>{"/p", "/q"}));
  EXPECT_EQ(topics.at("/a").subscribers, (std::vector<std::string>{"/r"}));
  EXPECT_EQ(topics.at("/b").type, "");
  EXPECT_EQ(results[0]->services.at("/srv"), (std::vector<std::string>{"/p"}));
}

TEST_F(MasterLinkTest, AnswersOfAnotherShapeAreNoGraph) {
  const XmlArray none;
  for (const XmlValue& state :
       {XmlValue(1), XmlValue(none), XmlValue(XmlArray{none, none}), XmlValue(XmlArray{1, none, none}),
        XmlValue(XmlArray{XmlArray{"/a"}, none, none}),
        XmlValue(XmlArray{XmlArray{XmlArray{"/a"}}, none, none}),
        XmlValue(XmlArray{XmlArray{XmlArray{"/a", "/b"}}, none, none}),
        XmlValue(XmlArray{XmlArray{XmlArray{"/a", XmlArray{1}}}, none, none})}) {
    const auto graph = read_graph(state, none);
    ASSERT_FALSE(graph);
    EXPECT_EQ(graph.error().code, ErrorCode::kCorrupt);
  }
  const XmlArray good{none, none, none};
  EXPECT_TRUE(read_graph(good, none));
  EXPECT_FALSE(read_graph(good, 1));
  EXPECT_FALSE(read_graph(good, XmlArray{XmlArray{"/a"}}));
}

TEST_F(MasterLinkTest, ShutDownUnregistersEverything) {
  FakeMaster master(loop_);
  const auto link = connect(master.uri());
  int made = 0;
  for (int i = 0; i < 100; ++i)
    link->keep_publisher("/t" + std::to_string(i), "t/A", [&](const Result<XmlValue>&) { ++made; });
  ASSERT_TRUE(loop_until(loop_, [&] { return made >= 50; }));  // some are under way
  int ended = 0;
  link->shut_down(10s, [&] { ++ended; });
  ASSERT_TRUE(loop_until(
      loop_, [&] { return ended != 0; }, 5s));
  EXPECT_TRUE(master.registered.empty());
  loop_for(loop_, 50ms);
  EXPECT_EQ(ended, 1);
}

TEST_F(MasterLinkTest, ShutDownEndsAfterItsPatience) {
  bool mute = false;
  const RawServer server(loop_, [&](RawServer::Connection& connection) {
    if (!mute) connection.send(http_response(200, true, encode_response(XmlArray{1, "", 1})));
  });
  const auto link = connect(server.uri());
  bool made = false;
  link->keep_publisher("/a", "t/A", [&](const Result<XmlValue>&) { made = true; });
  ASSERT_TRUE(loop_until(loop_, [&] { return made; }));
  mute = true;
  bool ended = false;
  link->shut_down(50ms, [&] { ended = true; });
  EXPECT_TRUE(loop_until(
      loop_, [&] { return ended; }, 2s));
}

TEST_F(MasterLinkTest, CallbacksMayEndTheLink) {
  for (int which = 0; which < 4; ++which) {
    FakeMaster master(loop_);
    std::unique_ptr<MasterLink> link;
    bool ran = false;
    const auto end = [&] {
      ran = true;
      link.reset();
    };
    MasterLink::Params params;
    params.master_uri = master.uri();
    params.period = 10ms;
    MasterLink::Handlers handlers;
    if (which == 0) handlers.on_master = [&](const Peer::MasterStatus&) { end(); };
    if (which == 1) handlers.on_log = [&](const std::string&) { end(); };
    link = std::make_unique<MasterLink>(loop_, client_, params, handlers);
    for (int i = 0; i < 20; ++i)
      link->keep_publisher("/t" + std::to_string(i), "t", [&, which](const Result<XmlValue>&) {
        if (which == 2 && link) end();
      });
    if (which == 3) link->graph([&](const Result<GraphState>&) { end(); });
    EXPECT_TRUE(loop_until(loop_, [&] { return ran; })) << which;
    loop_for(loop_, 30ms);
  }
}

}  // namespace
}  // namespace extperfc::translate
