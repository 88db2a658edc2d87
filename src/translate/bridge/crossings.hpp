#pragma once

#include <array>
#include <map>
#include <string>

#include "extperfc/translate/bridge.hpp"

#include "name_filter.hpp"

namespace extperfc::translate {

/// A topic that is to cross, one way.
struct TopicCrossing {
  std::string type;
  std::string action;  ///< name of the action it belongs to, or empty
  bool eager{false};
  bool listeners{false};  ///< somebody on the other side wants it
};

/// (topic, side of its publishers) -> how.
using TopicCrossings = std::map<std::pair<std::string, End>, TopicCrossing>;
/// Service -> side of its server.
using ServiceCrossings = std::map<std::string, End>;

/// What is to cross, from what the masters say. No side effects; nodes of our own do not count.
class CrossingRules {
 public:
  [[nodiscard]] static Result<CrossingRules> make(const BridgeParams& params);

  using Graphs = std::array<GraphState, 2>;
  [[nodiscard]] TopicCrossings topics(const Graphs& graphs);
  [[nodiscard]] ServiceCrossings services(const Graphs& graphs);

 private:
  explicit CrossingRules(const BridgeParams& params) : params_(params) {}
  [[nodiscard]] bool may_cross(const std::string& topic, End from);
  [[nodiscard]] bool has_others(const std::vector<std::string>& nodes, End end) const;
  [[nodiscard]] bool has_server(const GraphState& graph, const std::string& action, End end) const;
  void add_topics(const Graphs& graphs, End from, TopicCrossings& crossings);
  void add_actions(const Graphs& graphs, End server_at, TopicCrossings& crossings);

  BridgeParams params_;
  Crossing topics_, services_;
  Profiles profiles_;
};

}  // namespace extperfc::translate
