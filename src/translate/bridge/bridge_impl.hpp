#pragma once

#include <array>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/translate/bridge.hpp"
#include "extperfc/translate/frame.hpp"

#include "translate/bridge/bridge_selector.hpp"
#include "translate/bridge/clock_monitor.hpp"
#include "translate/bridge/context.hpp"
#include "translate/bridge/param_route.hpp"
#include "translate/bridge/plan_cache.hpp"
#include "translate/bridge/service_route.hpp"
#include "translate/bridge/topic_route.hpp"

namespace extperfc::translate {

/// Polls both graphs and keeps one route for every bridged topic, service and parameter prefix.
class BridgeImpl final : public Bridge {
 public:
  BridgeImpl(EventLoop& loop, BridgeParams params, DefinitionStore definitions, RuleSet rules,
             Handlers handlers, BridgeSelector selector, Profiles profiles);
  ~BridgeImpl() override;

  [[nodiscard]] Result<void> open();

  [[nodiscard]] BridgeStatus status() override;
  void replace_rules(RuleSet rules) override;
  void shut_down(std::chrono::milliseconds patience, std::function<void()> done) override;

 private:
  [[nodiscard]] Result<void> open_side(Side side);
  void on_master(Side side, const Peer::MasterStatus& status);
  void poll();
  void on_graph(Side side, Result<GraphState> graph);
  void update_topics();
  void open_routes(const BridgedTopics& bridged);
  void close_routes(const BridgedTopics& bridged);
  [[nodiscard]] std::size_t publishers_of(const std::string& topic, Side from) const;
  void update_services();
  void schedule();
  void report_once(const std::string& problem);

  static constexpr std::size_t kMaxReported = 1000;  // remembered problems, so that each is reported once

  EventLoop& loop_;
  BridgeParams params_;
  DefinitionStore definitions_;
  PlanCache plans_;
  Handlers handlers_;
  BridgeSelector selector_;
  Profiles profiles_;
  FramePool frames_;
  BridgeContext context_;
  std::set<std::string> reported_;
  std::array<std::uint64_t, 2> restarts_{};

  BridgeSelector::Graphs graphs_;
  std::array<bool, 2> known_{};  ///< the master was seen at least once
  int answers_awaited_{0};
  EventLoop::TimerId timer_{0};
  bool closing_{false};
  std::shared_ptr<bool> alive_{std::make_shared<bool>(true)};

  // The order matters: routes end before the nodes that carry them.
  std::unique_ptr<Resolver> resolver_;
  std::array<std::unique_ptr<Peer>, 2> peers_;
  std::unique_ptr<ClockMonitor> clock_;
  struct HeldTopic {
    std::unique_ptr<TopicRoute> route;
    SteadyTime missing_since{};  ///< the masters no longer list what it carries
  };
  std::map<std::pair<std::string, Side>, HeldTopic> topics_;
  std::map<std::string, std::pair<Side, std::unique_ptr<ServiceRoute>>> services_;
  std::map<std::string, std::vector<std::string>> providers_;
  ParamRoute::Written written_;
  std::vector<std::pair<Side, std::unique_ptr<ParamRoute>>> param_routes_;
};

}  // namespace extperfc::translate
