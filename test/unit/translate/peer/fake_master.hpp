#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/translate/rpc.hpp"

namespace extperfc::translate {

/// A master in the test's own process: remembers who registered what, may lose it, and counts calls.
class FakeMaster {
 public:
  explicit FakeMaster(EventLoop& loop) : loop_(loop) { start(); }

  /// At the same port as before, if there was one.
  void start() {
    server_ = std::make_unique<RpcServer>(loop_);
    const auto port = server_->open("127.0.0.1", port_,
                                    [this](const XmlCall& call, const std::string&) { return answer(call); });
    if (!port) throw std::runtime_error(port.error().message);
    port_ = *port;
  }
  void stop() { server_.reset(); }
  void forget() { registered.clear(); }

  [[nodiscard]] std::string uri() const { return "http://127.0.0.1:" + std::to_string(port_) + "/"; }
  /// E.g. has("registerPublisher", "/chatter").
  [[nodiscard]] bool has(const std::string& method, const std::string& name) const {
    return registered.count({method, name}) != 0;
  }
  [[nodiscard]] int calls(const std::string& method) const {
    return static_cast<int>(
        std::count_if(log.begin(), log.end(), [&](const auto& call) { return call.method == method; }));
  }

  std::int32_t pid{1000};
  std::set<std::pair<std::string, std::string>> registered;
  std::map<std::string, XmlArray> publishers;  ///< what registerSubscriber answers
  std::set<std::string> refused;               ///< names that are answered with code -1
  std::set<std::string> faulty;                ///< methods that fail
  std::vector<XmlCall> log;
  XmlValue system_state{XmlArray{XmlArray{}, XmlArray{}, XmlArray{}}};
  XmlValue topic_types{XmlArray{}};

 private:
  static XmlValue good(XmlValue value) { return XmlArray{1, "good", std::move(value)}; }

  XmlValue answer(const XmlCall& call) {
    log.push_back(call);
    if (faulty.count(call.method) != 0) throw std::runtime_error("faulty");
    if (call.method == "getPid") return good(pid);
    if (call.method == "getSystemState") return good(system_state);
    if (call.method == "getTopicTypes") return good(topic_types);
    if (call.method == "lookupNode")
      return registered.empty() ? XmlValue(XmlArray{-1, "unknown node", ""}) : good("http://127.0.0.1:1/");
    const bool is_param = call.method == "subscribeParam" || call.method == "unsubscribeParam";
    const auto name = *call.arguments.at(is_param ? 2 : 1).as<std::string>();
    if (refused.count(name) != 0) return XmlArray{-1, "not that one", 0};
    if (call.method.rfind("un", 0) == 0) {
      const auto made = call.method == "unsubscribeParam" ? "subscribeParam" : call.method.substr(2);
      return good(static_cast<std::int32_t>(registered.erase({made, name})));
    }
    registered.emplace(call.method, name);
    if (call.method == "registerSubscriber") return good(publishers[name]);
    return call.method == "subscribeParam" ? good(XmlStruct{}) : good(1);
  }

  EventLoop& loop_;
  std::uint16_t port_{0};
  std::unique_ptr<RpcServer> server_;
};

}  // namespace extperfc::translate
