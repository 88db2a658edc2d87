#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/translate/clock_offset.hpp"
#include "extperfc/translate/sntp_client.hpp"

#include "translate/bridge/context.hpp"

namespace extperfc::translate {

/// Measures the robot's clock: by the stamps of topics that it publishes, and by its NTP server.
class ClockMonitor {
 public:
  /// `resolver` must outlive it.
  ClockMonitor(BridgeContext& context, Resolver& resolver);

  [[nodiscard]] BridgeStatus::Clock status() const;
  /// What is added to the stamps of messages that leave `from` [ns]; 0 while nothing is known.
  [[nodiscard]] std::int64_t shift_ns(Side from) const;

 private:
  void watch_topic(const std::string& topic);
  void on_message(const std::string& topic, const FramePtr& frame, SteadyTime received);

  BridgeContext& context_;
  ClockOffset offset_;
  std::string last_topic_;
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
  std::unique_ptr<SntpClient> sntp_;
};

}  // namespace extperfc::translate
