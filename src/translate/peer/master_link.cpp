#include "translate/peer/master_link.hpp"

#include <deque>
#include <utility>

#include "translate/peer/master_calls.hpp"
#include "translate/peer/registrations.hpp"

namespace extperfc::translate {
namespace {

/// Registrations under way at once: an outage of hundreds of topics ends without a storm, and the question
/// whether the master lives never waits behind more.
constexpr std::size_t kInFlight = 8;
/// Looks at the master between two questions whether it still knows us: a master in a container can restart
/// with the same pid.
constexpr unsigned kKnownEvery = 5;
constexpr int kRefusedPeriods = 10;  ///< until what the master refused is tried again

/// No answer, a fault, or not XML-RPC; what a living master refuses comes as an answer.
bool is_silence(const Result<XmlValue>& answer) {
  return !answer.has_value();
}

}  // namespace

struct MasterLink::State : std::enable_shared_from_this<MasterLink::State> {
  State(EventLoop& on, RpcClient& by, Params with, Handlers call_back)
      : loop(on), client(by), params(std::move(with)), handlers(std::move(call_back)) {}

  EventLoop& loop;
  RpcClient& client;
  Params params;
  Handlers handlers;
  Peer::MasterStatus status;
  bool closed{false};  ///< the owner is gone: nothing is called back
  bool asking{false};  ///< getPid is under way
  bool ever_answered{false};
  bool ever_reported{false};
  std::uint64_t epoch{1};  ///< of the master's life as we see it: another one makes registrations void
  unsigned looks{0};
  EventLoop::TimerId look_timer{0};
  SteadyTime last_answer{};
  Registrations registrations;
  RegistrationId last_id{0};
  std::deque<RegistrationId> due;
  std::size_t in_flight{0};
  bool ending{false};
  std::function<void()> on_end;
  EventLoop::TimerId end_timer{0};

  // Does the master live?

  void look() {
    if (closed || ending || std::exchange(asking, true)) return;
    loop.cancel(std::exchange(look_timer, 0));
    const auto asked = EventLoop::now();
    raw_call("getPid", {}, [this, asked](Result<XmlValue> answer) {
      asking = false;
      on_pid(unpacked("getPid", std::move(answer)), asked);
      if (!closed && !ending) look_later();
    });
  }

  void look_later() {
    loop.cancel(look_timer);
    look_timer = loop.after(params.period, [weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->look();
    });
  }

  void on_pid(const Result<XmlValue>& answer, SteadyTime asked) {
    const auto* pid = answer ? answer->as<std::int32_t>() : nullptr;
    if (pid != nullptr) return on_alive(*pid);
    // Other calls may have kept the connection busy all the time.
    if (status.reachable && last_answer > asked) return;
    on_lost(answer ? "getPid at " + params.master_uri + ": the answer is not a number"
                   : answer.error().message);
  }

  void on_alive(std::int32_t pid) {
    const bool restarted = ever_answered && pid != status.pid;
    const bool returned = !status.reachable;
    ever_answered = true;
    if (restarted || returned) return begin_epoch(pid, restarted);
    if (++looks % kKnownEvery == 0) ask_whether_known();
    queue_all();
  }

  void begin_epoch(std::int32_t pid, bool restarted) {
    ++epoch;
    if (restarted) ++status.restarts;
    status.reachable = true;
    status.pid = pid;
    status.problem.clear();
    for (auto& [id, registration] : registrations.entries) registration.not_before = {};
    queue_all();
    report(std::string("the master at ") + params.master_uri + (restarted ? " restarted" : " is reachable") +
           ": registered everything");
  }

  void on_lost(const std::string& problem) {
    const bool changed = status.reachable || !ever_reported;
    status.reachable = false;
    status.problem = problem;
    forget_queue();
    if (changed) report("the master at " + params.master_uri + " is not reachable: " + problem);
  }

  void report(const std::string& line) {
    ever_reported = true;
    const auto call_back = handlers;  // stays whole when we are ended inside
    const auto now = status;
    if (call_back.on_log) call_back.on_log(line);
    if (!closed && call_back.on_master) call_back.on_master(now);
  }

  void ask_whether_known() {
    if (!registrations.any_stands(epoch)) return;
    raw_call("lookupNode", {params.caller_id}, [this, asked = epoch](Result<XmlValue> answer) {
      if (is_silence(answer) || asked != epoch || !registrations.any_stands(epoch)) return;
      const auto uri = unpack_reply("lookupNode", std::move(*answer));
      if (uri || uri.error().code != ErrorCode::kNotFound) return;
      begin_epoch(status.pid, true);
    });
  }

  // Calls.

  static Result<XmlValue> unpacked(const std::string& method, Result<XmlValue> answer) {
    return answer ? unpack_reply(method, std::move(*answer)) : std::move(answer);
  }

  /// `done` runs unless the owner is gone.
  void raw_call(const std::string& method, XmlArray further, RpcClient::Done done) {
    XmlArray arguments{params.caller_id};
    arguments.insert(arguments.end(), std::make_move_iterator(further.begin()),
                     std::make_move_iterator(further.end()));
    client.call(params.master_uri, method, std::move(arguments), params.timeout,
                [weak = weak_from_this(), done = std::move(done)](Result<XmlValue> answer) {
                  const auto self = weak.lock();
                  if (!self || self->closed) return;
                  if (answer) self->last_answer = EventLoop::now();
                  const bool hint = !answer && self->status.reachable;
                  done(std::move(answer));
                  if (hint && !self->closed) self->look();
                });
  }

  // Registrations. Each has one call under way at most; step() says which is next.

  RegistrationId keep(Registered what, Done done) {
    const auto id = ++last_id;
    auto& made = registrations.entries[id];
    made.what = std::move(what);
    made.done = std::move(done);
    queue(id, made);
    return id;
  }

  [[nodiscard]] bool wants_step(const Registration& registration) const {
    if (registration.busy || registration.queued || registration.not_before > EventLoop::now()) return false;
    return registration.dropped || registration.again || registration.renew || registration.epoch != epoch;
  }

  void queue(RegistrationId id, Registration& registration) {
    if (!wants_step(registration)) return;
    registration.queued = true;
    due.push_back(id);
    if (due.size() == 1) advance_soon();
  }

  void queue_all() {
    for (auto& [id, registration] : registrations.entries) queue(id, registration);
  }

  void advance_soon() {
    loop.post([weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->advance();
    });
  }

  void advance() {
    while (!closed && status.reachable && in_flight < kInFlight && !due.empty()) {
      const auto id = due.front();
      due.pop_front();
      const auto found = registrations.entries.find(id);
      if (found == registrations.entries.end()) continue;
      found->second.queued = false;
      step(id, found->second);
    }
    if (!status.reachable) forget_queue();
    if (ending && (registrations.entries.empty() || !status.reachable)) end();
  }

  void forget_queue() {
    for (auto& [id, registration] : registrations.entries) registration.queued = false;
    due.clear();
  }

  void step(RegistrationId id, Registration& registration) {
    if (registration.busy || registrations.is_busy(registration.what)) return;
    if (registration.dropped) {
      const bool known = registration.registered_pid == status.pid && registration.registered_pid != 0;
      if (known && !registrations.keeps_too(id, registration.what)) return undo(id, registration);
      registrations.entries.erase(id);
    } else if (registration.again) {
      undo(id, registration);
    } else if (registration.renew || registration.epoch != epoch) {
      make(id, registration);
    }
  }

  void queue_same_place(const Registered& what) {
    for (auto& [id, registration] : registrations.entries)
      if (registration.what.same_place(what)) queue(id, registration);
  }

  void make(RegistrationId id, Registration& registration) {
    registration.busy = true;
    registration.renew = false;
    registration.registered_pid = status.pid;
    ++in_flight;
    const auto& what = registration.what;
    raw_call(what.method(), what.arguments(params.caller_api),
             [this, id, at = epoch](Result<XmlValue> answer) {
               --in_flight;
               const auto found = registrations.entries.find(id);
               if (found != registrations.entries.end()) on_made(found->second, at, std::move(answer));
               if (!closed) advance();
             });
  }

  void on_made(Registration& registration, std::uint64_t at, Result<XmlValue> answer) {
    registration.busy = false;
    const bool silent = is_silence(answer);
    auto value = unpacked(registration.what.method(), std::move(answer));
    if (value)
      registration.epoch = at;
    else
      registration.not_before = EventLoop::now() + (silent ? 1 : kRefusedPeriods) * params.period;
    queue_same_place(registration.what);
    if (silent) return;
    const auto done = registration.done;
    const auto log = handlers.on_log;
    if (!value && log) log(value.error().message + " (" + registration.what.name + ")");
    if (!closed && done) done(std::move(value));
  }

  void undo(RegistrationId id, Registration& registration) {
    registration.busy = true;
    ++in_flight;
    const auto& what = registration.what;
    raw_call(what.undo_method(), what.undo_arguments(params.caller_api),
             [this, id](const Result<XmlValue>& answer) {
               --in_flight;
               const auto found = registrations.entries.find(id);
               if (found != registrations.entries.end()) on_undone(id, found->second, is_silence(answer));
               if (!closed) advance();
             });
  }

  void on_undone(RegistrationId id, Registration& registration, bool silent) {
    registration.busy = false;
    if (silent) {  // the next look at the master queues it again
      registration.not_before = EventLoop::now() + params.period;
      return;
    }
    registration.registered_pid = 0;
    registration.epoch = 0;
    registration.again = false;
    const auto what = registration.what;
    if (registration.dropped) registrations.entries.erase(id);
    queue_same_place(what);
  }

  void drop(RegistrationId id) {
    const auto found = registrations.entries.find(id);
    if (found == registrations.entries.end() || found->second.dropped) return;
    auto& registration = found->second;
    registration.dropped = true;
    registration.done = nullptr;
    if (registration.registered_pid == 0 && !registration.busy)
      registrations.entries.erase(found);
    else
      queue(id, registration);
  }

  void again(RegistrationId id) {
    const auto found = registrations.entries.find(id);
    if (found == registrations.entries.end() || found->second.dropped || found->second.registered_pid == 0)
      return;
    found->second.again = true;
    queue(id, found->second);
  }

  void renew(RegistrationId id) {
    const auto found = registrations.entries.find(id);
    if (found == registrations.entries.end() || found->second.dropped || found->second.registered_pid == 0)
      return;
    found->second.renew = true;
    queue(id, found->second);
  }

  // The end.

  void shut_down(std::chrono::milliseconds patience, std::function<void()> done) {
    if (ending) return;
    ending = true;
    on_end = std::move(done);
    loop.cancel(std::exchange(look_timer, 0));
    end_timer = loop.after(patience, [weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->end();
    });
    std::vector<RegistrationId> ids;
    for (const auto& [id, registration] : registrations.entries) ids.push_back(id);
    for (const auto id : ids) drop(id);
    advance_soon();
  }

  void end() {
    loop.cancel(std::exchange(end_timer, 0));
    const auto done = std::exchange(on_end, nullptr);
    if (done && !closed) done();
  }

  void close() {
    closed = true;
    loop.cancel(std::exchange(look_timer, 0));
    loop.cancel(std::exchange(end_timer, 0));
  }
};

MasterLink::MasterLink(EventLoop& loop, RpcClient& client, Params params, Handlers handlers)
    : state_(std::make_shared<State>(loop, client, std::move(params), std::move(handlers))) {
  loop.post([weak = std::weak_ptr<State>(state_)] {
    if (const auto self = weak.lock()) self->look();
  });
}

MasterLink::~MasterLink() {
  state_->close();
}

const Peer::MasterStatus& MasterLink::status() const {
  return state_->status;
}

MasterLink::RegistrationId MasterLink::keep_publisher(const std::string& topic, const std::string& type,
                                                      Done done) {
  return state_->keep({Registered::Kind::kPublisher, topic, type}, std::move(done));
}

MasterLink::RegistrationId MasterLink::keep_subscriber(const std::string& topic, const std::string& type,
                                                       Done done) {
  return state_->keep({Registered::Kind::kSubscriber, topic, type}, std::move(done));
}

MasterLink::RegistrationId MasterLink::keep_service(const std::string& service,
                                                    const std::string& service_uri, Done done) {
  return state_->keep({Registered::Kind::kService, service, service_uri}, std::move(done));
}

MasterLink::RegistrationId MasterLink::keep_param_watch(const std::string& prefix, Done done) {
  return state_->keep({Registered::Kind::kParam, prefix, {}}, std::move(done));
}

void MasterLink::drop(RegistrationId registration) {
  state_->drop(registration);
}

void MasterLink::again(RegistrationId registration) {
  state_->again(registration);
}

void MasterLink::renew(RegistrationId registration) {
  state_->renew(registration);
}

void MasterLink::call(const std::string& method, XmlArray further_arguments, Done done) {
  state_->raw_call(method, std::move(further_arguments),
                   [method, done = std::move(done)](Result<XmlValue> answer) {
                     done(State::unpacked(method, std::move(answer)));
                   });
}

void MasterLink::graph(std::function<void(Result<GraphState>)> done) {
  call("getSystemState", {}, [state = state_, done = std::move(done)](Result<XmlValue> system) {
    if (!system) return done(tl::unexpected(system.error()));
    const auto kept = std::make_shared<const XmlValue>(std::move(*system));
    state->raw_call("getTopicTypes", {}, [kept, done](Result<XmlValue> answer) {
      const auto types = State::unpacked("getTopicTypes", std::move(answer));
      if (!types) return done(tl::unexpected(types.error()));
      done(read_graph(*kept, *types));
    });
  });
}

void MasterLink::shut_down(std::chrono::milliseconds patience, std::function<void()> done) {
  state_->shut_down(patience, std::move(done));
}

}  // namespace extperfc::translate
