#include <gtest/gtest.h>

#include "translate/bridge/bridge_selector.hpp"

namespace extperfc::translate {
namespace {

BridgeParams open_params() {
  BridgeParams params;
  params.sides[0].peer.name = params.sides[1].peer.name = "/bridge";
  params.topics.allow = params.services.allow = {".*"};
  return params;
}

BridgeSelector selector_of(const BridgeParams& params) {
  auto selector = BridgeSelector::make(params);
  if (!selector) throw std::runtime_error(selector.error().message);
  return std::move(*selector);
}

BridgeSelector::Graphs talker_on_robot(const std::string& topic = "/chatter",
                                       const std::string& node = "/talker") {
  BridgeSelector::Graphs graphs;
  graphs[0].topics[topic] = {"std_msgs/String", {node}, {}};
  return graphs;
}

TEST(BridgeSelector, ATopicIsBridgedFromItsPublisher) {
  auto selector = selector_of(open_params());
  const auto bridged = selector.topics(talker_on_robot());
  ASSERT_EQ(bridged.size(), 1U);
  const auto& [key, entry] = *bridged.begin();
  EXPECT_EQ(key, (std::pair<std::string, Side>{"/chatter", Side::kRobot}));
  EXPECT_EQ(entry.type, "std_msgs/String");
  EXPECT_FALSE(entry.listeners);
}

TEST(BridgeSelector, ListenersOfTheOtherSideAreSeen) {
  auto selector = selector_of(open_params());
  auto graphs = talker_on_robot();
  graphs[1].topics["/chatter"] = {"std_msgs/String", {"/bridge"}, {"/bridge"}};
  EXPECT_FALSE(selector.topics(graphs).begin()->second.listeners) << "our own";
  graphs[1].topics["/chatter"].subscribers.push_back("/listener");
  EXPECT_TRUE(selector.topics(graphs).begin()->second.listeners);
}

TEST(BridgeSelector, OwnPublicationsAreNotBridgedBack) {
  auto selector = selector_of(open_params());
  EXPECT_TRUE(selector.topics(talker_on_robot("/chatter", "/bridge")).empty());
}

TEST(BridgeSelector, ATopicWithPublishersOnBothSidesIsBridgedInBothDirections) {
  auto selector = selector_of(open_params());
  auto graphs = talker_on_robot("/tf");
  graphs[1].topics["/tf"] = {"tf2_msgs/TFMessage", {"/other", "/bridge"}, {}};
  EXPECT_EQ(selector.topics(graphs).size(), 2U);
}

TEST(BridgeSelector, FiltersAndDirectionsHold) {
  auto params = open_params();
  params.topics = {{"/robot/.*", "/cameras/.*"}, {"/robot/secret"}};
  params.profiles.push_back({"/robot/in/.*", Directions::kWorkstationToRobot});
  auto selector = selector_of(params);
  EXPECT_EQ(selector.topics(talker_on_robot("/robot/state")).size(), 1U);
  EXPECT_TRUE(selector.topics(talker_on_robot("/robot/secret")).empty());
  EXPECT_TRUE(selector.topics(talker_on_robot("/other")).empty());
  EXPECT_TRUE(selector.topics(talker_on_robot("/robot/in/x")).empty());
  EXPECT_TRUE(selector.topics(talker_on_robot("/prefix/robot/state")).empty())
      << "all of the name must match";
}

TEST(BridgeSelector, TheClockIsBridgedOnRequestInOneDirection) {
  auto params = open_params();
  auto graphs = talker_on_robot("/clock");
  graphs[1].topics["/clock"] = {"rosgraph_msgs/Clock", {"/simulator"}, {}};
  EXPECT_TRUE(selector_of(params).topics(graphs).empty());
  params.clock = true;
  const auto bridged = selector_of(params).topics(graphs);
  ASSERT_EQ(bridged.size(), 1U);
  EXPECT_EQ(bridged.begin()->first.second, Side::kRobot);
}

TEST(BridgeSelector, LogsAreBridgedFromRobotToWorkstation) {
  auto params = open_params();
  auto graphs = talker_on_robot("/rosout");
  graphs[1].topics["/rosout"] = {"rosgraph_msgs/Log", {"/node"}, {}};
  graphs[0].topics["/rosout_agg"] = {"rosgraph_msgs/Log", {"/rosout"}, {}};
  const auto bridged = selector_of(params).topics(graphs);
  ASSERT_EQ(bridged.size(), 1U);
  EXPECT_EQ(bridged.begin()->first, (std::pair<std::string, Side>{"/rosout", Side::kRobot}));
  params.rosout = false;
  EXPECT_TRUE(selector_of(params).topics(graphs).empty());
}

BridgeSelector::Graphs action_on_robot() {
  BridgeSelector::Graphs graphs;
  auto& topics = graphs[0].topics;
  topics["/arm/goal"] = {"control_msgs/FollowJointTrajectoryActionGoal", {}, {"/server"}};
  topics["/arm/cancel"] = {"actionlib_msgs/GoalID", {}, {"/server"}};
  topics["/arm/status"] = {"actionlib_msgs/GoalStatusArray", {"/server"}, {}};
  topics["/arm/feedback"] = {"control_msgs/FollowJointTrajectoryActionFeedback", {"/server"}, {}};
  topics["/arm/result"] = {"control_msgs/FollowJointTrajectoryActionResult", {"/server"}, {}};
  return graphs;
}

TEST(BridgeSelector, AnActionIsBridgedAsAUnitBeforeAnyClientExists) {
  auto selector = selector_of(open_params());
  const auto bridged = selector.topics(action_on_robot());
  ASSERT_EQ(bridged.size(), 5U);
  for (const auto& [key, entry] : bridged) {
    const bool to_server = key.first == "/arm/goal" || key.first == "/arm/cancel";
    EXPECT_EQ(key.second, to_server ? Side::kWorkstation : Side::kRobot) << key.first;
    EXPECT_EQ(entry.action, "/arm");
    EXPECT_TRUE(entry.eager);
    EXPECT_FALSE(entry.type.empty());
  }
}

TEST(BridgeSelector, ADeniedActionIsNotBridgedInPart) {
  auto params = open_params();
  params.topics.deny = {"/arm/.*"};
  EXPECT_TRUE(selector_of(params).topics(action_on_robot()).empty());
}

TEST(BridgeSelector, TwoServersOfOneNameAreKeptApart) {
  auto graphs = action_on_robot();
  graphs[1] = graphs[0];
  EXPECT_TRUE(selector_of(open_params()).topics(graphs).empty());
}

TEST(BridgeSelector, ServicesAreBridgedUnlessBothSidesHaveThem) {
  auto selector = selector_of(open_params());
  BridgeSelector::Graphs graphs;
  graphs[0].services = {{"/ik", {"/robot"}}, {"/both", {"/a"}}, {"/ours", {"/bridge"}}};
  graphs[1].services = {{"/both", {"/b"}}, {"/ik", {"/bridge"}}, {"/planner", {"/c"}}};
  EXPECT_EQ(selector.services(graphs),
            (BridgedServices{{"/ik", Side::kRobot}, {"/planner", Side::kWorkstation}}));
}

TEST(BridgeSelector, AWrongExpressionIsNamed) {
  auto params = open_params();
  params.services.deny = {"/a(b"};
  const auto selector = BridgeSelector::make(params);
  ASSERT_FALSE(selector);
  EXPECT_NE(selector.error().message.find("services/deny"), std::string::npos);
  EXPECT_NE(selector.error().message.find("/a(b"), std::string::npos);
}

}  // namespace
}  // namespace extperfc::translate
