#include "subscription.hpp"

#include <algorithm>
#include <utility>

#include <sys/epoll.h>

namespace extperfc::translate {

SubscriptionState::SubscriptionState(std::shared_ptr<PeerCore> core, std::string topic,
                                     Subscription::Handlers handlers, Subscription::Params params)
    : core_(std::move(core)),
      topic_(std::move(topic)),
      handlers_(std::move(handlers)),
      params_(std::move(params)),
      absent_(
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
  absent_.clear();
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
  // The same list again: somebody on it registered again, and it is not told who.
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
  absent_.forget(source->link.uri);
  if (was_up && handlers_.on_down)
    handlers_.on_down(source->link, "the master no longer lists the publisher");
  if (!closed_ && handlers_.on_gone) handlers_.on_gone(source->link);
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
  if (list == nullptr || list->size() != 3) return refused("has not three elements");
  const auto* code = (*list)[0].as<std::int32_t>();
  const auto* status = (*list)[1].as<std::string>();
  if (code == nullptr || *code != 1)
    return refused("is a refusal: " + (status != nullptr ? *status : "no reason"));
  const auto* protocol = (*list)[2].as<XmlArray>();
  if (protocol == nullptr || protocol->size() < 3) return refused("names no protocol that we speak");
  const auto* name = (*protocol)[0].as<std::string>();
  const auto* host = (*protocol)[1].as<std::string>();
  const auto* port = (*protocol)[2].as<std::int32_t>();
  if (name == nullptr || *name != "TCPROS" || host == nullptr || port == nullptr || *port <= 0 ||
      *port > 65535) {
    return refused("names no TCPROS address");
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
    return reject(source, "it is translator " + mark + ": what was translated is not translated again");
  }
  const auto refused = outgoing->header.find("error");
  if (refused != outgoing->header.end()) return fail_attempt(source, "it refused: " + refused->second);
  bring_up(source, std::move(*outgoing));
}

void SubscriptionState::bring_up(const SourcePtr& source, Outgoing outgoing) {
  source->step = Step::kUp;
  absent_.forget(source->link.uri);
  source->up_since = EventLoop::now();
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
  const bool wanted = !handlers_.on_up || handlers_.on_up(source->link);
  if (!wanted && source->attempt == attempt && !closed_) reject(source, "");
}

void SubscriptionState::read(SourcePtr source) {
  const auto attempt = source->attempt;
  const auto outcome = source->reader->read(
      source->socket.get(), core_->params.tcpros.read_at_once,
      [this, &source, attempt](std::shared_ptr<Frame> frame, std::uint8_t, SteadyTime received) {
        ++source->messages;
        source->bytes += frame->payload().size;
        if (handlers_.on_message) handlers_.on_message(source->link, std::move(frame), received);
        return source->attempt == attempt;
      });
  if (source->attempt != attempt) return;
  if (outcome == FrameReader::Outcome::kClosed) {
    lose(source, source->reader->problem());
  } else if (outcome == FrameReader::Outcome::kBroken) {
    const auto problem = source->reader->problem();
    tell_problem(*source, problem);
    if (source->attempt == attempt) lose(source, problem);
  }
}

void SubscriptionState::lose(const SourcePtr& source, const std::string& reason) {
  if (EventLoop::now() - source->up_since > core_->params.tcpros.retry_last) source->delay = {};
  stop(*source);
  source->step = Step::kWaiting;
  const auto attempt = source->attempt;
  if (handlers_.on_down) handlers_.on_down(source->link, reason);
  if (closed_ || source->attempt != attempt) return;
  if (source->listed) return retry_later(source);
  remove(source);
}

void SubscriptionState::reject(const SourcePtr& source, const std::string& reason) {
  stop(*source);
  source->step = Step::kRejected;
  absent_.forget(source->link.uri);
  if (!reason.empty()) tell_problem(*source, reason);
}

void SubscriptionState::fail_attempt(const SourcePtr& source, const std::string& reason) {
  stop(*source);
  source->step = Step::kWaiting;
  retry_later(source);
  tell_problem(*source, reason);
}

void SubscriptionState::retry_later(const SourcePtr& source) {
  absent_.expect(source->link.uri);
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

void SubscriptionState::tell_problem(Source& source, const std::string& reason) {
  if (source.problem == reason) return;
  source.problem = reason;
  if (handlers_.on_problem) handlers_.on_problem(source.link.uri, reason);
}

void SubscriptionState::set_priority(Priority priority) {
  params_.priority = priority;
  for (auto& [uri, source] : sources_) source->socket.set_priority(priority);
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
  patience_ = std::min(2 * patience_, kMostLooks);
  core_->master->renew(registration_);
}

std::size_t SubscriptionState::connected() const {
  std::size_t count = 0;
  for (const auto& [uri, source] : sources_) count += source->step == Step::kUp ? 1 : 0;
  return count;
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
  explicit SubscriptionHandle(std::shared_ptr<SubscriptionState> state) : state_(std::move(state)) {}
  ~SubscriptionHandle() override { state_->close(); }
  SubscriptionHandle(const SubscriptionHandle&) = delete;
  SubscriptionHandle& operator=(const SubscriptionHandle&) = delete;

  const std::string& topic() const override { return state_->topic(); }
  std::size_t connected() const override { return state_->connected(); }
  void set_priority(Priority priority) override { state_->set_priority(priority); }
  void compare(std::size_t publishers) override { state_->compare(publishers); }

 private:
  std::shared_ptr<SubscriptionState> state_;
};

}  // namespace

std::unique_ptr<Subscription> make_subscription(const std::shared_ptr<PeerCore>& core,
                                                const std::string& topic, Subscription::Handlers handlers,
                                                const Subscription::Params& params) {
  auto state = std::make_shared<SubscriptionState>(core, topic, std::move(handlers), params);
  state->open();
  return std::make_unique<SubscriptionHandle>(std::move(state));
}

}  // namespace extperfc::translate
