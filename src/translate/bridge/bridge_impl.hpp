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

#include "clock_watch.hpp"
#include "context.hpp"
#include "crossings.hpp"
#include "param_route.hpp"
#include "plan_book.hpp"
#include "service_route.hpp"
#include "topic_route.hpp"

namespace extperfc::translate {

/// Looks at both graphs again and again, and keeps one route for everything that is to cross.
class BridgeImpl final : public Bridge {
 public:
  BridgeImpl(EventLoop& loop, BridgeParams params, DefinitionStore definitions, RuleSet rules,
             Handlers handlers, CrossingRules crossing_rules, Profiles profiles);
  ~BridgeImpl() override;

  [[nodiscard]] Result<void> open();

  [[nodiscard]] BridgeStatus status() override;
  void replace_rules(RuleSet rules) override;
  void shut_down(std::chrono::milliseconds patience, std::function<void()> done) override;

 private:
  [[nodiscard]] Result<void> open_end(End end);
  void on_master(End end, const Peer::MasterStatus& status);
  void look();
  void on_graph(End end, Result<GraphState> graph);
  void update_topics();
  void open_new(const TopicCrossings& crossings);
  void end_old(const TopicCrossings& crossings);
  [[nodiscard]] std::size_t publishers_of(const std::string& topic, End from) const;
  void update_services();
  void schedule();
  void tell(const std::string& problem);

  static constexpr std::size_t kMostTold = 1000;  // problems remembered, so that each is told once

  EventLoop& loop_;
  BridgeParams params_;
  DefinitionStore definitions_;
  PlanBook plans_;
  Handlers handlers_;
  CrossingRules crossing_rules_;
  Profiles profiles_;
  FramePool frames_;
  BridgeContext context_;
  std::set<std::string> told_;
  std::array<std::uint64_t, 2> restarts_{};

  CrossingRules::Graphs graphs_;
  std::array<bool, 2> known_{};  ///< the master was seen at least once
  int answers_awaited_{0};
  EventLoop::TimerId timer_{0};
  bool closing_{false};
  std::shared_ptr<bool> alive_{std::make_shared<bool>(true)};

  // The order matters: routes end before the nodes that carry them.
  std::unique_ptr<Resolver> resolver_;
  std::array<std::unique_ptr<Peer>, 2> peers_;
  std::unique_ptr<ClockWatch> clock_;
  struct HeldTopic {
    std::unique_ptr<TopicRoute> route;
    SteadyTime missing_since{};  ///< the masters no longer list what it carries
  };
  std::map<std::pair<std::string, End>, HeldTopic> topics_;
  std::map<std::string, std::pair<End, std::unique_ptr<ServiceRoute>>> services_;
  std::map<std::string, std::vector<std::string>> providers_;
  ParamRoute::Written written_;
  std::vector<std::pair<End, std::unique_ptr<ParamRoute>>> param_routes_;
};

}  // namespace extperfc::translate
