#include "translate/bridge/clock_monitor.hpp"

#include <cmath>
#include <utility>

#include "translate/bridge/little_endian.hpp"

namespace extperfc::translate {

namespace {

ClockOffset::Params offset_params(const ClockParams& clocks) {
  ClockOffset::Params params;
  params.window_s = clocks.window_s;
  return params;
}

}  // namespace

ClockMonitor::ClockMonitor(BridgeContext& context, Resolver& resolver)
    : context_(context), offset_(offset_params(context.params.clocks)) {
  if (context_.params.clock) return;  // simulated time has no offset to measure
  const auto& clocks = context_.params.clocks;
  for (const auto& topic : clocks.reference_topics) watch_topic(topic);
  if (clocks.ntp_server.empty()) return;
  SntpClient::Params params;
  params.host = clocks.ntp_server;
  params.port = clocks.ntp_port;
  SntpClient::Handlers handlers;
  handlers.on_sample = [this](const SntpClient::Sample& sample) {
    offset_.add_ntp_sample(sample.t0, sample.t1, sample.t2, sample.t3);
  };
  handlers.on_problem = [this](const std::string& problem) { context_.problem("clock: " + problem); };
  sntp_ = std::make_unique<SntpClient>(context_.loop, resolver, params, std::move(handlers));
}

void ClockMonitor::watch_topic(const std::string& topic) {
  Subscription::Handlers handlers;
  handlers.on_up = [this, topic](const PublisherLink& link) {
    const auto definition =
        context_.plans.definition(value_of(link.header, "type"), value_of(link.header, "md5sum"),
                                  value_of(link.header, "message_definition"));
    const bool stamped = definition.schema && !definition.schema->fields().empty() &&
                         definition.schema->fields().front().message &&
                         definition.schema->fields().front().message->type() == "std_msgs/Header";
    if (!stamped)
      context_.problem("clock: " + topic + " (" + definition.type +
                       ") does not begin with a std_msgs/Header: name another reference topic");
    return stamped;
  };
  handlers.on_message = [this, topic](const PublisherLink&, const FramePtr& frame, SteadyTime received) {
    on_message(topic, frame, received);
  };
  subscriptions_.push_back(context_.peer(Side::kRobot).subscribe(topic, std::move(handlers), {}));
}

/// A header is seq (uint32), stamp (seconds, nanoseconds), frame id.
void ClockMonitor::on_message(const std::string& topic, const FramePtr& frame, SteadyTime received) {
  const auto payload = frame->payload();
  if (payload.size < 12) return;
  const double stamp_s = load_u32(payload.data + 4) + 1e-9 * load_u32(payload.data + 8);
  last_topic_ = topic;
  offset_.add_stamp_sample(wall_clock_s(received), stamp_s);
}

BridgeStatus::Clock ClockMonitor::status() const {
  BridgeStatus::Clock clock;
  for (const auto& subscription : subscriptions_)
    if (const auto problem = subscription->problem(); !problem.empty())
      clock.problem = "clock: " + subscription->topic() + ": " + problem;
  const auto estimate = offset_.estimate();
  if (!estimate) return clock;
  clock.known = true;
  clock.offset_s = estimate->offset_s;
  clock.age_s = estimate->age_s;
  clock.source = estimate->source == ClockOffset::Source::kNtp ? "ntp " + context_.params.clocks.ntp_server
                                                               : "topic " + last_topic_;
  return clock;
}

std::int64_t ClockMonitor::shift_ns(Side from) const {
  if (!context_.params.clocks.shift_stamps) return 0;
  const auto estimate = offset_.estimate();
  if (!estimate) return 0;
  const auto offset_ns = std::llround(estimate->offset_s * 1e9);
  return from == Side::kRobot ? -offset_ns : offset_ns;
}

}  // namespace extperfc::translate
