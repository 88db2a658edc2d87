#include "translate/bridge/bridge_selector.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "extperfc/base/text.hpp"

namespace extperfc::translate {

namespace {

const GraphState& graph_of(const BridgeSelector::Graphs& graphs, Side side) {
  return graphs[static_cast<std::size_t>(side)];
}

/// Both sides have a server of that name: goals and states of the two must not mix.
void keep_apart(const std::string& action, BridgedTopics& bridged) {
  for (const auto* part : {"/goal", "/cancel", "/status", "/feedback", "/result"})
    for (const auto side : {Side::kRobot, Side::kWorkstation}) bridged.erase({action + part, side});
}

std::string type_of(const GraphState& graph, const std::string& topic) {
  const auto found = graph.topics.find(topic);
  return found == graph.topics.end() ? "" : found->second.type;
}

bool allows(Directions directions, Side from) {
  return directions == Directions::kBoth ||
         (directions == Directions::kRobotToWorkstation) == (from == Side::kRobot);
}

}  // namespace

Result<BridgeSelector> BridgeSelector::make(const BridgeParams& params) {
  auto topics = NameMatcher::make(params.topics, "topics");
  if (!topics) return tl::unexpected(topics.error());
  auto services = NameMatcher::make(params.services, "services");
  if (!services) return tl::unexpected(services.error());
  auto profiles = Profiles::make(params.profiles);
  if (!profiles) return tl::unexpected(profiles.error());
  BridgeSelector rules(params);
  rules.topics_ = std::move(*topics);
  rules.services_ = std::move(*services);
  rules.profiles_ = std::move(*profiles);
  return rules;
}

bool BridgeSelector::has_others(const std::vector<std::string>& nodes, Side side) const {
  const auto& own = params_.sides[static_cast<std::size_t>(side)].peer.name;
  return std::any_of(nodes.begin(), nodes.end(), [&](const auto& node) { return node != own; });
}

/// /clock and /rosout have separate settings and ignore the filters.
bool BridgeSelector::may_bridge(const std::string& topic, Side from) {
  if (topic == "/clock") return params_.clock && allows(params_.clock_direction, from);
  if (topic == "/rosout") return params_.rosout && from == Side::kRobot;
  if (topic == "/rosout_agg") return false;
  return topics_.matches(topic) && allows(profiles_.of(topic).directions, from);
}

BridgedTopics BridgeSelector::topics(const Graphs& graphs) {
  BridgedTopics bridged;
  for (const auto from : {Side::kRobot, Side::kWorkstation}) add_topics(graphs, from, bridged);
  for (const auto server_at : {Side::kRobot, Side::kWorkstation}) add_actions(graphs, server_at, bridged);
  return bridged;
}

void BridgeSelector::add_topics(const Graphs& graphs, Side from, BridgedTopics& bridged) {
  const auto& there = graph_of(graphs, other(from)).topics;
  for (const auto& [name, topic] : graph_of(graphs, from).topics) {
    if (!has_others(topic.publishers, from) || !may_bridge(name, from)) continue;
    const auto counterpart = there.find(name);
    BridgedTopic entry;
    entry.type = topic.type;
    entry.eager = !profiles_.of(name).lazy;
    entry.listeners = counterpart != there.end() && has_others(counterpart->second.subscribers, other(from));
    bridged[{name, from}] = entry;
  }
}

bool BridgeSelector::has_server(const GraphState& graph, const std::string& action, Side side) const {
  const auto status = graph.topics.find(action + "/status");
  return status != graph.topics.end() && has_others(status->second.publishers, side);
}

/// An action's five topics are bridged as a unit as soon as there is a server: a client accepts a server only
/// if one node has all five, so goal and cancel must exist before any client publishes them.
void BridgeSelector::add_actions(const Graphs& graphs, Side server_at, BridgedTopics& bridged) {
  static const std::string kGoal = "/goal";
  const auto& graph = graph_of(graphs, server_at);
  for (const auto& [name, topic] : graph.topics) {
    if (!ends_with(name, kGoal) || !ends_with(topic.type, "ActionGoal")) continue;
    const auto action = name.substr(0, name.size() - kGoal.size());
    if (!has_server(graph, action, server_at)) continue;
    if (!has_others(topic.subscribers, server_at) || !may_bridge(name, other(server_at))) continue;
    if (has_server(graph_of(graphs, other(server_at)), action, other(server_at))) {
      keep_apart(action, bridged);
      continue;
    }
    for (const auto* part : {"/goal", "/cancel"}) {
      auto& entry = bridged[{action + part, other(server_at)}];
      if (entry.type.empty() || entry.type == "*")
        entry.type = type_of(graph_of(graphs, other(server_at)), action + part);
      if (entry.type.empty() || entry.type == "*") entry.type = type_of(graph, action + part);
      entry.action = action;
      entry.eager = true;
    }
    for (const auto* part : {"/status", "/feedback", "/result"}) {
      auto& entry = bridged[{action + part, server_at}];
      if (entry.type.empty()) entry.type = type_of(graph, action + part);
      entry.action = action;
      entry.eager = true;
    }
  }
}

BridgedServices BridgeSelector::services(const Graphs& graphs) {
  BridgedServices bridged;
  for (const auto from : {Side::kRobot, Side::kWorkstation}) {
    const auto& there = graph_of(graphs, other(from)).services;
    for (const auto& [name, providers] : graph_of(graphs, from).services) {
      if (!has_others(providers, from) || !services_.matches(name)) continue;
      const auto counterpart = there.find(name);
      // A service that both sides have stays where it is.
      if (counterpart != there.end() && has_others(counterpart->second, other(from))) continue;
      bridged[name] = from;
    }
  }
  return bridged;
}

}  // namespace extperfc::translate
