#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "test/unit/translate/peer/topic_helpers.hpp"

namespace extperfc::translate {
namespace {

using std::chrono::milliseconds;
using testing::frame_of;
using testing::Topics;

class PeerTest : public Topics {
 protected:
  void SetUp() override {
    translator = make("/translator");
    robot = make_plain("/robot");
  }
  XmlArray ask(const std::string& method, XmlArray arguments) {
    Resolver resolver(loop, {});
    RpcClient client(loop, resolver);
    XmlArray reply;
    bool answered = false;
    client.call(translator->uri(), method, std::move(arguments), testing::kDeadline,
                [&](const Result<XmlValue>& answer) {
                  answered = true;
                  if (answer && answer->as<XmlArray>() != nullptr) reply = *answer->as<XmlArray>();
                });
    EXPECT_TRUE(until([&] { return answered; }));
    return reply.size() == 3 ? reply : XmlArray{-99, "", 0};
  }
  std::unique_ptr<Peer> translator, robot;
};

TEST_F(PeerTest, TheSlaveApiAnswersAsNodesDo) {
  const auto publication = publish(*translator, "/chat");
  const auto subscription = subscribe(*robot, "/chat");
  ASSERT_TRUE(until([&] { return ups.size() == 1; }));
  send_all(*publication, frame_of("hello"));
  EXPECT_EQ(ask("getPid", {"/x"})[2], XmlValue(static_cast<std::int32_t>(::getpid())));
  EXPECT_EQ(ask("getMasterUri", {"/x"})[2], XmlValue(master.uri()));
  EXPECT_EQ(ask("getName", {"/x"})[2], XmlValue("/translator"));
  EXPECT_EQ(ask("getPublications", {"/x"})[2], XmlValue(XmlArray{XmlArray{"/chat", "std_msgs/String"}}));
  EXPECT_EQ(ask("getSubscriptions", {"/x"})[2], XmlValue(XmlArray{}));
  const auto info = ask("getBusInfo", {"/x"})[2];
  const auto& row = *info.as<XmlArray>()->at(0).as<XmlArray>();
  EXPECT_EQ(row.at(1), XmlValue("/robot"));
  EXPECT_EQ(row.at(2), XmlValue("o"));
  EXPECT_EQ(row.at(3), XmlValue("TCPROS"));
  EXPECT_EQ(row.at(4), XmlValue("/chat"));
  EXPECT_EQ(row.at(5), XmlValue(true));
  EXPECT_EQ(*ask("getBusStats", {"/x"})[0].as<std::int32_t>(), 1);
}

TEST_F(PeerTest, TheSlaveApiRefusesWhatItCannot) {
  const auto publication = publish(*translator, "/chat");
  EXPECT_EQ(ask("requestTopic", {"/x", "/nothing", XmlArray{XmlArray{"TCPROS"}}})[0], XmlValue(0));
  EXPECT_EQ(ask("requestTopic", {"/x", "/chat", XmlArray{XmlArray{"UDPROS"}}})[0], XmlValue(0));
  EXPECT_EQ(ask("requestTopic", {"/x", "/chat", 3})[0], XmlValue(0));
  EXPECT_EQ(ask("requestTopic", {"/x"})[0], XmlValue(-1));
  EXPECT_EQ(ask("publisherUpdate", {"/x", 3})[0], XmlValue(-1));
  EXPECT_EQ(ask("paramUpdate", {})[0], XmlValue(-1));
  EXPECT_EQ(ask("noSuchThing", {"/x"})[0], XmlValue(-1));
  EXPECT_EQ(ask("shutdown", {"/x", "because"})[0], XmlValue(1));
  EXPECT_EQ(ask("getPid", {"/x"})[0], XmlValue(1));
  EXPECT_NE(log.back().find("because"), std::string::npos) << log.back();
  EXPECT_EQ(ask("publisherUpdate", {"/x", "/unknown", XmlArray{3, "x"}})[0], XmlValue(1));
}

TEST_F(PeerTest, EveryRequestToShutDownIsHandled) {
  int ended = 0;
  Peer::Handlers handlers;
  handlers.on_shutdown = [&] { ++ended; };
  translator = std::move(*Peer::make(loop, frames, params("/mortal"), handlers));
  EXPECT_EQ(ask("shutdown", {"/rosnode", "user request"})[0], XmlValue(1)) << "answered before the end";
  EXPECT_TRUE(until([&] { return ended == 1; }));
}

TEST_F(PeerTest, ParametersAreSetReadWatchedAndDeleted) {
  std::vector<std::pair<std::string, XmlValue>> changes;
  master.params["/robot_name"] = "baxter";
  translator->watch_param("/robot_name", [&](const std::string& name, const XmlValue& value) {
    changes.emplace_back(name, value);
  });
  ASSERT_TRUE(until([&] { return changes.size() == 1; }));
  EXPECT_EQ(changes[0].second, XmlValue("baxter"));
  int done = 0;
  robot->set_param("/robot_name/first", XmlValue(3), [&](const Result<void>& set) { done += set ? 1 : 100; });
  robot->set_param("/robot_names", XmlValue(4), [&](const Result<void>& set) { done += set ? 1 : 100; });
  ASSERT_TRUE(until([&] { return changes.size() == 2 && done == 2; }));
  EXPECT_EQ(changes[1].first, "/robot_name/first");
  EXPECT_EQ(changes[1].second, XmlValue(3));
  std::vector<ErrorCode> errors;
  robot->get_param("/robot_name/first",
                   [&](const Result<XmlValue>& value) { done += *value == XmlValue(3) ? 1 : 100; });
  robot->get_param("/missing", [&](const Result<XmlValue>& value) { errors.push_back(value.error().code); });
  robot->delete_param("/missing", [&](const Result<void>& value) { errors.push_back(value.error().code); });
  robot->delete_param("/robot_names", [&](const Result<void>& value) { done += value ? 1 : 100; });
  ASSERT_TRUE(until([&] { return errors.size() == 2 && done == 4; }));
  EXPECT_EQ(errors, (std::vector<ErrorCode>{ErrorCode::kNotFound, ErrorCode::kNotFound}));
  EXPECT_EQ(changes.size(), 2U);
}

TEST_F(PeerTest, WhatIsRegisteredIsRegisteredAtTheNextMasterToo) {
  const auto publication = publish(*translator, "/chat");
  const auto subscription = subscribe(*translator, "/other");
  const auto server = translator->serve("/set", {});
  const auto registered = [&] {
    return master.publisher_count("/chat") == 1 && master.subscriber_count("/other") == 1 &&
           !master.service("/set").empty();
  };
  ASSERT_TRUE(until(registered));
  master.stop();
  for_a_while(milliseconds(50));
  master.start();
  EXPECT_TRUE(until(registered));
}

TEST_F(PeerTest, ShuttingDownUnregisters) {
  const auto publication = publish(*translator, "/chat");
  const auto server = translator->serve("/set", {});
  ASSERT_TRUE(until([&] { return master.publisher_count("/chat") == 1 && !master.service("/set").empty(); }));
  bool done = false;
  translator->shut_down(std::chrono::seconds(5), [&] { done = true; });
  ASSERT_TRUE(until([&] { return done; }));
  EXPECT_EQ(master.publisher_count("/chat"), 0U);
  EXPECT_EQ(master.service("/set"), "");
}

TEST_F(PeerTest, AReplacedPublicationStaysRegistered) {
  auto publication = publish(*translator, "/chat");
  ASSERT_TRUE(until([&] { return master.publisher_count("/chat") == 1; }));
  publication = publish(*translator, "/chat");
  const auto subscription = subscribe(*robot, "/chat");
  ASSERT_TRUE(until([&] { return publication->links().size() == 1; }));
  for_a_while(milliseconds(100));
  EXPECT_EQ(master.publisher_count("/chat"), 1U);
  EXPECT_EQ(publication->links().size(), 1U);
}

TEST_F(PeerTest, ThePartsMayOutliveTheNode) {
  const auto publication = publish(*translator, "/chat");
  const auto subscription = subscribe(*robot, "/chat");
  ASSERT_TRUE(until([&] { return ups.size() == 1; }));
  translator.reset();
  robot.reset();
  send_all(*publication, frame_of("late"));
  for_a_while(milliseconds(50));
}

TEST_F(PeerTest, AnEmptyHostBecomesTheAddressTowardsTheMaster) {
  auto with = params("/found");
  with.advertised_host.clear();
  EXPECT_EQ(make(with)->uri().rfind("http://127.0.0.1:", 0), 0U);
  with.master_uri = "http://robot.nowhere:11311";
  with.hosts["robot.nowhere"] = "127.0.0.1";
  EXPECT_EQ(make(with)->uri().rfind("http://127.0.0.1:", 0), 0U);
}

TEST_F(PeerTest, ParametersThatCannotWorkAreRefused) {
  const auto refused = [&](const PeerParams& with) { return !Peer::make(loop, frames, with, {}); };
  auto with = params("/x");
  with.master_uri = "nonsense";
  EXPECT_TRUE(refused(with));
  with = params("no_slash");
  EXPECT_TRUE(refused(with));
  with = params("/x");
  with.bind_address = "192.0.2.1";
  EXPECT_TRUE(refused(with));
}

TEST_F(PeerTest, TheLogIsBoundedInRate) {
  const auto before = log.size();
  for (int i = 0; i < 200; ++i) (void)ask("shutdown", {"/x"});
  EXPECT_LE(log.size() - before, 30U);  // of both nodes
}

}  // namespace
}  // namespace extperfc::translate
