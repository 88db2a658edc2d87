// The whole bridge between two masters, with nodes on both sides, in one process and on one event loop.
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>

#include <gtest/gtest.h>

#include "extperfc/translate/bridge.hpp"

#include "test/unit/translate/bridge/small_master.hpp"

namespace extperfc::translate::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

FramePtr frame_of(const Bytes& bytes) {
  auto frame = std::make_shared<Frame>();
  std::copy(bytes.begin(), bytes.end(), frame->resize_payload(bytes.size()));
  return frame;
}

/// A publisher with one definition; accepts every subscriber.
struct Talker {
  Talker(Peer& peer, const std::string& topic, SchemaPtr with, bool latches = false)
      : schema(std::move(with)) {
    Publication::Handlers handlers;
    handlers.on_request = [this, latches](const std::shared_ptr<SubscriberRequest>& request) {
      const auto md5 = value_of(request->header(), "md5sum");
      if (md5 != "*" && md5 != schema->md5()) return request->refuse("MD5 mismatch");
      const auto link = request->accept(schema->type(), schema->md5(), schema->full_text(), latches);
      if (latches && last && link != 0) publication->send(link, last, EventLoop::now());
    };
    publication = peer.advertise(topic, schema->type(), std::move(handlers), {});
  }
  void say(const Bytes& bytes) {
    last = frame_of(bytes);
    for (const auto link : publication->links()) publication->send(link, last, EventLoop::now());
  }
  SchemaPtr schema;
  FramePtr last;
  std::unique_ptr<Publication> publication;
};

/// A subscriber that wants one definition, as a compiled node does.
struct Listener {
  Listener(Peer& peer, const std::string& topic, const SchemaPtr& schema) {
    Subscription::Handlers handlers;
    handlers.on_up = [this](const PublisherLink& link) {
      header = link.header;
      return true;
    };
    handlers.on_message = [this](const PublisherLink&, const FramePtr& frame, SteadyTime) {
      const auto view = frame->payload();
      heard.emplace_back(view.data, view.data + view.size);
    };
    Subscription::Params params;
    params.type = schema->type();
    params.md5 = schema->md5();
    subscription = peer.subscribe(topic, std::move(handlers), params);
  }
  ConnectionHeader header;
  std::vector<Bytes> heard;
  std::unique_ptr<Subscription> subscription;
};

class BridgeTest : public testing::Test {
 protected:
  BridgeTest() {
    folder_ = testing::TempDir() + "/extperfc_bridge_test";
    write("robot", "msg/Value.msg", "int32 value\n");
    write("workstation", "msg/Value.msg", "int32 value\nint16 extra\n");
    write("robot", "srv/Set.srv", "int32 value\n---\nint32 twice\n");
    write("workstation", "srv/Set.srv", "int32 value\nint8 more\n---\nint32 twice\nbool ok\n");
    for (const auto* set : {"robot", "workstation"}) {
      if (const auto read = definitions_.add_tree(std::filesystem::path(folder_) / set, set); !read)
        throw std::runtime_error(read.error().message);
    }
    robot_value_ = definitions_.message_of_set("robot", "demo/Value");
    workstation_value_ = definitions_.message_of_set("workstation", "demo/Value");
    params_.sides[0].peer = node("/translator", robot_master_);
    params_.sides[1].peer = node("/translator", workstation_master_);
    params_.sides[0].definitions = {"robot"};
    params_.sides[1].definitions = {"workstation"};
    params_.topics.allow = params_.services.allow = {".*"};
    params_.poll_period_s = 0.05;
    params_.schema_patience_s = 1.0;
    robot_node_ = plain("/robot", robot_master_);
    workstation_node_ = plain("/desk", workstation_master_);
  }
  ~BridgeTest() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& set, const std::string& name, const std::string& text) {
    const auto file = std::filesystem::path(folder_) / set / "demo" / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  static PeerParams node(const std::string& name, const SmallMaster& master) {
    PeerParams params;
    params.name = name;
    params.master_uri = master.uri();
    params.advertised_host = params.bind_address = "127.0.0.1";
    params.master_period = std::chrono::milliseconds(50);
    params.tcpros.retry_first = std::chrono::milliseconds(20);
    params.tcpros.retry_last = std::chrono::milliseconds(200);
    return params;
  }
  std::unique_ptr<Peer> plain(const std::string& name, const SmallMaster& master) {
    auto params = node(name, master);
    params.marked = false;
    auto peer = Peer::make(loop_, frames_, params, {});
    if (!peer) throw std::runtime_error(peer.error().message);
    return std::move(*peer);
  }
  std::unique_ptr<Bridge> start(BridgeParams params) {
    DefinitionStore definitions;
    for (const auto* set : {"robot", "workstation"})
      (void)definitions.add_tree(std::filesystem::path(folder_) / set, set);
    auto bridge = Bridge::make(loop_, std::move(params), std::move(definitions), RuleSet{},
                               {[](const std::string&) {},
                                [this](const std::string& problem) { problems_.push_back(problem); },
                                {}});
    if (!bridge) throw std::runtime_error(bridge.error().message);
    return std::move(*bridge);
  }
  std::unique_ptr<Bridge> start() { return start(params_); }

  [[nodiscard]] bool until(const std::function<bool()>& condition,
                           std::chrono::seconds patience = std::chrono::seconds(15)) {
    const auto end = EventLoop::now() + patience;
    while (!condition()) {
      if (EventLoop::now() > end) return false;
      loop_.run_once(std::chrono::milliseconds(5));
    }
    return true;
  }
  void for_a_while(std::chrono::milliseconds time) {
    const auto end = EventLoop::now() + time;
    while (EventLoop::now() < end) loop_.run_once(std::chrono::milliseconds(5));
  }
  /// Says it again and again until it is heard, then clears what was heard.
  [[nodiscard]] bool connect(Talker& talker, Listener& listener, const Bytes& bytes = {0, 0, 0, 0}) {
    const bool heard = until([&] {
      talker.say(bytes);
      return !listener.heard.empty();
    });
    for_a_while(std::chrono::milliseconds(50));
    listener.heard.clear();
    return heard;
  }

  std::string folder_;
  DefinitionStore definitions_;
  SchemaPtr robot_value_, workstation_value_;
  EventLoop loop_;
  FramePool frames_;
  SmallMaster robot_master_{loop_}, workstation_master_{loop_};
  BridgeParams params_;
  std::vector<std::string> problems_;
  std::unique_ptr<Peer> robot_node_, workstation_node_;
};

TEST_F(BridgeTest, ATopicIsBridgedConvertedAndUnchanged) {
  const auto bridge = start();
  Talker talker(*robot_node_, "/value", robot_value_);
  Listener changed(*workstation_node_, "/value", workstation_value_);
  ASSERT_TRUE(connect(talker, changed));
  talker.say({5, 0, 0, 0});
  ASSERT_TRUE(until([&] { return changed.heard.size() == 1; }));
  EXPECT_EQ(changed.heard[0], (Bytes{5, 0, 0, 0, 0, 0}));
  const auto other = plain("/other", workstation_master_);
  Listener same(*other, "/value", robot_value_);
  ASSERT_TRUE(connect(talker, same)) << "two versions of one topic at once";
  talker.say({6, 0, 0, 0});
  ASSERT_TRUE(until([&] { return !same.heard.empty(); }));
  EXPECT_EQ(same.heard[0], (Bytes{6, 0, 0, 0}));
  const auto status = bridge->status();
  ASSERT_EQ(status.topics.size(), 1U);
  EXPECT_EQ(status.topics[0].to.size(), 2U);
  EXPECT_TRUE(status.sides[0].reachable && status.sides[1].reachable);
}

TEST_F(BridgeTest, TheOtherWayToo) {
  const auto bridge = start();
  Talker talker(*workstation_node_, "/value", workstation_value_);
  Listener listener(*robot_node_, "/value", robot_value_);
  ASSERT_TRUE(connect(talker, listener, {1, 0, 0, 0, 9, 9}));
  talker.say({5, 0, 0, 0, 1, 1});
  ASSERT_TRUE(until([&] { return !listener.heard.empty(); }));
  EXPECT_EQ(listener.heard[0], (Bytes{5, 0, 0, 0}));
}

TEST_F(BridgeTest, EachMessageArrivesOnceThoughBothSidesPublish) {
  const auto bridge = start();
  Talker robot_talker(*robot_node_, "/value", robot_value_);
  Talker workstation_talker(*workstation_node_, "/value", workstation_value_);
  const auto robot_other = plain("/robot_listener", robot_master_);
  const auto workstation_other = plain("/workstation_listener", workstation_master_);
  Listener at_robot(*robot_other, "/value", robot_value_);
  Listener at_workstation(*workstation_other, "/value", workstation_value_);
  const auto count = [](const Listener& listener, std::uint8_t what) {
    return std::count_if(listener.heard.begin(), listener.heard.end(),
                         [&](const auto& b) { return b[0] == what; });
  };
  ASSERT_TRUE(until([&] {
    robot_talker.say({1, 0, 0, 0});
    workstation_talker.say({2, 0, 0, 0, 0, 0});
    return count(at_robot, 2) > 0 && count(at_workstation, 1) > 0 && count(at_robot, 1) > 0 &&
           count(at_workstation, 2) > 0;
  }));
  for_a_while(std::chrono::milliseconds(100));
  at_robot.heard.clear();
  at_workstation.heard.clear();
  for (int i = 0; i < 10; ++i) {
    robot_talker.say({1, 0, 0, 0});
    workstation_talker.say({2, 0, 0, 0, 0, 0});
    for_a_while(std::chrono::milliseconds(10));
  }
  for_a_while(std::chrono::milliseconds(200));
  for (const auto* listener : {&at_robot, &at_workstation}) {
    EXPECT_EQ(count(*listener, 1), 10);
    EXPECT_EQ(count(*listener, 2), 10);
  }
}

TEST_F(BridgeTest, TwoTranslatorsDoNotFormALoop) {
  const auto bridge = start();
  auto params = params_;
  params.sides[0].peer.name = params.sides[1].peer.name = "/second";
  const auto second = start(params);
  Talker talker(*robot_node_, "/value", robot_value_);
  const auto robot_other = plain("/robot_listener", robot_master_);
  Listener at_robot(*robot_other, "/value", robot_value_);
  Listener at_workstation(*workstation_node_, "/value", workstation_value_);
  ASSERT_TRUE(until([&] {
    talker.say({1, 0, 0, 0});
    return !at_robot.heard.empty() && !at_workstation.heard.empty();
  }));
  for_a_while(std::chrono::milliseconds(500));
  at_robot.heard.clear();
  at_workstation.heard.clear();
  for (int i = 0; i < 5; ++i) talker.say({7, 0, 0, 0});
  for_a_while(std::chrono::milliseconds(500));
  EXPECT_EQ(at_robot.heard.size(), 5U);
  EXPECT_LE(at_workstation.heard.size(), 10U) << "once by each translator at most";
  EXPECT_GE(at_workstation.heard.size(), 5U);
}

TEST_F(BridgeTest, ALatchedMessageReachesWhoComesLate) {
  const auto bridge = start();
  Talker talker(*robot_node_, "/value", robot_value_, true);
  talker.say({5, 0, 0, 0});
  for_a_while(std::chrono::milliseconds(200));
  Listener first(*workstation_node_, "/value", workstation_value_);
  ASSERT_TRUE(until([&] { return first.heard.size() == 1; }));
  EXPECT_EQ(value_of(first.header, "latching"), "1");
  const auto other = plain("/late", workstation_master_);
  Listener late(*other, "/value", workstation_value_);
  ASSERT_TRUE(until([&] { return late.heard.size() == 1; }));
  EXPECT_EQ(late.heard[0], (Bytes{5, 0, 0, 0, 0, 0}));
  for_a_while(std::chrono::milliseconds(100));
  EXPECT_EQ(first.heard.size(), 1U);
}

TEST_F(BridgeTest, AServiceIsBridgedWithBothHalvesConverted) {
  const auto bridge = start();
  const auto robot_set = definitions_.service_of_set("robot", "demo/Set");
  const auto workstation_set = definitions_.service_of_set("workstation", "demo/Set");
  ServiceServer::Handlers handlers;
  handlers.on_request = [&](const std::shared_ptr<ServiceRequest>& request) {
    const auto md5 = value_of(request->header(), "md5sum");
    if (md5 != "*" && md5 != robot_set->md5) return request->refuse("MD5 mismatch");
    request->accept("demo/Set", robot_set->md5, "demo/SetRequest", "demo/SetResponse");
  };
  handlers.on_call = [](LinkId, const FramePtr& request, const ServiceServer::Reply& reply) {
    if (request->payload().data[0] == 0)
      return reply(false, {reinterpret_cast<const std::uint8_t*>("zero"), 4});
    const Bytes twice{static_cast<std::uint8_t>(2 * request->payload().data[0]), 0, 0, 0};
    reply(true, {twice.data(), twice.size()});
  };
  const auto server = robot_node_->serve("/set", std::move(handlers));
  ASSERT_TRUE(until([&] { return workstation_master_.offers("/translator", "/set"); }));
  std::optional<Result<std::shared_ptr<ServiceLink>>> link;
  workstation_node_->open_service("/set", workstation_set->md5, false,
                                  [&](auto opened) { link = std::move(opened); });
  ASSERT_TRUE(until([&] { return link.has_value(); }));
  ASSERT_TRUE(*link) << link->error().message;
  std::optional<Result<FramePtr>> answer;
  const auto call = [&](const Bytes& request) {
    answer.reset();
    (**link)->call(frame_of(request), std::chrono::seconds(5),
                   [&](auto response) { answer = std::move(response); });
    return until([&] { return answer.has_value(); });
  };
  ASSERT_TRUE(call({4, 0, 0, 0, 77}));
  ASSERT_TRUE(*answer) << answer->error().message;
  const auto view = (**answer)->payload();
  EXPECT_EQ(Bytes(view.data, view.data + view.size), (Bytes{8, 0, 0, 0, 0}));
  ASSERT_TRUE(call({0, 0, 0, 0, 0}));
  ASSERT_FALSE(*answer);
  EXPECT_NE(answer->error().message.find("zero"), std::string::npos);
  EXPECT_EQ(bridge->status().services.at(0).calls, 2U);
}

TEST_F(BridgeTest, ParametersAreBridgedByPrefix) {
  params_.params_robot_to_workstation = {"/shared"};
  const auto bridge = start();
  bool done = false;
  robot_node_->set_param("/shared/a", 7, [&](const auto&) { done = true; });
  robot_node_->set_param("/private/b", 8, [](const auto&) {});
  ASSERT_TRUE(until([&] { return done && workstation_master_.param("/shared/a") != nullptr; }));
  EXPECT_EQ(*workstation_master_.param("/shared/a"), XmlValue(7));
  EXPECT_EQ(workstation_master_.param("/private/b"), nullptr);
}

class MasterFaults : public BridgeTest, public testing::WithParamInterface<Side> {};

TEST_P(MasterFaults, AMasterThatRestartsEmptyIsServedAgain) {
  const auto bridge = start();
  auto talker = std::make_unique<Talker>(*robot_node_, "/value", robot_value_);
  auto listener = std::make_unique<Listener>(*workstation_node_, "/value", workstation_value_);
  ASSERT_TRUE(connect(*talker, *listener));
  auto& master = GetParam() == Side::kRobot ? robot_master_ : workstation_master_;
  master.stop();
  talker->say({5, 0, 0, 0});
  EXPECT_TRUE(until([&] { return listener->heard.size() == 1; })) << "connections outlive masters";
  ASSERT_TRUE(until([&] { return !bridge->status().sides[static_cast<std::size_t>(GetParam())].reachable; }));
  master.restart_empty();
  ASSERT_TRUE(until([&] { return bridge->status().sides[static_cast<std::size_t>(GetParam())].reachable; }));
  // The robot's programs are started again too.
  if (GetParam() == Side::kRobot) {
    talker.reset();
    robot_node_ = plain("/robot", robot_master_);
    talker = std::make_unique<Talker>(*robot_node_, "/value", robot_value_);
  } else {
    listener.reset();
    workstation_node_ = plain("/desk", workstation_master_);
    listener = std::make_unique<Listener>(*workstation_node_, "/value", workstation_value_);
  }
  listener->heard.clear();
  EXPECT_TRUE(connect(*talker, *listener));
}

INSTANTIATE_TEST_SUITE_P(Bridge, MasterFaults, testing::Values(Side::kRobot, Side::kWorkstation),
                         [](const auto& one) { return std::string(to_string(one.param)); });

TEST_F(BridgeTest, MastersMayComeLater) {
  workstation_master_.stop();
  const auto bridge = start();
  Talker talker(*robot_node_, "/value", robot_value_);
  for_a_while(std::chrono::milliseconds(200));
  workstation_master_.start();
  Listener listener(*workstation_node_, "/value", workstation_value_);
  EXPECT_TRUE(connect(talker, listener));
}

TEST_F(BridgeTest, APublisherThatComesBackIsHeardAgain) {
  const auto bridge = start();
  auto talker = std::make_unique<Talker>(*robot_node_, "/value", robot_value_);
  Listener listener(*workstation_node_, "/value", workstation_value_);
  ASSERT_TRUE(connect(*talker, listener));
  talker.reset();
  for_a_while(std::chrono::milliseconds(200));
  talker = std::make_unique<Talker>(*robot_node_, "/value", robot_value_);
  EXPECT_TRUE(connect(*talker, listener));
}

TEST_F(BridgeTest, ATopicWhosePublisherLeftIsTakenBack) {
  const auto bridge = start();
  auto talker = std::make_unique<Talker>(*robot_node_, "/value", robot_value_);
  ASSERT_TRUE(until([&] { return workstation_master_.publishes("/translator", "/value"); }));
  talker.reset();
  EXPECT_TRUE(until([&] { return !workstation_master_.publishes("/translator", "/value"); }));
}

TEST_F(BridgeTest, ShutDownLeavesNothingBehind) {
  const auto bridge = start();
  const Talker talker(*robot_node_, "/value", robot_value_);
  ASSERT_TRUE(until([&] { return workstation_master_.publishes("/translator", "/value"); }));
  bool done = false;
  bridge->shut_down(std::chrono::seconds(3), [&] { done = true; });
  ASSERT_TRUE(until([&] { return done; }));
  EXPECT_FALSE(workstation_master_.publishes("/translator", "/value"));
  (void)bridge->status();
}

TEST_F(BridgeTest, WrongParametersAreNamed) {
  const auto refused = [&](const BridgeParams& params) {
    DefinitionStore definitions;
    const auto bridge = Bridge::make(loop_, params, std::move(definitions), RuleSet{}, {});
    return bridge ? std::string() : bridge.error().message;
  };
  auto params = params_;
  EXPECT_NE(refused(params).find("there is no set of definitions 'robot'"), std::string::npos);
  params.sides[0].definitions.clear();
  params.sides[1].definitions.clear();
  EXPECT_EQ(refused(params), "");
  params.topics.allow = {"("};
  EXPECT_NE(refused(params).find("topics/allow"), std::string::npos);
  params = params_;
  params.sides[1].peer.master_uri = params.sides[0].peer.master_uri;
  EXPECT_NE(refused(params).find("both sides have the master"), std::string::npos);
}

}  // namespace
}  // namespace extperfc::translate::test
