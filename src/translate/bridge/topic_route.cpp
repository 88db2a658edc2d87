#include "translate/bridge/topic_route.hpp"

#include <algorithm>
#include <utility>

#include "translate/bridge/little_endian.hpp"

namespace extperfc::translate {

namespace {

constexpr auto kLinger = std::chrono::seconds(5);  // a subscription outlives its last listener by this much
constexpr auto kQuiet = std::chrono::seconds(2);   // between two complaints of one route
constexpr double kMinPatienceS =
    0.3;  // for an acknowledgement: one lost packet is sent again after 0.2 s at least

std::chrono::milliseconds to_milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000.0));
}

SendParams send_params(const TopicProfile& profile) {
  SendParams params;
  params.queue = profile.queue;
  params.max_age = to_milliseconds(profile.max_age_s);
  params.priority = profile.priority;
  // What the kernel still holds when a network returns is delivered then. For commands that must not happen.
  if (profile.max_age_s > 0)
    params.unacknowledged = std::max(to_milliseconds(profile.max_age_s), to_milliseconds(kMinPatienceS));
  return params;
}

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

TopicRoute::TopicRoute(BridgeContext& context, Params params)
    : context_(context), params_(std::move(params)) {
  Publication::Handlers handlers;
  handlers.on_request = [this](const std::shared_ptr<SubscriberRequest>& request) { on_request(request); };
  handlers.on_down = [this](LinkId link, const std::string&) {
    lost_with_links_ += publication_->stats(link).dropped_queue + publication_->stats(link).dropped_age;
    targets_.erase(link);
  };
  const auto to = other(params_.from);
  auto type = params_.type;
  if (!context_.native(to, type))  // a package that has another name there
    for (const auto& name : context_.plans.rules().other_names(type))
      if (context_.native(to, name)) type = name;
  publication_ =
      context_.peer(to).advertise(params_.topic, type, std::move(handlers), send_params(params_.profile));
  if (params_.eager) subscribe();
}

TopicRoute::~TopicRoute() {
  for (const auto& waiting : waiting_) context_.loop.cancel(waiting.deadline);
}

bool TopicRoute::demand() const {
  return params_.eager || listeners_ || !targets_.empty() || !waiting_.empty();
}

void TopicRoute::update(bool listeners_at_other_side, std::size_t publishers) {
  listeners_ = listeners_at_other_side;
  const auto now = EventLoop::now();
  if (demand()) {
    last_demand_ = now;
    if (!subscription_) subscribe();
  } else if (subscription_ && now - last_demand_ > kLinger) {
    subscription_.reset();
    sources_.clear();
    latched_ = {};
  }
  if (subscription_) subscription_->compare(publishers);
}

void TopicRoute::restart() {
  problem_.clear();
  targets_.clear();
  publication_->announce_again();
}

// Subscribers.

void TopicRoute::on_request(const std::shared_ptr<SubscriberRequest>& request) {
  last_demand_ = EventLoop::now();
  if (!subscription_) subscribe();
  if (!sources_.empty()) return answer(*request);
  // The plan depends on a definition that no publisher has sent yet.
  Waiting waiting{request, 0};
  const auto patience = to_milliseconds(context_.params.schema_patience_s);
  waiting.deadline = context_.loop.after(patience, [this, held = std::weak_ptr(request)] {
    const auto late = held.lock();
    waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(),
                                  [&](const Waiting& one) { return one.request == late; }),
                   waiting_.end());
    if (late) answer(*late);
  });
  waiting_.push_back(std::move(waiting));
}

void TopicRoute::answer_waiting() {
  auto waiting = std::exchange(waiting_, {});
  for (auto& one : waiting) {
    context_.loop.cancel(one.deadline);
    answer(*one.request);
  }
}

void TopicRoute::answer(SubscriberRequest& request) {
  const auto target = wanted_definition(request.header());
  if (target.md5 == "*" || target.md5.empty())
    return request.refuse("no publisher of " + params_.topic + " answers yet");
  const auto reason = refusal_reason(target);
  if (!reason.empty()) {
    complain(reason);
    return request.refuse(reason);
  }
  accept(request, target);
}

/// The definition that a subscriber requests; for "*", this side's own definition or else the publishers'.
MessageDefinition TopicRoute::wanted_definition(const ConnectionHeader& header) const {
  const auto md5 = value_of(header, "md5sum");
  auto type = value_of(header, "type");
  if (type.empty() || type == "*")
    type = sources_.empty() ? params_.type : sources_.begin()->second.definition.type;
  if (md5 == "*") return any_definition();
  // For equal MD5s use the publisher's text: subscribers of roscpp do not send one.
  const auto text = value_of(header, "message_definition");
  if (text.empty())
    for (const auto& [link, source] : sources_)
      if (source.definition.md5 == md5) return {type, md5, source.definition.schema};
  return context_.plans.definition(type, md5, text);
}

MessageDefinition TopicRoute::any_definition() const {
  if (sources_.empty()) {
    if (const auto native = context_.native(other(params_.from), params_.type))
      return {params_.type, native->md5(), native};
    return {params_.type, "*", nullptr};
  }
  const auto& source = sources_.begin()->second.definition;
  if (const auto native = context_.native(other(params_.from), source.type)) {
    MessageDefinition definition{source.type, native->md5(), native};
    if (context_.plans.conversion(source, definition, options()).possible) return definition;
  }
  return source;
}

/// Why no publisher's messages can be converted to `target`; empty if some can.
std::string TopicRoute::refusal_reason(const MessageDefinition& target) const {
  std::string reason;
  for (const auto& [link, source] : sources_) {
    const auto conversion = context_.plans.conversion(source.definition, target, options());
    if (conversion.possible) return {};
    reason = params_.topic + ": " + conversion.problem;
  }
  return reason;
}

void TopicRoute::accept(SubscriberRequest& request, const MessageDefinition& definition) {
  const auto link = request.accept(definition.type, definition.md5,
                                   definition.schema ? definition.schema->full_text() : "", latching());
  if (link == 0) return;
  targets_[link] = {definition, value_of(request.header(), "callerid")};
  send_latched(link, definition);
}

void TopicRoute::send_latched(LinkId link, const MessageDefinition& definition) {
  const auto now = EventLoop::now();
  if (merges_transforms())
    if (const auto merged = latched_.merged_transforms(context_.frames))
      if (const auto frame = convert_frame(merged->definition, definition, merged->frame))
        return publication_->send(link, frame, now);
  for (const auto& entry : latched_.entries())
    if (const auto frame = convert_frame(entry.definition, definition, entry.frame))
      publication_->send(link, frame, now);
}

bool TopicRoute::latching() const {
  return std::any_of(sources_.begin(), sources_.end(),
                     [](const auto& source) { return source.second.latching; });
}

// Publishers.

void TopicRoute::subscribe() {
  Subscription::Handlers handlers;
  handlers.on_up = [this](const PublisherLink& link) { return on_up(link); };
  handlers.on_message = [this](const PublisherLink& link, const FramePtr& frame, SteadyTime received) {
    on_message(link, frame, received);
  };
  handlers.on_down = [this](const PublisherLink& link, const std::string&) { sources_.erase(link.id); };
  handlers.on_gone = [this](const PublisherLink& link) { on_gone(link); };
  handlers.on_problem = [this](const std::string& uri, const std::string& reason) {
    const auto line = params_.topic + ": publisher " + uri + ": " + reason;
    // Every node publishes /rosout: that one ended without a word, its other topics show.
    if (params_.topic == "/rosout") return context_.log(line);
    complain(line);
  };
  Subscription::Params params;
  params.type = params_.type;
  params.tcp_nodelay = params_.profile.tcp_nodelay;
  params.priority = params_.profile.priority;
  subscription_ = context_.peer(params_.from).subscribe(params_.topic, std::move(handlers), params);
}

bool TopicRoute::on_up(const PublisherLink& link) {
  Source source;
  source.link = link;
  source.definition =
      context_.plans.definition(value_of(link.header, "type"), value_of(link.header, "md5sum"),
                                value_of(link.header, "message_definition"));
  source.latching = value_of(link.header, "latching") == "1";
  if (params_.type.empty() || params_.type == "*") params_.type = source.definition.type;
  sources_[link.id] = std::move(source);
  problem_.clear();
  answer_waiting();
  return true;
}

void TopicRoute::on_gone(const PublisherLink& link) {
  sources_.erase(link.id);
  latched_.forget(value_of(link.header, "callerid"));
}

// Each message.

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

// Figures and problems.

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

void TopicRoute::complain(const std::string& problem) {
  problem_ = problem;
  const auto now = EventLoop::now();
  if (now < quiet_until_) return;
  quiet_until_ = now + kQuiet;
  context_.problem(problem);
}

}  // namespace extperfc::translate
