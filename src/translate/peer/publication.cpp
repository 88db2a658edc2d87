#include "translate/peer/publication.hpp"

#include <algorithm>
#include <cerrno>
#include <utility>

#include <sys/epoll.h>

#include "translate/peer/subscription.hpp"

namespace extperfc::translate {
namespace {

/// What the owner holds of a connection that waits for our header.
class PublicationRequest : public SubscriberRequest {
 public:
  PublicationRequest(std::weak_ptr<PublicationState> state, LinkId id, Incoming incoming)
      : state_(std::move(state)),
        id_(id),
        header_(std::move(incoming.header)),
        address_(std::move(incoming.remote_address)) {}
  ~PublicationRequest() override { PublicationRequest::refuse("the topic is not available"); }
  PublicationRequest(const PublicationRequest&) = delete;
  PublicationRequest& operator=(const PublicationRequest&) = delete;
  const ConnectionHeader& header() const override { return header_; }
  const std::string& remote_address() const override { return address_; }
  LinkId accept(const std::string& type, const std::string& md5, const std::string& definition,
                bool latching) override {
    const auto state = std::exchange(state_, {}).lock();
    if (!state) return 0;
    return state->accept(id_, {{"type", type},
                               {"md5sum", md5},
                               {"message_definition", definition},
                               {"latching", latching ? "1" : "0"}});
  }
  void refuse(const std::string& reason) override {
    if (const auto state = std::exchange(state_, {}).lock()) state->refuse(id_, reason);
  }

 private:
  std::weak_ptr<PublicationState> state_;
  LinkId id_;
  ConnectionHeader header_;
  std::string address_;
};

}  // namespace

namespace {

/// The kernel gave up a connection whose other end does not answer: that end knows nothing of it.
bool is_silence(const std::string& problem) {
  return problem == errno_text(ETIMEDOUT) || problem == errno_text(EHOSTUNREACH) ||
         problem == errno_text(ENETUNREACH);
}

}  // namespace

PublicationState::PublicationState(std::shared_ptr<PeerCore> core, std::string topic,
                                   Publication::Handlers handlers, const SendParams& params)
    : core_(std::move(core)),
      topic_(std::move(topic)),
      handlers_(std::move(handlers)),
      params_(params),
      missing_subscribers_(
          core_->loop, [this] { call_back(); }, core_->params.tcpros.call_back_first,
          core_->params.tcpros.call_back_last) {}

void PublicationState::open(const std::string& type) {
  type_ = type;
  core_->publications.emplace(topic_, this);
  registration_ =
      core_->master->keep_publisher(topic_, type, [weak = weak_from_this()](const Result<XmlValue>& answer) {
        const auto self = weak.lock();
        if (self && !self->closed_) self->on_registered(answer);
      });
}

void PublicationState::close() {
  if (std::exchange(closed_, true)) return;
  end_registration(*core_, core_->publications, topic_, this);
  while (!pending_.empty()) refuse(pending_.begin()->first, "the publisher of " + topic_ + " shuts down");
  links_.clear();
  missing_subscribers_.clear();
}

void PublicationState::incoming(Incoming incoming) {
  const auto refuse_now = [&](const std::string& reason) {
    send_refusal(incoming.socket.get(), core_->own_header(), reason);
  };
  const auto mark = core_->mark_in(incoming.header);
  if (!mark.empty()) {
    return refuse_now(topic_ + " is translated by " + core_->params.name +
                      " and is not available to another translator (" + mark + "), to prevent a loop");
  }
  if (pending_.size() + links_.size() >= core_->params.tcpros.links) {
    return refuse_now("too many subscribers of " + topic_ + " (" + std::to_string(links_.size()) + ")");
  }
  if (!handlers_.on_request) return refuse_now(topic_ + " takes no subscribers");
  const auto id = core_->next_link();
  auto& pending = pending_[id];
  pending.socket = std::move(incoming.socket);
  pending.caller = value_of(incoming.header, "callerid");
  watch_pending(id, pending);

  const auto keep = shared_from_this();
  handlers_.on_request(std::make_shared<PublicationRequest>(keep, id, std::move(incoming)));
}

void PublicationState::watch_pending(LinkId id, Pending& pending) {
  const auto weak = weak_from_this();
  const auto forget = [weak, id] {
    if (const auto self = weak.lock()) self->forget_pending(id);
  };
  pending.deadline = core_->loop.after(core_->params.tcpros.handshake, forget);
  pending.socket.watch(core_->loop, EPOLLRDHUP, params_.priority, [forget](std::uint32_t) { forget(); });
}

void PublicationState::forget_pending(LinkId id) {
  const auto found = pending_.find(id);
  if (found == pending_.end()) return;
  core_->loop.cancel(found->second.deadline);
  pending_.erase(found);
}

void PublicationState::refuse(LinkId id, const std::string& reason) {
  const auto found = pending_.find(id);
  if (found == pending_.end()) return;
  send_refusal(found->second.socket.get(), core_->own_header(), reason);
  forget_pending(id);
}

LinkId PublicationState::accept(LinkId id, ConnectionHeader header) {
  const auto found = pending_.find(id);
  if (found == pending_.end() || closed_) return 0;
  header.merge(core_->own_header());
  header["topic"] = topic_;
  const auto bytes = encode_header(header);
  auto frame = core_->frames.take(bytes.size());
  frame->buffer().append(bytes.data() + Frame::kPrefix, bytes.size() - Frame::kPrefix);
  frame->seal();

  auto link = std::make_unique<Link>(core_->loop, [weak = weak_from_this(), id] {
    if (const auto self = weak.lock()) self->give_up(id, "it does not read its messages");
  });
  link->socket = std::move(found->second.socket);
  link->ends = ends_of(link->socket.get());
  link->caller = std::move(found->second.caller);
  forget_pending(id);
  auto& placed = *links_.emplace(id, std::move(link)).first->second;
  apply(placed);
  placed.queue.push_header(std::move(frame));
  watch_link(id, placed);
  missing_subscribers_.forget(placed.caller);
  flush(id, placed);
  if (!placed.dead) return id;
  links_.erase(id);
  return 0;
}

void PublicationState::watch_link(LinkId id, Link& link) {
  // Never EPOLLIN: a subscriber has nothing to say, and what it sends all the same stays in the kernel,
  // bounded.
  link.socket.watch(core_->loop, EPOLLRDHUP, params_.priority,
                    [weak = weak_from_this(), id](std::uint32_t events) {
                      if (const auto self = weak.lock()) self->handle(id, events);
                    });
}

void PublicationState::handle(LinkId id, std::uint32_t events) {
  const auto found = links_.find(id);
  if (found == links_.end() || found->second->dead) return;
  if ((events & (EPOLLRDHUP | EPOLLHUP | EPOLLERR)) != 0) {
    const auto problem = connect_problem(found->second->socket.get());
    if (is_silence(problem)) return give_up(id, problem);
    if (!problem.empty()) return break_link(id, problem);
    return end_link(id, "the subscriber closed the connection");
  }
  flush(id, *found->second);
}

void PublicationState::send(LinkId id, FramePtr frame, SteadyTime since) {
  const auto found = links_.find(id);
  if (found == links_.end() || found->second->dead) return;
  auto& link = *found->second;
  link.queue.push(std::move(frame), since);
  if (!link.blocked) flush(id, link);
}

void PublicationState::flush(LinkId id, Link& link) {
  const auto outcome = link.queue.write(link.socket.get());
  if (outcome == SendQueue::Outcome::kBroken)
    return is_silence(link.queue.problem()) ? give_up(id, link.queue.problem())
                                            : break_link(id, link.queue.problem());
  const bool blocked = outcome == SendQueue::Outcome::kBlocked;
  if (blocked || ages()) link.stall.start(link.socket.get(), patience());
  if (blocked == link.blocked) return;
  link.blocked = blocked;
  link.socket.want(blocked ? EPOLLRDHUP | EPOLLOUT : EPOLLRDHUP);
  if (!blocked && !ages()) link.stall.stop();
}

void PublicationState::lose_carrier(const std::vector<std::string>& addresses) {
  if (!ages()) return;
  for (const auto id : links()) {
    const auto local = local_address(links_.at(id)->socket.get());
    if (std::find(addresses.begin(), addresses.end(), local) != addresses.end())
      give_up(id, "the network interface of " + local + " lost its carrier");
  }
}

void PublicationState::end_link(LinkId id, const std::string& reason) {
  const auto found = links_.find(id);
  if (found == links_.end() || found->second->dead) return;
  found->second->dead = true;
  found->second->stall.stop();
  found->second->socket.close();
  core_->loop.post([weak = weak_from_this(), id, reason] {
    if (const auto self = weak.lock()) self->report_down(id, reason);
  });
}

void PublicationState::break_link(LinkId id, const std::string& reason) {
  const auto found = links_.find(id);
  if (found == links_.end() || found->second->dead) return;
  end_link(id, reason);
  expect(*found->second);
}

void PublicationState::give_up(LinkId id, const std::string& reason) {
  const auto found = links_.find(id);
  if (found == links_.end() || found->second->dead) return;
  abort_connection(found->second->socket);
  break_link(id, reason);
  core_->half_open.notify(found->second->ends, [weak = weak_from_this()] {
    if (const auto self = weak.lock()) self->missing_subscribers_.hurry();
  });
}

void PublicationState::expect(const Link& link) {
  const bool has_another = std::any_of(links_.begin(), links_.end(), [&](const auto& one) {
    return !one.second->dead && one.second->caller == link.caller;
  });
  if (!has_another) missing_subscribers_.expect(link.caller);
}

void PublicationState::call_back() {
  calling_back_ = true;
  core_->master->renew(registration_);
}

void PublicationState::on_registered(const Result<XmlValue>& subscribers) {
  const bool called_back = std::exchange(calling_back_, false);
  if (missing_subscribers_.empty() || !subscribers || subscribers->as<XmlArray>() == nullptr) return;
  const auto listed = uris_in(*subscribers);
  if (listed.empty()) return missing_subscribers_.clear();
  // Registered for another reason: the master came back, so they may be reachable again as well.
  if (!called_back) return missing_subscribers_.hurry();
  if (missing_subscribers_.calls() < 2) return;  // most are on their way
  const auto names = missing_subscribers_.names();
  for (const auto& name : names) ask_whether_listed(name, listed);
}

void PublicationState::ask_whether_listed(const std::string& caller, const std::vector<std::string>& listed) {
  core_->master->call("lookupNode", {caller},
                      [weak = weak_from_this(), caller, listed](const Result<XmlValue>& answer) {
                        const auto self = weak.lock();
                        if (!self) return;
                        const auto* uri = answer ? answer->as<std::string>() : nullptr;
                        const bool unknown = !answer && answer.error().code == ErrorCode::kNotFound;
                        const bool elsewhere =
                            uri != nullptr && std::find(listed.begin(), listed.end(), *uri) == listed.end();
                        if (unknown || elsewhere) self->missing_subscribers_.forget(caller);
                      });
}

void PublicationState::report_down(LinkId id, const std::string& reason) {
  if (closed_ || links_.count(id) == 0) return;
  if (handlers_.on_down) handlers_.on_down(id, reason);  // its stats() are still there
  links_.erase(id);
}

void PublicationState::close_link(LinkId id) {
  links_.erase(id);
  forget_pending(id);
}

void PublicationState::configure(const SendParams& params) {
  params_ = params;
  for (auto& [id, link] : links_) {
    if (!link->dead) apply(*link);
  }
}

void PublicationState::apply(Link& link) const {
  link.queue.configure(params_);
  link.socket.set_priority(params_.priority);
  set_unsent(link.socket.get(), params_.priority);
  set_unacknowledged(link.socket.get(), patience());
}

std::chrono::milliseconds PublicationState::patience() const {
  return params_.unacknowledged.value_or(core_->params.tcpros.unacknowledged);
}

void PublicationState::announce_again() {
  core_->master->again(registration_);
  while (!pending_.empty()) refuse(pending_.begin()->first, topic_ + " is announced again; connect again");
  for (const auto id : links()) break_link(id, "announced again");
}

std::vector<LinkId> PublicationState::links() const {
  std::vector<LinkId> ids;
  for (const auto& [id, link] : links_) {
    if (!link->dead) ids.push_back(id);
  }
  return ids;
}

LinkStats PublicationState::stats(LinkId id) const {
  const auto found = links_.find(id);
  return found == links_.end() ? LinkStats{} : found->second->queue.stats();
}

std::vector<BusLink> PublicationState::bus() const {
  std::vector<BusLink> rows;
  for (const auto& [id, link] : links_) {
    if (!link->dead) rows.push_back({id, link->caller, true, topic_, link->queue.stats()});
  }
  return rows;
}

namespace {

class PublicationHandle : public Publication {
 public:
  explicit PublicationHandle(std::shared_ptr<PublicationState> state) : state_(std::move(state)) {}
  ~PublicationHandle() override { state_->close(); }
  PublicationHandle(const PublicationHandle&) = delete;
  PublicationHandle& operator=(const PublicationHandle&) = delete;

  const std::string& topic() const override { return state_->topic(); }
  void send(LinkId link, FramePtr frame, SteadyTime since) override {
    state_->send(link, std::move(frame), since);
  }
  void close(LinkId link) override { state_->close_link(link); }
  void configure(const SendParams& params) override { state_->configure(params); }
  std::vector<LinkId> links() const override { return state_->links(); }
  LinkStats stats(LinkId link) const override { return state_->stats(link); }
  void announce_again() override { state_->announce_again(); }

 private:
  std::shared_ptr<PublicationState> state_;
};

}  // namespace

std::unique_ptr<Publication> make_publication(const std::shared_ptr<PeerCore>& core, const std::string& topic,
                                              const std::string& type, Publication::Handlers handlers,
                                              const SendParams& params) {
  auto state = std::make_shared<PublicationState>(core, topic, std::move(handlers), params);
  state->open(type);
  return std::make_unique<PublicationHandle>(std::move(state));
}

}  // namespace extperfc::translate
