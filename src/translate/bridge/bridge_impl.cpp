#include "translate/bridge/bridge_impl.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace extperfc::translate {

namespace {

// A publisher that is started again within this time finds its route, and its listeners, still there.
constexpr auto kGrace = std::chrono::seconds(3);

std::size_t index(Side side) {
  return static_cast<std::size_t>(side);
}

}  // namespace

BridgeImpl::BridgeImpl(EventLoop& loop, BridgeParams params, DefinitionStore definitions, RuleSet rules,
                       Handlers handlers, BridgeSelector selector, Profiles profiles)
    : loop_(loop),
      params_(std::move(params)),
      definitions_(std::move(definitions)),
      plans_(definitions_, std::move(rules)),
      handlers_(std::move(handlers)),
      selector_(std::move(selector)),
      profiles_(std::move(profiles)),
      context_{loop_,
               frames_,
               params_,
               plans_,
               {},
               [this](const std::string& line) {
                 if (handlers_.on_log) handlers_.on_log(line);
               },
               [this](const std::string& line) { report_once(line); },
               [this](Side from) { return clock_ ? clock_->shift_ns(from) : 0; }} {}

BridgeImpl::~BridgeImpl() {
  loop_.cancel(timer_);
}

Result<void> BridgeImpl::open() {
  resolver_ = std::make_unique<Resolver>(loop_, params_.sides[index(Side::kRobot)].peer.hosts,
                                         params_.sides[index(Side::kRobot)].peer.hosts_remedy);
  for (const auto side : {Side::kRobot, Side::kWorkstation})
    if (auto opened = open_side(side); !opened) return opened;
  clock_ = std::make_unique<ClockMonitor>(context_, *resolver_);
  for (const auto& prefix : params_.params_robot_to_workstation)
    param_routes_.emplace_back(Side::kRobot,
                               std::make_unique<ParamRoute>(context_, written_, prefix, Side::kRobot));
  for (const auto& prefix : params_.params_workstation_to_robot)
    param_routes_.emplace_back(Side::kWorkstation,
                               std::make_unique<ParamRoute>(context_, written_, prefix, Side::kWorkstation));
  timer_ = loop_.after(std::chrono::nanoseconds(0), [this] { poll(); });
  return {};
}

Result<void> BridgeImpl::open_side(Side side) {
  Peer::Handlers handlers;
  const std::string label = std::string(to_string(side)) + " side: ";
  handlers.on_master = [this, side](const Peer::MasterStatus& status) { on_master(side, status); };
  handlers.on_log = [this, label](const std::string& line) { context_.log(label + line); };
  handlers.on_shutdown = [this] {
    if (handlers_.on_shutdown) handlers_.on_shutdown();
  };
  auto peer = Peer::make(loop_, frames_, params_.sides[index(side)].peer, std::move(handlers));
  if (!peer) return fail(peer.error().code, label + peer.error().message);
  peers_[index(side)] = std::move(*peer);
  context_.peers[index(side)] = peers_[index(side)].get();
  return {};
}

void BridgeImpl::on_master(Side side, const Peer::MasterStatus& status) {
  const std::string label = std::string(to_string(side)) + " side: the master ";
  if (!status.reachable) {  // each time, not once
    if (handlers_.on_problem) handlers_.on_problem(label + "is not reachable: " + status.problem);
    return;
  }
  if (std::exchange(restarts_[index(side)], status.restarts) == status.restarts) return;
  context_.log(label + "restarted");
  for (auto& [from, route] : param_routes_)
    if (other(from) == side) route->write_again();
}

void BridgeImpl::schedule() {
  if (closing_) return;
  const auto period = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double>(params_.poll_period_s));
  loop_.cancel(timer_);
  timer_ = loop_.after(period, [this] { poll(); });
}

void BridgeImpl::poll() {
  answers_awaited_ = 2;
  for (const auto side : {Side::kRobot, Side::kWorkstation})
    peers_[index(side)]->graph([this, side, alive = std::weak_ptr<bool>(alive_)](Result<GraphState> graph) {
      if (!alive.expired()) on_graph(side, std::move(graph));
    });
}

/// A master that does not answer leaves its side as it was: connections outlive masters.
void BridgeImpl::on_graph(Side side, Result<GraphState> graph) {
  if (graph) {
    graphs_[index(side)] = std::move(*graph);
    known_[index(side)] = true;
  }
  if (--answers_awaited_ > 0 || closing_) return;
  update_topics();
  update_services();
  const auto now = EventLoop::now();
  for (auto& [key, held] : topics_) held.route->measure(now);
  schedule();
}

void BridgeImpl::update_topics() {
  const auto bridged = selector_.topics(graphs_);
  close_routes(bridged);
  open_routes(bridged);
}

void BridgeImpl::close_routes(const BridgedTopics& bridged) {
  const auto now = EventLoop::now();
  for (auto held = topics_.begin(); held != topics_.end();) {
    const auto& [topic, from] = held->first;
    const bool wanted = bridged.count(held->first) != 0;
    const bool stays = wanted || !peers_[index(from)]->master().reachable || held->second.route->alive();
    if (stays) held->second.missing_since = now;
    held = now - held->second.missing_since > kGrace ? topics_.erase(held) : std::next(held);
  }
}

void BridgeImpl::open_routes(const BridgedTopics& bridged) {
  for (const auto& [key, entry] : bridged) {
    const auto& [topic, from] = key;
    const auto held = topics_.find(key);
    if (held != topics_.end()) {
      const auto& present = held->second.route->params();
      if (present.eager == entry.eager && present.action == entry.action) {
        held->second.route->update(entry.listeners, publishers_of(topic, from));
        continue;
      }
      topics_.erase(held);  // it became part of an action, or ceased to be
    }
    TopicRoute::Params params;
    params.topic = topic;
    params.type = entry.type.empty() ? "*" : entry.type;
    params.from = from;
    params.profile = profiles_.of(topic);
    params.action = entry.action;
    params.eager = entry.eager;
    auto route = std::make_unique<TopicRoute>(context_, std::move(params));
    route->update(entry.listeners, publishers_of(topic, from));
    topics_[key] = {std::move(route), EventLoop::now()};
  }
}

/// As the master lists them now, ourselves left out.
std::size_t BridgeImpl::publishers_of(const std::string& topic, Side from) const {
  const auto& topics = graphs_[index(from)].topics;
  const auto found = topics.find(topic);
  if (found == topics.end()) return 0;
  const auto& nodes = found->second.publishers;
  const auto own = std::count(nodes.begin(), nodes.end(), params_.sides[index(from)].peer.name);
  return nodes.size() - static_cast<std::size_t>(own);
}

void BridgeImpl::update_services() {
  const auto bridged = selector_.services(graphs_);
  for (auto held = services_.begin(); held != services_.end();) {
    const auto wanted = bridged.find(held->first);
    const bool stays = wanted != bridged.end() && wanted->second == held->second.first;
    held = stays ? std::next(held) : services_.erase(held);
  }
  for (const auto& [name, from] : bridged) {
    const auto& providers = graphs_[index(from)].services[name];
    auto& route = services_[name];
    if (!route.second) {
      route = {from, std::make_unique<ServiceRoute>(context_, name, from)};
    } else if (providers_[name] != providers) {
      route.second->forget_server();
    }
    providers_[name] = providers;
  }
}

void BridgeImpl::report_once(const std::string& problem) {
  if (reported_.size() >= kMaxReported) reported_.clear();
  if (reported_.insert(problem).second && handlers_.on_problem) handlers_.on_problem(problem);
}

void BridgeImpl::replace_rules(RuleSet rules) {
  plans_.replace_rules(std::move(rules));
  reported_.clear();
  for (auto& [key, held] : topics_) held.route->restart();
  for (auto& [name, held] : services_) held = {held.first, nullptr};
  update_services();
}

BridgeStatus BridgeImpl::status() {
  BridgeStatus status;
  for (const auto side : {Side::kRobot, Side::kWorkstation}) {
    auto& one = status.sides[index(side)];
    const auto& peer = *peers_[index(side)];
    one.master_uri = peer.params().master_uri;
    one.uri = peer.uri();
    one.reachable = peer.master().reachable;
    one.restarts = peer.master().restarts;
    one.problem = peer.master().problem;
  }
  for (const auto& [key, held] : topics_) {
    status.topics.push_back(held.route->status());
    ++status.sides[index(key.second)].topics;
  }
  for (const auto& [name, held] : services_) {
    status.services.push_back(held.second->status());
    ++status.sides[index(held.first)].services;
  }
  for (const auto& [from, route] : param_routes_) status.params += route->count();
  if (clock_) status.clock = clock_->status();
  return status;
}

void BridgeImpl::shut_down(std::chrono::milliseconds patience, std::function<void()> done) {
  closing_ = true;
  loop_.cancel(timer_);
  param_routes_.clear();
  topics_.clear();
  services_.clear();
  clock_.reset();
  const auto left = std::make_shared<int>(2);
  for (const auto& peer : peers_)
    peer->shut_down(patience, [left, done] {
      if (--*left == 0 && done) done();
    });
}

}  // namespace extperfc::translate
