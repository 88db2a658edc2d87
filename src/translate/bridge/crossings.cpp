#include "crossings.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace extperfc::translate {

namespace {

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

const GraphState& graph_of(const CrossingRules::Graphs& graphs, End end) {
  return graphs[static_cast<std::size_t>(end)];
}

/// Both sides have a server of that name: goals and states of the two must not mix.
void keep_apart(const std::string& action, TopicCrossings& crossings) {
  for (const auto* part : {"/goal", "/cancel", "/status", "/feedback", "/result"})
    for (const auto end : {End::kOld, End::kNew}) crossings.erase({action + part, end});
}

std::string type_of(const GraphState& graph, const std::string& topic) {
  const auto found = graph.topics.find(topic);
  return found == graph.topics.end() ? "" : found->second.type;
}

bool allows(Directions directions, End from) {
  return directions == Directions::kBoth || (directions == Directions::kOldToNew) == (from == End::kOld);
}

}  // namespace

Result<CrossingRules> CrossingRules::make(const BridgeParams& params) {
  auto topics = Crossing::make(params.topics, "topics");
  if (!topics) return tl::unexpected(topics.error());
  auto services = Crossing::make(params.services, "services");
  if (!services) return tl::unexpected(services.error());
  auto profiles = Profiles::make(params.profiles);
  if (!profiles) return tl::unexpected(profiles.error());
  CrossingRules rules(params);
  rules.topics_ = std::move(*topics);
  rules.services_ = std::move(*services);
  rules.profiles_ = std::move(*profiles);
  return rules;
}

bool CrossingRules::has_others(const std::vector<std::string>& nodes, End end) const {
  const auto& own = params_.ends[static_cast<std::size_t>(end)].peer.name;
  return std::any_of(nodes.begin(), nodes.end(), [&](const auto& node) { return node != own; });
}

/// Time and logs have rules of their own, whatever the filters say.
bool CrossingRules::may_cross(const std::string& topic, End from) {
  if (topic == "/clock") return params_.clock && allows(params_.clock_direction, from);
  if (topic == "/rosout") return params_.rosout && from == End::kOld;
  if (topic == "/rosout_agg") return false;
  return topics_.crosses(topic) && allows(profiles_.of(topic).directions, from);
}

TopicCrossings CrossingRules::topics(const Graphs& graphs) {
  TopicCrossings crossings;
  for (const auto from : {End::kOld, End::kNew}) add_topics(graphs, from, crossings);
  for (const auto server_at : {End::kOld, End::kNew}) add_actions(graphs, server_at, crossings);
  return crossings;
}

void CrossingRules::add_topics(const Graphs& graphs, End from, TopicCrossings& crossings) {
  const auto& there = graph_of(graphs, other(from)).topics;
  for (const auto& [name, topic] : graph_of(graphs, from).topics) {
    if (!has_others(topic.publishers, from) || !may_cross(name, from)) continue;
    const auto counterpart = there.find(name);
    TopicCrossing crossing;
    crossing.type = topic.type;
    crossing.eager = !profiles_.of(name).lazy;
    crossing.listeners =
        counterpart != there.end() && has_others(counterpart->second.subscribers, other(from));
    crossings[{name, from}] = crossing;
  }
}

bool CrossingRules::has_server(const GraphState& graph, const std::string& action, End end) const {
  const auto status = graph.topics.find(action + "/status");
  return status != graph.topics.end() && has_others(status->second.publishers, end);
}

/// An action's five topics cross as one as soon as there is a server: a client looks for all five at one node
/// before it believes in the server, so goal and cancel must be there before any client publishes them.
void CrossingRules::add_actions(const Graphs& graphs, End server_at, TopicCrossings& crossings) {
  static const std::string kGoal = "/goal";
  const auto& graph = graph_of(graphs, server_at);
  for (const auto& [name, topic] : graph.topics) {
    if (!ends_with(name, kGoal) || !ends_with(topic.type, "ActionGoal")) continue;
    const auto action = name.substr(0, name.size() - kGoal.size());
    if (!has_server(graph, action, server_at)) continue;
    if (!has_others(topic.subscribers, server_at) || !may_cross(name, other(server_at))) continue;
    if (has_server(graph_of(graphs, other(server_at)), action, other(server_at))) {
      keep_apart(action, crossings);
      continue;
    }
    for (const auto* part : {"/goal", "/cancel"}) {
      auto& crossing = crossings[{action + part, other(server_at)}];
      if (crossing.type.empty() || crossing.type == "*")
        crossing.type = type_of(graph_of(graphs, other(server_at)), action + part);
      if (crossing.type.empty() || crossing.type == "*") crossing.type = type_of(graph, action + part);
      crossing.action = action;
      crossing.eager = true;
    }
    for (const auto* part : {"/status", "/feedback", "/result"}) {
      auto& crossing = crossings[{action + part, server_at}];
      if (crossing.type.empty()) crossing.type = type_of(graph, action + part);
      crossing.action = action;
      crossing.eager = true;
    }
  }
}

ServiceCrossings CrossingRules::services(const Graphs& graphs) {
  ServiceCrossings crossings;
  for (const auto from : {End::kOld, End::kNew}) {
    const auto& there = graph_of(graphs, other(from)).services;
    for (const auto& [name, providers] : graph_of(graphs, from).services) {
      if (!has_others(providers, from) || !services_.crosses(name)) continue;
      const auto counterpart = there.find(name);
      // A service that both sides have stays where it is.
      if (counterpart != there.end() && has_others(counterpart->second, other(from))) continue;
      crossings[name] = from;
    }
  }
  return crossings;
}

}  // namespace extperfc::translate
