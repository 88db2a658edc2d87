#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "extperfc/translate/event_loop.hpp"
#include "extperfc/translate/rpc.hpp"

namespace extperfc::translate::testing {

/// A master in the test's own process that joins nodes as rosmaster does: it notifies subscribers of
/// publishers and watchers of parameters. It can die, and come back at the same port with another pid and no
/// memory.
class GraphMaster {
 public:
  explicit GraphMaster(EventLoop& loop)
      : loop_(loop), resolver_(loop, {}), client_(std::make_unique<RpcClient>(loop, resolver_)) {
    start();
  }

  [[nodiscard]] std::string uri() const { return "http://127.0.0.1:" + std::to_string(port_); }

  void stop() { server_.reset(); }
  void start() {
    ++pid_;
    publishers_.clear();
    subscribers_.clear();
    services_.clear();
    nodes_.clear();
    watchers_.clear();
    server_ = std::make_unique<RpcServer>(loop_);
    const auto port = server_->open("127.0.0.1", port_, [this](const XmlCall& call, const std::string&) {
      ++calls[call.method];
      return answer_topics(call);
    });
    if (!port) throw std::runtime_error(port.error().message);
    port_ = *port;
  }

  /// As if nodes had registered or left.
  void set_publishers(const std::string& topic, const std::vector<std::string>& uris) {
    publishers_[topic] = {uris.begin(), uris.end()};
    notify(topic);
  }
  void set_subscriber(const std::string& topic, const std::string& node, const std::string& uri) {
    nodes_[node] = uri;
    subscribers_[topic].insert(uri);
  }
  void remove_subscriber(const std::string& topic, const std::string& node, const std::string& uri) {
    nodes_.erase(node);
    subscribers_[topic].erase(uri);
  }
  [[nodiscard]] std::size_t publisher_count(const std::string& topic) { return publishers_[topic].size(); }
  [[nodiscard]] std::size_t subscriber_count(const std::string& topic) { return subscribers_[topic].size(); }
  /// Its URI, or "".
  [[nodiscard]] std::string service(const std::string& name) { return services_[name]; }
  void set_service(const std::string& name, const std::string& uri) { services_[name] = uri; }

  std::map<std::string, int> calls;  ///< how often each method was called
  std::map<std::string, XmlValue> params;
  bool notifies{true};  ///< false: subscribers are not notified of publishers, as when the network is away

 private:
  static XmlValue reply(std::int32_t code, XmlValue value) { return XmlArray{code, "", std::move(value)}; }
  static std::string text(const XmlCall& call, std::size_t index) {
    return *call.arguments.at(index).as<std::string>();
  }

  XmlValue answer_topics(const XmlCall& call) {
    const auto& method = call.method;
    if (method == "registerPublisher") {
      // A node that was started again takes the place of its former self.
      if (nodes_[text(call, 0)] != text(call, 3)) publishers_[text(call, 1)].erase(nodes_[text(call, 0)]);
      nodes_[text(call, 0)] = text(call, 3);
      publishers_[text(call, 1)].insert(text(call, 3));
      notify(text(call, 1));
      return reply(1, list(subscribers_[text(call, 1)]));
    }
    if (method == "unregisterPublisher") {
      publishers_[text(call, 1)].erase(text(call, 2));
      notify(text(call, 1));
      return reply(1, 1);
    }
    if (method == "registerSubscriber") {
      nodes_[text(call, 0)] = text(call, 3);
      subscribers_[text(call, 1)].insert(text(call, 3));
      return reply(1, list(publishers_[text(call, 1)]));
    }
    if (method == "unregisterSubscriber") {
      return reply(1, static_cast<std::int32_t>(subscribers_[text(call, 1)].erase(text(call, 2))));
    }
    return answer_services(call);
  }

  XmlValue answer_services(const XmlCall& call) {
    const auto& method = call.method;
    if (method == "getPid") return reply(1, pid_);
    if (method == "lookupNode") {
      const auto node = nodes_.find(text(call, 1));
      return node == nodes_.end() ? reply(-1, "") : reply(1, node->second);
    }
    if (method == "registerService") {
      nodes_[text(call, 0)] = text(call, 3);
      services_[text(call, 1)] = text(call, 2);
      return reply(1, 1);
    }
    if (method == "unregisterService") {
      return reply(1, static_cast<std::int32_t>(services_.erase(text(call, 1))));
    }
    if (method == "lookupService") {
      const auto found = services_.find(text(call, 1));
      return found == services_.end() ? reply(-1, "no provider") : reply(1, found->second);
    }
    return answer_params(call);
  }

  XmlValue answer_params(const XmlCall& call) {
    const auto& method = call.method;
    if (method == "setParam") return set_param(text(call, 1), call.arguments.at(2));
    if (method == "getParam") {
      const auto found = params.find(text(call, 1));
      return found == params.end() ? reply(-1, 0) : reply(1, found->second);
    }
    if (method == "hasParam") return reply(1, params.count(text(call, 1)) != 0);
    if (method == "deleteParam") return reply(params.erase(text(call, 1)) != 0 ? 1 : -1, 0);
    if (method == "subscribeParam") {
      nodes_[text(call, 0)] = text(call, 1);
      watchers_.insert(text(call, 1));
      const auto found = params.find(text(call, 2));
      return reply(1, found == params.end() ? XmlValue(XmlStruct{}) : found->second);
    }
    if (method == "unsubscribeParam") return reply(1, 1);
    return reply(-1, "unknown method");
  }

  /// rosmaster appends a slash to the names that it sends.
  XmlValue set_param(const std::string& name, const XmlValue& value) {
    params[name] = value;
    for (const auto& api : watchers_) call_node(api, "paramUpdate", {"/master", name + "/", value});
    return reply(1, 0);
  }

  static XmlValue list(const std::set<std::string>& uris) {
    XmlArray array;
    for (const auto& uri : uris) array.emplace_back(uri);
    return array;
  }

  void notify(const std::string& topic) {
    if (!notifies) return;
    for (const auto& api : subscribers_[topic]) {
      call_node(api, "publisherUpdate", {"/master", topic, list(publishers_[topic])});
    }
  }
  void call_node(const std::string& api, const std::string& method, XmlArray arguments) {
    client_->call(api, method, std::move(arguments), std::chrono::seconds(2), [](const Result<XmlValue>&) {});
  }

  EventLoop& loop_;
  Resolver resolver_;
  std::unique_ptr<RpcClient> client_;
  std::unique_ptr<RpcServer> server_;
  std::uint16_t port_{0};
  std::int32_t pid_{1000};
  std::map<std::string, std::set<std::string>> publishers_, subscribers_;
  std::map<std::string, std::string> services_, nodes_;
  std::set<std::string> watchers_;
};

}  // namespace extperfc::translate::testing
