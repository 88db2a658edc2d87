#include "translate/tool/live_master.hpp"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include <unistd.h>

#include "extperfc/translate/event_loop.hpp"
#include "extperfc/translate/frame.hpp"
#include "extperfc/translate/peer.hpp"

namespace extperfc::translate {
namespace {

constexpr std::size_t kAtOnce = 100;  ///< topics and services that are asked at the same time

/// Every roscpp node has these, and they never changed.
bool is_logger_service(const std::string& name) {
  for (const std::string end : {"/get_loggers", "/set_logger_level"})
    if (name.size() > end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0) return true;
  return false;
}

/// Asks the nodes of one master, on a separate event loop.
class MasterReader {
 public:
  MasterReader(DefinitionStore& store, std::string hint) : store_(store), hint_(std::move(hint)) {}

  Result<TypeSet> read(const std::string& uri, std::chrono::milliseconds patience) {
    deadline_ = EventLoop::now() + patience;
    PeerParams params;
    params.name = "/extperfc_translate_check_" + std::to_string(getpid());
    params.master_uri = uri;
    params.master_timeout = std::min(params.master_timeout, patience);
    auto peer = Peer::make(loop_, frames_, params, {});
    if (!peer) return tl::unexpected(peer.error());
    peer_ = std::move(*peer);
    if (auto read = read_graph(uri); !read) return tl::unexpected(read.error());
    ask_topics();
    ask_services();
    bool gone = false;
    peer_->shut_down(std::chrono::milliseconds(1'000), [&] { gone = true; });
    while (!gone) loop_.run_once(std::chrono::milliseconds(100));
    return std::move(side_);
  }

 private:
  Result<void> read_graph(const std::string& uri) {
    bool done = false;
    Result<void> result = fail(ErrorCode::kFailed, uri + ": the master does not answer");
    peer_->graph([&](Result<GraphState> graph) {
      done = true;
      if (!graph) {
        result = tl::unexpected(graph.error());
        return;
      }
      graph_ = std::move(*graph);
      result = {};
    });
    wait([&] { return done; });
    return result;
  }

  template <typename Condition>
  void wait(const Condition& condition) {
    while (!condition() && EventLoop::now() < deadline_) loop_.run_once(std::chrono::milliseconds(50));
  }

  // ---- topics ----

  struct Asked {
    std::unique_ptr<Subscription> subscription;
    std::size_t publishers{0};
    std::set<std::string> answered;  ///< URIs
  };

  void ask_topics() {
    std::vector<std::string> published;
    for (const auto& [name, topic] : graph_.topics)
      if (!topic.publishers.empty()) published.push_back(name);
    for (std::size_t first = 0; first < published.size(); first += kAtOnce) {
      std::vector<std::unique_ptr<Asked>> batch;
      for (auto i = first; i < std::min(published.size(), first + kAtOnce); ++i)
        batch.push_back(ask(published[i]));
      wait([&] {
        return std::all_of(batch.begin(), batch.end(),
                           [](const auto& asked) { return asked->answered.size() >= asked->publishers; });
      });
    }
    for (const auto& [name, topic] : graph_.topics)
      if (answered_.count(name) == 0 && topic.type != "*") guess(topic.type, "msg", name);
  }

  std::unique_ptr<Asked> ask(const std::string& topic) {
    auto asked = std::make_unique<Asked>();
    asked->publishers = graph_.topics.at(topic).publishers.size();
    auto* state = asked.get();
    Subscription::Handlers handlers;
    handlers.on_up = [this, state, topic](const PublisherLink& link) {
      state->answered.insert(link.uri);
      on_publisher(topic, link.header);
      return false;  // that was all
    };
    handlers.on_message = [](const PublisherLink&, const FramePtr&, SteadyTime) {};
    handlers.on_down = [](const PublisherLink&, const std::string&) {};
    handlers.on_gone = [state](const PublisherLink& link) { state->answered.insert(link.uri); };
    handlers.on_problem = [state](const std::string& uri, const std::string&) {
      state->answered.insert(uri);
    };
    asked->subscription = peer_->subscribe(topic, std::move(handlers), {});
    return asked;
  }

  void on_publisher(const std::string& topic, const ConnectionHeader& header) {
    const auto type = value_of(header, "type");
    const auto md5 = value_of(header, "md5sum");
    TypeDefinition definition;
    definition.md5 = md5;
    if (auto learned = store_.learn(type, md5, value_of(header, "message_definition")))
      definition.message = *learned;
    else
      definition.message = store_.find_message(type, md5);
    answered_.insert(topic);
    add({type, "msg"}, std::move(definition), topic);
  }

  // ---- services ----

  void ask_services() {
    std::vector<std::string> names;
    for (const auto& [name, providers] : graph_.services)
      if (!is_logger_service(name)) names.push_back(name);
    for (std::size_t first = 0; first < names.size(); first += kAtOnce) {
      const auto last = std::min(names.size(), first + kAtOnce);
      auto left = std::make_shared<std::size_t>(last - first);
      for (auto i = first; i < last; ++i) {
        const auto name = names[i];
        peer_->open_service(name, "*", true, [this, name, left](Result<std::shared_ptr<ServiceLink>> link) {
          --*left;
          if (link) on_service(name, (*link)->header());
        });
      }
      wait([&] { return *left == 0; });
    }
  }

  void on_service(const std::string& name, const ConnectionHeader& header) {
    const auto type = value_of(header, "type");
    TypeDefinition definition;
    definition.md5 = value_of(header, "md5sum");
    definition.service = store_.find_service(type, definition.md5);
    add({type, "srv"}, std::move(definition), "service " + name);
  }

  // ---- both ----

  void add(const TypeId& id, TypeDefinition definition, const std::string& where) {
    auto& definitions = side_[id];
    for (auto& known : definitions) {
      if (known.md5 != definition.md5 || known.message != definition.message) continue;
      if (known.where.find(where) == std::string::npos) known.where += ", " + where;
      return;
    }
    definition.where = where;
    definitions.push_back(std::move(definition));
  }

  /// The MD5 is unknown: uses the definition in the side's set, if one was given.
  void guess(const std::string& type, const std::string& kind, const std::string& topic) {
    if (const auto known = side_.find({type, kind});
        known != side_.end() && !known->second.front().md5.empty())
      return;
    auto schema = store_.message_of_set(hint_, type);
    add({type, kind}, schema ? definition_of(std::move(schema)) : TypeDefinition(),
        topic + " (subscribed only)");
  }

  DefinitionStore& store_;
  std::string hint_;
  EventLoop loop_;
  FramePool frames_;
  SteadyTime deadline_;
  GraphState graph_;
  std::set<std::string> answered_;
  TypeSet side_;
  std::unique_ptr<Peer> peer_;  ///< last: it uses what stands above
};

}  // namespace

Result<TypeSet> read_master(DefinitionStore& store, const std::string& uri, const std::string& hint,
                            std::chrono::milliseconds patience) {
  return MasterReader(store, hint).read(uri, patience);
}

}  // namespace extperfc::translate
