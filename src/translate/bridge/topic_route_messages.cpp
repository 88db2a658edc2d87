// What a route does with each message, and its figures.
#include <algorithm>
#include <utility>

#include "little_endian.hpp"
#include "topic_route.hpp"

namespace extperfc::translate {

namespace {

double seconds(SteadyTime::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

/// The level of a rosgraph_msgs/Log: after a header (seq, time, frame id); nothing when the bytes end before.
std::optional<std::uint8_t> log_level(ByteView message) {
  constexpr std::size_t kFrameId = 12;
  if (message.size < kFrameId + 4) return std::nullopt;
  const std::size_t level = kFrameId + 4 + std::size_t{load_u32(message.data + kFrameId)};
  if (level >= message.size) return std::nullopt;
  return message.data[level];
}

}  // namespace

void TopicRoute::on_message(const PublisherLink& link, const FramePtr& frame, SteadyTime received) {
  const auto found = sources_.find(link.id);
  if (found == sources_.end()) return;
  const auto& source = found->second;
  ++counts_.messages;
  counts_.bytes += frame->payload().size;
  if (source.latching) latched_.keep(value_of(link.header, "callerid"), source.definition, frame);
  if (targets_.empty() || filtered(frame)) return;
  if (too_fast(received)) {
    ++counts_.dropped;
    return;
  }
  // A listener keeps the last message of a connection for those who come later in its process.
  if (source.latching && merges_transforms()) {
    if (const auto merged = latched_.merged_transforms(context_.frames))
      return deliver(merged->definition, merged->frame, received);
  }
  deliver(source.definition, frame, received);
}

void TopicRoute::deliver(const MessageDefinition& from, const FramePtr& frame, SteadyTime since) {
  // Subscribers with one definition share the converted frame. Few definitions are in use at a time.
  std::vector<std::pair<const MessageDefinition*, FramePtr>> done;
  for (const auto& [link, target] : targets_) {
    const auto same =
        std::find_if(done.begin(), done.end(), [&, &definition = target.definition](const auto& one) {
          return one.first->md5 == definition.md5 && one.first->schema == definition.schema;
        });
    FramePtr out;
    if (same != done.end()) {
      out = same->second;
    } else {
      out = convert_frame(from, target.definition, frame);
      done.emplace_back(&target.definition, out);
    }
    if (out) publication_->send(link, std::move(out), since);
  }
  const auto latency = seconds(EventLoop::now() - since);
  counts_.latency_sum_s += latency;
  counts_.latency_max_s = std::max(counts_.latency_max_s, latency);
  ++counts_.latency_count;
}

/// The converted frame; null on failure, which is counted and reported.
FramePtr TopicRoute::convert_frame(const MessageDefinition& from, const MessageDefinition& to,
                                   const FramePtr& frame) {
  const auto conversion = context_.plans.conversion(from, to, options());
  if (conversion.possible && conversion.raw()) return frame;
  if (!conversion.possible) {
    ++counts_.failed;
    complain(params_.topic + ": " + conversion.problem);
    return nullptr;
  }
  auto converted = context_.frames.take(frame->payload().size);
  const auto result =
      conversion.plan->convert(frame->payload(), converted->buffer(), context_.shift_ns(params_.from));
  if (!result) {
    ++counts_.failed;
    complain(params_.topic + ": a message was dropped: " + result.error().message);
    return nullptr;
  }
  converted->seal();
  return converted;
}

bool TopicRoute::too_fast(SteadyTime now) {
  if (params_.profile.max_rate_hz <= 0) return false;
  if (now < next_allowed_) return true;
  const auto period = std::chrono::duration_cast<SteadyTime::duration>(
      std::chrono::duration<double>(1.0 / params_.profile.max_rate_hz));
  next_allowed_ = std::max(next_allowed_ + period, now + period / 2);  // jitter does not lower the rate
  return false;
}

bool TopicRoute::filtered(const FramePtr& frame) const {
  if (params_.topic != "/rosout") return false;
  const auto level = log_level(frame->payload());
  return !level || *level < context_.params.rosout_min_level;
}

PlanOptions TopicRoute::options() const {
  PlanOptions options;
  options.shift_times = context_.params.clocks.shift_stamps;
  options.frame_slash = params_.profile.frame_slash;
  return options;
}

bool TopicRoute::merges_transforms() const {
  return params_.type == "tf2_msgs/TFMessage" || params_.type == "tf/tfMessage";
}

void TopicRoute::measure(SteadyTime now) {
  const auto passed = seconds(now - measured_);
  if (measured_ != SteadyTime{} && passed > 0)
    rate_hz_ = static_cast<double>(counts_.messages - measured_messages_) / passed;
  measured_ = now;
  measured_messages_ = counts_.messages;
}

TopicStatus TopicRoute::status() const {
  TopicStatus status;
  status.topic = params_.topic;
  status.from = params_.from;
  status.from_type = params_.type;
  status.publishers = sources_.size();
  if (!sources_.empty()) status.from_md5 = sources_.begin()->second.definition.md5;
  status.messages = counts_.messages;
  status.bytes = counts_.bytes;
  status.failed = counts_.failed;
  status.dropped = counts_.dropped + lost_with_links_;
  for (const auto& [link, target] : targets_) {
    const auto stats = publication_->stats(link);
    status.dropped += stats.dropped_queue + stats.dropped_age;
    auto known = std::find_if(
        status.to.begin(), status.to.end(),
        [&, &md5 = target.definition.md5](const auto& definition) { return definition.md5 == md5; });
    if (known == status.to.end()) {
      std::string plan = "unknown: no publisher is connected";
      if (!sources_.empty())
        plan = context_.plans.conversion(sources_.begin()->second.definition, target.definition, options())
                   .describe();
      status.to.push_back({target.definition.type, target.definition.md5, plan, 0});
      known = std::prev(status.to.end());
    }
    ++known->subscribers;
  }
  status.rate_hz = rate_hz_;
  if (counts_.latency_count > 0)
    status.latency_mean_s = counts_.latency_sum_s / static_cast<double>(counts_.latency_count);
  status.latency_max_s = counts_.latency_max_s;
  status.action = params_.action;
  status.problem = problem_;
  if (subscription_ && problem_.empty())
    if (const auto problem = subscription_->problem(); !problem.empty())
      status.problem = params_.topic + ": " + problem;
  return status;
}

}  // namespace extperfc::translate
