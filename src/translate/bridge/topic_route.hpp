#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "translate/bridge/context.hpp"
#include "translate/bridge/latched_store.hpp"

namespace extperfc::translate {

/// One topic in one direction: a subscription at the publishers' side, a publication at the other, and
/// between them a plan for each pair of definitions in use.
class TopicRoute {
 public:
  struct Params {
    std::string topic;
    std::string type;  ///< as the master knows it; "*" when it does not
    Side from{Side::kRobot};
    TopicProfile profile;
    std::string action;  ///< name of the action it belongs to, or empty
    bool eager{false};   ///< subscribe at once, without subscribers: actions, profiles that are not lazy
  };

  TopicRoute(BridgeContext& context, Params params);
  ~TopicRoute();
  TopicRoute(const TopicRoute&) = delete;
  TopicRoute& operator=(const TopicRoute&) = delete;

  /// Takes the masters' current state; opens or closes the subscription. `publishers`: without our own.
  void update(bool listeners_at_other_side, std::size_t publishers);
  /// Publishers are still connected, listed or not.
  [[nodiscard]] bool alive() const { return subscription_ && subscription_->connected() > 0; }
  [[nodiscard]] const Params& params() const { return params_; }
  /// Rules or definitions changed: restarts the connections.
  void restart();

  [[nodiscard]] TopicStatus status() const;
  /// To be called regularly, for rates.
  void measure(SteadyTime now);

 private:
  struct Source {
    PublisherLink link;
    MessageDefinition definition;
    bool latching{false};
  };
  struct Target {
    MessageDefinition definition;
    std::string name;  ///< caller id of the subscriber
  };
  struct Waiting {
    std::shared_ptr<SubscriberRequest> request;
    EventLoop::TimerId deadline{0};
  };

  void on_request(const std::shared_ptr<SubscriberRequest>& request);
  void answer(SubscriberRequest& request);
  void answer_waiting();
  [[nodiscard]] MessageDefinition wanted_definition(const ConnectionHeader& header) const;
  [[nodiscard]] MessageDefinition any_definition() const;
  [[nodiscard]] std::string refusal_reason(const MessageDefinition& target) const;
  void accept(SubscriberRequest& request, const MessageDefinition& definition);
  void send_latched(LinkId link, const MessageDefinition& definition);

  void subscribe();
  bool on_up(const PublisherLink& link);
  void on_message(const PublisherLink& link, const FramePtr& frame, SteadyTime received);
  void on_gone(const PublisherLink& link);
  [[nodiscard]] bool too_fast(SteadyTime now);
  [[nodiscard]] bool filtered(const FramePtr& frame) const;
  void deliver(const MessageDefinition& from, const FramePtr& frame, SteadyTime since);
  [[nodiscard]] FramePtr convert_frame(const MessageDefinition& from, const MessageDefinition& to,
                                       const FramePtr& frame);
  [[nodiscard]] PlanOptions options() const;
  [[nodiscard]] bool merges_transforms() const;
  [[nodiscard]] bool latching() const;
  void complain(const std::string& problem);
  [[nodiscard]] bool demand() const;

  BridgeContext& context_;
  Params params_;
  std::unique_ptr<Publication> publication_;
  std::unique_ptr<Subscription> subscription_;
  std::map<LinkId, Source> sources_;
  std::map<LinkId, Target> targets_;
  std::vector<Waiting> waiting_;
  LatchedStore latched_;
  bool listeners_{false};
  SteadyTime last_demand_{};
  SteadyTime next_allowed_{};

  struct Counts {
    std::uint64_t messages{0}, bytes{0}, dropped{0}, failed{0};
    double latency_sum_s{0}, latency_max_s{0};
    std::uint64_t latency_count{0};
  };
  Counts counts_;
  std::uint64_t lost_with_links_{0};  ///< drops of connections that have ended
  std::string problem_;
  SteadyTime quiet_until_{};
  SteadyTime measured_{};
  std::uint64_t measured_messages_{0};
  double rate_hz_{0};
};

}  // namespace extperfc::translate
