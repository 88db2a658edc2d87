#include <gtest/gtest.h>

#include "translate/bridge/crossings.hpp"

namespace extperfc::translate {
namespace {

BridgeParams open_params() {
  BridgeParams params;
  params.ends[0].peer.name = params.ends[1].peer.name = "/bridge";
  params.topics.allow = params.services.allow = {".*"};
  return params;
}

CrossingRules rules_of(const BridgeParams& params) {
  auto rules = CrossingRules::make(params);
  if (!rules) throw std::runtime_error(rules.error().message);
  return std::move(*rules);
}

CrossingRules::Graphs talker_on_old(const std::string& topic = "/chatter",
                                    const std::string& node = "/talker") {
  CrossingRules::Graphs graphs;
  graphs[0].topics[topic] = {"std_msgs/String", {node}, {}};
  return graphs;
}

TEST(Crossings, ATopicCrossesFromItsPublisher) {
  auto rules = rules_of(open_params());
  const auto crossings = rules.topics(talker_on_old());
  ASSERT_EQ(crossings.size(), 1U);
  const auto& [key, crossing] = *crossings.begin();
  EXPECT_EQ(key, (std::pair<std::string, End>{"/chatter", End::kOld}));
  EXPECT_EQ(crossing.type, "std_msgs/String");
  EXPECT_FALSE(crossing.listeners);
}

TEST(Crossings, ListenersOfTheOtherSideAreSeen) {
  auto rules = rules_of(open_params());
  auto graphs = talker_on_old();
  graphs[1].topics["/chatter"] = {"std_msgs/String", {"/bridge"}, {"/bridge"}};
  EXPECT_FALSE(rules.topics(graphs).begin()->second.listeners) << "our own";
  graphs[1].topics["/chatter"].subscribers.push_back("/listener");
  EXPECT_TRUE(rules.topics(graphs).begin()->second.listeners);
}

TEST(Crossings, WhatWePublishOurselvesDoesNotCrossBack) {
  auto rules = rules_of(open_params());
  EXPECT_TRUE(rules.topics(talker_on_old("/chatter", "/bridge")).empty());
}

TEST(Crossings, ATopicWithPublishersOnBothSidesCrossesBothWays) {
  auto rules = rules_of(open_params());
  auto graphs = talker_on_old("/tf");
  graphs[1].topics["/tf"] = {"tf2_msgs/TFMessage", {"/other", "/bridge"}, {}};
  EXPECT_EQ(rules.topics(graphs).size(), 2U);
}

TEST(Crossings, FiltersAndDirectionsHold) {
  auto params = open_params();
  params.topics = {{"/robot/.*", "/cameras/.*"}, {"/robot/secret"}};
  params.profiles.push_back({"/robot/in/.*", Directions::kNewToOld});
  auto rules = rules_of(params);
  EXPECT_EQ(rules.topics(talker_on_old("/robot/state")).size(), 1U);
  EXPECT_TRUE(rules.topics(talker_on_old("/robot/secret")).empty());
  EXPECT_TRUE(rules.topics(talker_on_old("/other")).empty());
  EXPECT_TRUE(rules.topics(talker_on_old("/robot/in/x")).empty());
  EXPECT_TRUE(rules.topics(talker_on_old("/prefix/robot/state")).empty()) << "all of the name must match";
}

TEST(Crossings, TheClockCrossesOnlyWhenAskedAndOneWay) {
  auto params = open_params();
  auto graphs = talker_on_old("/clock");
  graphs[1].topics["/clock"] = {"rosgraph_msgs/Clock", {"/simulator"}, {}};
  EXPECT_TRUE(rules_of(params).topics(graphs).empty());
  params.clock = true;
  const auto crossings = rules_of(params).topics(graphs);
  ASSERT_EQ(crossings.size(), 1U);
  EXPECT_EQ(crossings.begin()->first.second, End::kOld);
}

TEST(Crossings, LogsCrossFromOldToNew) {
  auto params = open_params();
  auto graphs = talker_on_old("/rosout");
  graphs[1].topics["/rosout"] = {"rosgraph_msgs/Log", {"/node"}, {}};
  graphs[0].topics["/rosout_agg"] = {"rosgraph_msgs/Log", {"/rosout"}, {}};
  const auto crossings = rules_of(params).topics(graphs);
  ASSERT_EQ(crossings.size(), 1U);
  EXPECT_EQ(crossings.begin()->first, (std::pair<std::string, End>{"/rosout", End::kOld}));
  params.rosout = false;
  EXPECT_TRUE(rules_of(params).topics(graphs).empty());
}

CrossingRules::Graphs action_on_old() {
  CrossingRules::Graphs graphs;
  auto& topics = graphs[0].topics;
  topics["/arm/goal"] = {"control_msgs/FollowJointTrajectoryActionGoal", {}, {"/server"}};
  topics["/arm/cancel"] = {"actionlib_msgs/GoalID", {}, {"/server"}};
  topics["/arm/status"] = {"actionlib_msgs/GoalStatusArray", {"/server"}, {}};
  topics["/arm/feedback"] = {"control_msgs/FollowJointTrajectoryActionFeedback", {"/server"}, {}};
  topics["/arm/result"] = {"control_msgs/FollowJointTrajectoryActionResult", {"/server"}, {}};
  return graphs;
}

TEST(Crossings, AnActionCrossesAsOneBeforeAnyClientIsThere) {
  auto rules = rules_of(open_params());
  const auto crossings = rules.topics(action_on_old());
  ASSERT_EQ(crossings.size(), 5U);
  for (const auto& [key, crossing] : crossings) {
    const bool to_server = key.first == "/arm/goal" || key.first == "/arm/cancel";
    EXPECT_EQ(key.second, to_server ? End::kNew : End::kOld) << key.first;
    EXPECT_EQ(crossing.action, "/arm");
    EXPECT_TRUE(crossing.eager);
    EXPECT_FALSE(crossing.type.empty());
  }
}

TEST(Crossings, AnActionThatMayNotCrossStaysWhole) {
  auto params = open_params();
  params.topics.deny = {"/arm/.*"};
  EXPECT_TRUE(rules_of(params).topics(action_on_old()).empty());
}

TEST(Crossings, TwoServersOfOneNameAreKeptApart) {
  auto graphs = action_on_old();
  graphs[1] = graphs[0];
  EXPECT_TRUE(rules_of(open_params()).topics(graphs).empty());
}

TEST(Crossings, ServicesCrossUnlessBothSidesHaveThem) {
  auto rules = rules_of(open_params());
  CrossingRules::Graphs graphs;
  graphs[0].services = {{"/ik", {"/robot"}}, {"/both", {"/a"}}, {"/ours", {"/bridge"}}};
  graphs[1].services = {{"/both", {"/b"}}, {"/ik", {"/bridge"}}, {"/planner", {"/c"}}};
  EXPECT_EQ(rules.services(graphs), (ServiceCrossings{{"/ik", End::kOld}, {"/planner", End::kNew}}));
}

TEST(Crossings, AWrongExpressionIsNamed) {
  auto params = open_params();
  params.services.deny = {"/a(b"};
  const auto rules = CrossingRules::make(params);
  ASSERT_FALSE(rules);
  EXPECT_NE(rules.error().message.find("services/deny"), std::string::npos);
  EXPECT_NE(rules.error().message.find("/a(b"), std::string::npos);
}

}  // namespace
}  // namespace extperfc::translate
