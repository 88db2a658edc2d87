#pragma once

#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/translate/rpc.hpp"

namespace extperfc::translate::test {

/// A ROS master in the test's own process: topics with publisherUpdate, services, parameters with paramUpdate
/// (the setter is notified too, as by Indigo's). Can die, come back empty under another pid, or just be away.
class SmallMaster {
 public:
  explicit SmallMaster(EventLoop& loop) : loop_(loop), resolver_(loop, {}), client_(loop, resolver_) {
    start();
  }

  void start() {
    server_ = std::make_unique<RpcServer>(loop_);
    const auto port = server_->open("127.0.0.1", port_,
                                    [this](const XmlCall& call, const std::string&) { return answer(call); });
    if (!port) throw std::runtime_error(port.error().message);
    port_ = *port;
  }
  void stop() { server_.reset(); }
  /// As after a crash: another process, that knows nothing.
  void restart_empty() {
    ++pid_;
    topics_.clear();
    services_.clear();
    params_.clear();
    start();
  }
  [[nodiscard]] std::string uri() const { return "http://127.0.0.1:" + std::to_string(port_) + "/"; }
  [[nodiscard]] bool publishes(const std::string& node, const std::string& topic) const {
    const auto found = topics_.find(topic);
    return found != topics_.end() && found->second.publishers.count(node) != 0;
  }
  [[nodiscard]] bool offers(const std::string& node, const std::string& service) const {
    const auto found = services_.find(service);
    return found != services_.end() && found->second.node == node;
  }
  [[nodiscard]] const XmlValue* param(const std::string& name) const {
    const auto found = params_.find(name);
    return found == params_.end() ? nullptr : &found->second;
  }

 private:
  struct Topic {
    std::string type;
    std::map<std::string, std::string> publishers, subscribers;  ///< node -> slave API
  };
  struct Service {
    std::string node, uri;
  };

  static XmlValue good(XmlValue value) { return XmlArray{1, "good", std::move(value)}; }
  static XmlValue bad(const char* text) { return XmlArray{-1, text, 0}; }
  static std::string text(const XmlCall& call, std::size_t at) {
    const auto* value = call.arguments.at(at).as<std::string>();
    if (value == nullptr) throw std::runtime_error("not a string");
    return *value;
  }

  static XmlArray uris(const std::map<std::string, std::string>& nodes) {
    XmlArray all;
    for (const auto& [node, uri] : nodes) all.emplace_back(uri);
    return all;
  }
  void notify_publishers(const std::string& name, const Topic& topic) {
    for (const auto& [node, uri] : topic.subscribers)
      client_.call(uri, "publisherUpdate", {"/master", name, uris(topic.publishers)}, std::chrono::seconds(3),
                   [](const Result<XmlValue>&) {});
  }
  void notify_param(const std::string& name, const XmlValue& value) {
    for (const auto& [prefix, uri] : watchers_)
      if (name == prefix || name.rfind(prefix + "/", 0) == 0)
        client_.call(uri, "paramUpdate", {"/master", name + "/", value}, std::chrono::seconds(3),
                     [](const Result<XmlValue>&) {});
  }

  XmlValue answer(const XmlCall& call) {
    const auto& method = call.method;
    if (method == "getPid") return good(pid_);
    if (method == "getSystemState") return good(state());
    if (method == "getTopicTypes") return good(types());
    if (method == "lookupNode") return lookup_node(text(call, 1));
    if (method == "lookupService") {
      const auto found = services_.find(text(call, 1));
      return found == services_.end() ? bad("no provider") : good(found->second.uri);
    }
    if (method.find("Param") != std::string::npos) return answer_param(call);
    return answer_registration(call);
  }

  XmlValue answer_registration(const XmlCall& call) {
    const auto& method = call.method;
    const auto node = text(call, 0);
    const auto name = text(call, 1);
    if (method == "registerService") return services_[name] = {node, text(call, 2)}, good(1);
    if (method == "unregisterService") return good(static_cast<std::int32_t>(services_.erase(name)));
    auto& topic = topics_[name];
    if (method == "registerPublisher" || method == "registerSubscriber") {
      const auto type = text(call, 2);
      if (topic.type.empty() || topic.type == "*") topic.type = type;
    }
    if (method == "registerPublisher") {
      topic.publishers[node] = text(call, 3);
      notify_publishers(name, topic);
      return good(uris(topic.subscribers));
    }
    if (method == "registerSubscriber") {
      topic.subscribers[node] = text(call, 3);
      return good(uris(topic.publishers));
    }
    if (method == "unregisterPublisher") {
      const auto count = topic.publishers.erase(node);
      notify_publishers(name, topic);
      return good(static_cast<std::int32_t>(count));
    }
    if (method == "unregisterSubscriber")
      return good(static_cast<std::int32_t>(topic.subscribers.erase(node)));
    return bad("unknown method");
  }

  XmlValue answer_param(const XmlCall& call) {
    const auto& method = call.method;
    if (method == "subscribeParam") {
      watchers_[text(call, 2)] = text(call, 1);
      return good(tree(text(call, 2)));
    }
    if (method == "unsubscribeParam") return good(static_cast<std::int32_t>(watchers_.erase(text(call, 2))));
    const auto name = text(call, 1);
    if (method == "setParam") {
      params_[name] = call.arguments.at(2);
      notify_param(name, params_[name]);
      return good(0);
    }
    if (method == "deleteParam") {
      params_.erase(name);
      notify_param(name, XmlStruct{});
      return good(0);
    }
    const auto value = tree(name);
    return value == XmlValue(XmlStruct{}) ? bad("not set") : good(value);
  }

  /// One level of names is enough here.
  [[nodiscard]] XmlValue tree(const std::string& prefix) const {
    if (const auto found = params_.find(prefix); found != params_.end()) return found->second;
    XmlStruct fields;
    for (const auto& [name, value] : params_)
      if (name.rfind(prefix + "/", 0) == 0) fields[name.substr(prefix.size() + 1)] = value;
    return fields;
  }

  [[nodiscard]] XmlValue state() const {
    XmlArray publishers, subscribers, services;
    const auto names = [](const std::map<std::string, std::string>& nodes) {
      XmlArray all;
      for (const auto& [node, uri] : nodes) all.emplace_back(node);
      return all;
    };
    for (const auto& [name, topic] : topics_) {
      if (!topic.publishers.empty()) publishers.emplace_back(XmlArray{name, names(topic.publishers)});
      if (!topic.subscribers.empty()) subscribers.emplace_back(XmlArray{name, names(topic.subscribers)});
    }
    for (const auto& [name, service] : services_)
      services.emplace_back(XmlArray{name, XmlArray{service.node}});
    return XmlArray{publishers, subscribers, services};
  }
  [[nodiscard]] XmlValue types() const {
    XmlArray all;
    for (const auto& [name, topic] : topics_) all.emplace_back(XmlArray{name, topic.type});
    return all;
  }
  [[nodiscard]] XmlValue lookup_node(const std::string& node) const {
    for (const auto& [name, topic] : topics_)
      for (const auto* nodes : {&topic.publishers, &topic.subscribers})
        if (const auto found = nodes->find(node); found != nodes->end()) return good(found->second);
    for (const auto& [name, service] : services_)
      if (service.node == node) return good(service.uri);
    return bad("unknown node");
  }

  EventLoop& loop_;
  Resolver resolver_;
  RpcClient client_;
  std::uint16_t port_{0};
  std::int32_t pid_{1000};
  std::unique_ptr<RpcServer> server_;
  std::map<std::string, Topic> topics_;
  std::map<std::string, Service> services_;
  std::map<std::string, XmlValue> params_;
  std::map<std::string, std::string> watchers_;
};

}  // namespace extperfc::translate::test
