#pragma once

#include <array>
#include <map>
#include <string>

#include "extperfc/translate/bridge.hpp"

#include "translate/bridge/name_filter.hpp"

namespace extperfc::translate {

/// A topic that is bridged in one direction.
struct BridgedTopic {
  std::string type;
  std::string action;  ///< name of the action it belongs to, or empty
  bool eager{false};
  bool listeners{false};  ///< the other side has subscribers
};

/// (topic, side of its publishers) -> how.
using BridgedTopics = std::map<std::pair<std::string, Side>, BridgedTopic>;
/// Service -> side of its server.
using BridgedServices = std::map<std::string, Side>;

/// Selects bridged topics and services from the masters' graphs. No side effects; the translator's own nodes
/// do not count.
class BridgeSelector {
 public:
  [[nodiscard]] static Result<BridgeSelector> make(const BridgeParams& params);

  using Graphs = std::array<GraphState, 2>;
  [[nodiscard]] BridgedTopics topics(const Graphs& graphs);
  [[nodiscard]] BridgedServices services(const Graphs& graphs);

 private:
  explicit BridgeSelector(const BridgeParams& params) : params_(params) {}
  [[nodiscard]] bool may_bridge(const std::string& topic, Side from);
  [[nodiscard]] bool has_others(const std::vector<std::string>& nodes, Side side) const;
  [[nodiscard]] bool has_server(const GraphState& graph, const std::string& action, Side side) const;
  void add_topics(const Graphs& graphs, Side from, BridgedTopics& bridged);
  void add_actions(const Graphs& graphs, Side server_at, BridgedTopics& bridged);

  BridgeParams params_;
  NameMatcher topics_, services_;
  Profiles profiles_;
};

}  // namespace extperfc::translate
