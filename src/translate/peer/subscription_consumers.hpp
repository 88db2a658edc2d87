#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "extperfc/translate/tcpros.hpp"

namespace extperfc::translate {

/// The parts of this program that subscribe to one topic: they share one connection to each publisher, for a
/// publisher of rospy keeps only the newest connection of one caller id. Consumers may come and go within
/// their own handlers, which then do not run any more. Of the loop's thread.
class Consumers {
 public:
  struct Consumer {
    Subscription::Handlers handlers;
    Priority priority{Priority::kNormal};
    bool gone{false};
    std::set<LinkId> links;  ///< those that it accepted
  };
  using ConsumerPtr = std::shared_ptr<Consumer>;

  [[nodiscard]] ConsumerPtr add(Subscription::Handlers handlers, Priority priority);
  void remove(const ConsumerPtr& consumer);
  [[nodiscard]] bool empty() const { return consumers_->empty(); }
  /// Of the most urgent one.
  [[nodiscard]] Priority priority() const;
  /// Some consumer accepted this link.
  [[nodiscard]] bool want(LinkId link) const;

  /// Asks everybody who does not have the link yet.
  void up(const PublisherLink& link) const;
  /// True when this one accepts the link now.
  static bool up(Consumer& consumer, const PublisherLink& link);
  void message(const PublisherLink& link, const FramePtr& frame, SteadyTime received) const;
  void down(const PublisherLink& link, const std::string& reason) const;
  void gone(const PublisherLink& link) const;
  void problem(const std::string& uri, const std::string& reason) const;

 private:
  using List = std::vector<ConsumerPtr>;
  template <typename Report>
  void each(Report report) const;

  std::shared_ptr<const List> consumers_{std::make_shared<const List>()};  ///< replaced by every change
};

}  // namespace extperfc::translate
