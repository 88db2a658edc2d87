#include "topic_route.hpp"

#include <algorithm>
#include <utility>

namespace extperfc::translate {

namespace {

constexpr auto kLinger = std::chrono::seconds(5);  // a subscription outlives its last listener by this much
constexpr auto kQuiet = std::chrono::seconds(2);   // between two complaints of one route
constexpr double kMinPatienceS =
    0.3;  // for an acknowledgement: one lost packet is sent again after 0.2 s at least

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000.0));
}

SendParams send_params(const TopicProfile& profile) {
  SendParams params;
  params.queue = profile.queue;
  params.max_age = milliseconds(profile.max_age_s);
  params.priority = profile.priority;
  // What the kernel still holds when a network returns is delivered then. For commands that must not happen.
  if (profile.max_age_s > 0)
    params.unacknowledged = std::max(milliseconds(profile.max_age_s), milliseconds(kMinPatienceS));
  return params;
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
  const auto patience = milliseconds(context_.params.schema_patience_s);
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

void TopicRoute::complain(const std::string& problem) {
  problem_ = problem;
  const auto now = EventLoop::now();
  if (now < quiet_until_) return;
  quiet_until_ = now + kQuiet;
  context_.problem(problem);
}

}  // namespace extperfc::translate
