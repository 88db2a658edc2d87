#include "translate/peer/subscription.hpp"

#include <algorithm>
#include <utility>

#include <sys/epoll.h>

namespace extperfc::translate {

SubscriptionState::SubscriptionState(std::shared_ptr<PeerCore> core, std::string topic,
                                     Subscription::Params params)
    : core_(std::move(core)),
      topic_(std::move(topic)),
      params_(std::move(params)),
      missing_publishers_(
          core_->loop, [this] { core_->master->renew(registration_); }, core_->params.tcpros.call_back_first,
          core_->params.tcpros.call_back_last) {}

void SubscriptionState::open() {
  core_->subscriptions.emplace(topic_, this);
  registration_ = core_->master->keep_subscriber(topic_, params_.type,
                                                 [weak = weak_from_this()](const Result<XmlValue>& list) {
                                                   const auto self = weak.lock();
                                                   if (self && list) self->update(uris_in(*list));
                                                 });
}

void SubscriptionState::close() {
  if (std::exchange(closed_, true)) return;
  end_registration(*core_, core_->subscriptions, topic_, this);
  for (auto& [uri, source] : sources_) stop(*source);
  sources_.clear();
  missing_publishers_.clear();
}

Consumers::ConsumerPtr SubscriptionState::join(Subscription::Handlers handlers,
                                               const Subscription::Params& params) {
  const bool first = consumers_.empty();
  auto consumer = consumers_.add(std::move(handlers), params.priority);
  if (first) return consumer;
  if (params_.type == "*") params_.type = params.type;
  use_priority();
  core_->loop.post([weak = weak_from_this(), consumer] {
    if (const auto self = weak.lock()) self->catch_up(consumer);
  });
  return consumer;
}

void SubscriptionState::catch_up(const Consumers::ConsumerPtr& consumer) {
  const auto sources = sources_;
  for (const auto& [uri, source] : sources) {
    if (consumer->gone) return;
    catch_up(*consumer, source);
  }
  reject_unwanted();
}

void SubscriptionState::catch_up(Consumers::Consumer& consumer, const SourcePtr& source) {
  if (source->step == Step::kRejected) ask(source);
  if (source->step != Step::kUp) {
    if (!source->problem.empty() && consumer.handlers.on_problem)
      consumer.handlers.on_problem(source->link.uri, source->problem);
    return;
  }
  if (Consumers::up(consumer, source->link) && source->latched && consumer.handlers.on_message)
    consumer.handlers.on_message(source->link, source->latched, EventLoop::now());
}

void SubscriptionState::leave(const Consumers::ConsumerPtr& consumer) {
  const auto keep = shared_from_this();
  consumers_.remove(consumer);
  if (consumers_.empty()) return close();
  use_priority();
  core_->loop.post([weak = weak_from_this()] {  // it may leave while others are asked
    if (const auto self = weak.lock()) self->reject_unwanted();
  });
}

/// Of connections that stand, those that no consumer accepted.
void SubscriptionState::reject_unwanted() {
  for (const auto& [uri, source] : sources_) {
    if (source->step == Step::kUp && !consumers_.want(source->link.id)) reject(source, "");
  }
}

void SubscriptionState::stop(Source& source) const {
  core_->loop.cancel(std::exchange(source.retry, 0));
  ++source.attempt;
  source.step = Step::kGone;
  source.connector.reset();
  source.socket.close();
}

void SubscriptionState::update(const std::vector<std::string>& uris) {
  if (closed_) return;
  const auto keep = shared_from_this();
  std::set<std::string> listed(uris.begin(), uris.end());
  listed.erase(core_->uri);
  // The same list again: a publisher registered again, and the master does not report which one.
  const bool same = listed == listed_;
  listed_ = listed;

  const auto life = core_->master->status().restarts;
  std::vector<SourcePtr> gone;
  for (const auto& [uri, source] : sources_) {
    if (listed.count(uri) != 0) continue;
    source->listed = false;
    if (source->step != Step::kUp || source->master == life) gone.push_back(source);
  }
  for (const auto& source : gone) {
    remove(source);
    if (closed_) return;
  }
  for (const auto& uri : listed) {
    add_or_retry(uri, same);
    if (closed_) return;
  }
}

void SubscriptionState::add_or_retry(const std::string& uri, bool also_rejected) {
  auto& source = sources_[uri];
  if (!source) {
    if (sources_.size() > core_->params.tcpros.links) {
      sources_.erase(uri);
      return core_->log("too many publishers of " + topic_ + ": " + uri + " is left out");
    }
    source = std::make_shared<Source>();
    source->link.uri = uri;
  }
  source->listed = true;
  source->master = core_->master->status().restarts;
  const bool idle = source->step == Step::kWaiting || (source->step == Step::kRejected && also_rejected);
  if (!idle) return;
  source->delay = core_->params.tcpros.retry_first;
  ask(SourcePtr(source));
}

void SubscriptionState::remove(const SourcePtr& source) {
  const bool was_up = source->step == Step::kUp;
  stop(*source);
  sources_.erase(source->link.uri);
  missing_publishers_.forget(source->link.uri);
  if (was_up) consumers_.down(source->link, "the master no longer lists the publisher");
  consumers_.gone(source->link);
}

void SubscriptionState::ask(const SourcePtr& source) {
  core_->loop.cancel(std::exchange(source->retry, 0));
  source->step = Step::kAsking;
  const auto attempt = ++source->attempt;
  XmlArray arguments{core_->params.name, topic_, XmlArray{XmlArray{"TCPROS"}}};
  core_->client.call(source->link.uri, "requestTopic", std::move(arguments), core_->params.node_timeout,
                     [weak = weak_from_this(), source, attempt](const Result<XmlValue>& answer) {
                       const auto self = weak.lock();
                       if (self && source->attempt == attempt) self->answered(source, answer);
                     });
}

namespace {

/// [1, status, ["TCPROS", host, port]]
Result<HostPort> address_in(const XmlValue& answer) {
  const auto refused = [](const std::string& why) {
    return fail(ErrorCode::kFailed, "its answer to requestTopic " + why);
  };
  const auto* list = answer.as<XmlArray>();
  if (list == nullptr || list->size() != 3) return refused("does not have three elements");
  const auto* code = (*list)[0].as<std::int32_t>();
  const auto* status = (*list)[1].as<std::string>();
  if (code == nullptr || *code != 1)
    return refused("is a refusal: " + (status != nullptr ? *status : "no reason"));
  const auto* protocol = (*list)[2].as<XmlArray>();
  if (protocol == nullptr || protocol->size() < 3) return refused("offers no supported protocol");
  const auto* name = (*protocol)[0].as<std::string>();
  const auto* host = (*protocol)[1].as<std::string>();
  const auto* port = (*protocol)[2].as<std::int32_t>();
  if (name == nullptr || *name != "TCPROS" || host == nullptr || port == nullptr || *port <= 0 ||
      *port > 65535) {
    return refused("contains no TCPROS address");
  }
  return HostPort{*host, static_cast<std::uint16_t>(*port)};
}

}  // namespace

void SubscriptionState::answered(const SourcePtr& source, const Result<XmlValue>& answer) {
  const auto to = answer ? address_in(*answer) : Result<HostPort>(tl::unexpected<Error>(answer.error()));
  if (!to) return fail_attempt(source, to.error().message);
  connect(source, *to);
}

void SubscriptionState::connect(const SourcePtr& source, HostPort to) {
  source->step = Step::kConnecting;
  const auto attempt = source->attempt;
  auto header = core_->own_header();
  header["topic"] = topic_;
  header["type"] = params_.type;
  header["md5sum"] = params_.md5;
  header["tcp_nodelay"] = params_.tcp_nodelay ? "1" : "0";
  TcprosConnector::Params params{std::move(to), std::move(header), core_->params.node_timeout,
                                 params_.priority, core_->params.tcpros};
  source->connector = std::make_unique<TcprosConnector>(
      core_->loop, core_->resolver, std::move(params),
      [weak = weak_from_this(), source, attempt](Result<Outgoing> outgoing) {
        const auto self = weak.lock();
        if (self && source->attempt == attempt) self->connected_to(source, std::move(outgoing));
      });
}

void SubscriptionState::connected_to(const SourcePtr& source, Result<Outgoing> outgoing) {
  if (!outgoing) return fail_attempt(source, outgoing.error().message);
  const auto mark = core_->mark_in(outgoing->header);
  if (!mark.empty()) {
    return reject(source, "it is translator " + mark + ": translated messages are not translated again");
  }
  const auto refused = outgoing->header.find("error");
  if (refused != outgoing->header.end()) return fail_attempt(source, "it refused: " + refused->second);
  bring_up(source, std::move(*outgoing));
}

void SubscriptionState::bring_up(const SourcePtr& source, Outgoing outgoing) {
  source->step = Step::kUp;
  missing_publishers_.forget(source->link.uri);
  source->up_since = EventLoop::now();
  source->down_since.reset();
  source->problem.clear();
  source->link.id = core_->next_link();
  source->link.header = std::move(outgoing.header);
  source->socket = std::move(outgoing.socket);
  source->connector.reset();
  source->reader = std::make_unique<FrameReader>(
      core_->frames, core_->scratch, FrameReader::Params{core_->params.tcpros.message_bytes, false, false});
  const auto attempt = source->attempt;
  source->socket.watch(core_->loop, EPOLLIN, params_.priority,
                       [weak = weak_from_this(), source, attempt](std::uint32_t) {
                         const auto self = weak.lock();
                         if (self && source->attempt == attempt) self->read(source);
                       });
  source->latched.reset();
  consumers_.up(source->link);
  if (source->attempt == attempt && !consumers_.want(source->link.id)) reject(source, "");
}

void SubscriptionState::read(SourcePtr source) {
  const auto attempt = source->attempt;
  const bool latching = value_of(source->link.header, "latching") == "1";
  const auto outcome =
      source->reader->read(source->socket.get(), core_->params.tcpros.read_at_once,
                           [this, &source, attempt, latching](const std::shared_ptr<Frame>& frame,
                                                              std::uint8_t, SteadyTime received) {
                             ++source->messages;
                             source->bytes += frame->payload().size;
                             if (latching) source->latched = frame;
                             consumers_.message(source->link, frame, received);
                             return source->attempt == attempt;
                           });
  if (source->attempt != attempt) return;
  if (outcome == FrameReader::Outcome::kClosed) {
    lose(source, source->reader->problem());
  } else if (outcome == FrameReader::Outcome::kBroken) {
    const auto problem = source->reader->problem();
    report_problem(*source, problem);
    if (source->attempt == attempt) lose(source, problem);
  }
}

namespace {

std::string flap_text(const std::string& reason) {
  return "the connection ends again and again, and messages are lost: check the publisher's log, and whether "
         "another node has the same name (last reason: " +
         reason + ")";
}

}  // namespace

void SubscriptionState::lose(const SourcePtr& source, const std::string& reason) {
  if (EventLoop::now() - source->up_since > core_->params.tcpros.retry_last) source->delay = {};
  stop(*source);
  source->step = Step::kWaiting;
  source->down_since = EventLoop::now();
  const auto attempt = source->attempt;
  consumers_.down(source->link, reason);
  if (source->attempt != attempt) return;
  note_loss(source, reason);
  if (source->attempt != attempt) return;
  if (source->listed) return retry_later(source);
  remove(source);
}

void SubscriptionState::note_loss(const SourcePtr& source, const std::string& reason) {
  source->loss = reason;
  source->losses.push_back(EventLoop::now());
  if (source->losses.size() > kFlaps) source->losses.pop_front();
  if (flaps(*source)) report_problem(*source, flap_text(reason));
}

bool SubscriptionState::flaps(const Source& source) const {
  return source.losses.size() == kFlaps &&
         EventLoop::now() - source.losses.front() < core_->params.tcpros.flap_window;
}

std::string SubscriptionState::problem() const {
  for (const auto& [uri, source] : sources_) {
    if (flaps(*source)) return "publisher " + uri + ": " + flap_text(source->loss);
  }
  return {};
}

void SubscriptionState::reject(const SourcePtr& source, const std::string& reason) {
  stop(*source);
  source->step = Step::kRejected;
  missing_publishers_.forget(source->link.uri);
  if (!reason.empty()) report_problem(*source, reason);
}

void SubscriptionState::fail_attempt(const SourcePtr& source, const std::string& reason) {
  stop(*source);
  source->step = Step::kWaiting;
  retry_later(source);
  // Most publishers that are lost have ended: the master soon lists them no more.
  const auto grace = core_->params.tcpros.lost_grace;
  if (source->down_since && EventLoop::now() - *source->down_since < grace) return;
  report_problem(*source, reason);
}

void SubscriptionState::retry_later(const SourcePtr& source) {
  missing_publishers_.expect(source->link.uri);
  const auto& limits = core_->params.tcpros;
  const auto delay =
      std::clamp(source->delay, limits.retry_first, std::max(limits.retry_first, limits.retry_last));
  source->delay = delay * 2;
  source->retry = core_->loop.after(delay, [weak = weak_from_this(), source] {
    const auto self = weak.lock();
    source->retry = 0;
    if (self && source->step == Step::kWaiting) self->ask(source);
  });
}

void SubscriptionState::report_problem(Source& source, const std::string& reason) {
  if (source.problem == reason) return;
  source.problem = reason;
  consumers_.problem(source.link.uri, reason);
}

void SubscriptionState::set_priority(Consumers::Consumer& consumer, Priority priority) {
  consumer.priority = priority;
  use_priority();
}

void SubscriptionState::use_priority() {
  params_.priority = consumers_.priority();
  for (auto& [uri, source] : sources_) source->socket.set_priority(params_.priority);
}

/// A count that stays unequal for good costs the master less and less.
void SubscriptionState::compare(std::size_t publishers) {
  if (publishers == listed_.size()) {
    unequal_looks_ = 0;
    patience_ = kLooks;
    return;
  }
  if (++unequal_looks_ < patience_) return;
  unequal_looks_ = 0;
  patience_ = std::min(2 * patience_, kMaxLooks);
  core_->master->renew(registration_);
}

std::vector<BusLink> SubscriptionState::bus() const {
  std::vector<BusLink> rows;
  for (const auto& [uri, source] : sources_) {
    if (source->step != Step::kUp) continue;
    LinkStats stats;
    stats.messages = source->messages;
    stats.bytes = source->bytes;
    rows.push_back({source->link.id, uri, false, topic_, stats});
  }
  return rows;
}

std::vector<std::string> uris_in(const XmlValue& value) {
  std::vector<std::string> uris;
  const auto* list = value.as<XmlArray>();
  if (list == nullptr) return uris;
  for (const auto& entry : *list) {
    if (const auto* uri = entry.as<std::string>()) uris.push_back(*uri);
  }
  return uris;
}

namespace {

class SubscriptionHandle : public Subscription {
 public:
  SubscriptionHandle(std::shared_ptr<SubscriptionState> state, Consumers::ConsumerPtr consumer)
      : state_(std::move(state)), consumer_(std::move(consumer)) {}
  ~SubscriptionHandle() override {
    try {
      state_->leave(consumer_);
    } catch (...) {
      // The connections then end with the state, when its last consumer goes.
    }
  }
  SubscriptionHandle(const SubscriptionHandle&) = delete;
  SubscriptionHandle& operator=(const SubscriptionHandle&) = delete;

  const std::string& topic() const override { return state_->topic(); }
  std::size_t connected() const override { return consumer_->links.size(); }
  void set_priority(Priority priority) override { state_->set_priority(*consumer_, priority); }
  void compare(std::size_t publishers) override { state_->compare(publishers); }
  std::string problem() const override { return state_->problem(); }

 private:
  std::shared_ptr<SubscriptionState> state_;
  Consumers::ConsumerPtr consumer_;
};

}  // namespace

std::unique_ptr<Subscription> make_subscription(const std::shared_ptr<PeerCore>& core,
                                                const std::string& topic, Subscription::Handlers handlers,
                                                const Subscription::Params& params) {
  const auto present = core->subscriptions.equal_range(topic);
  for (auto at = present.first; at != present.second; ++at) {
    if (at->second->md5() != params.md5) continue;
    auto state = at->second->shared_from_this();
    auto consumer = state->join(std::move(handlers), params);
    return std::make_unique<SubscriptionHandle>(std::move(state), std::move(consumer));
  }
  auto state = std::make_shared<SubscriptionState>(core, topic, params);
  auto consumer = state->join(std::move(handlers), params);
  state->open();
  return std::make_unique<SubscriptionHandle>(std::move(state), std::move(consumer));
}

}  // namespace extperfc::translate
