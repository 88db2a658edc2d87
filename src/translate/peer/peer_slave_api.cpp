#include <algorithm>
#include <array>
#include <cstdint>
#include <set>

#include <unistd.h>

#include "translate/peer/peer_core.hpp"
#include "translate/peer/publication.hpp"
#include "translate/peer/service_server.hpp"
#include "translate/peer/subscription.hpp"

/// What the master and other nodes ask of us. Source: http://wiki.ros.org/ROS/Slave_API.
namespace extperfc::translate {
namespace {

XmlValue answer(std::int32_t code, const std::string& status, XmlValue value) {
  return XmlArray{code, status, std::move(value)};
}

XmlValue success(XmlValue value) {
  return answer(1, "", std::move(value));
}

XmlValue refusal(const std::string& why) {
  return answer(-1, why, 0);
}

const std::string* text_at(const XmlCall& call, std::size_t index) {
  return index < call.arguments.size() ? call.arguments[index].as<std::string>() : nullptr;
}

std::int32_t number(std::uint64_t value) {
  return static_cast<std::int32_t>(std::min<std::uint64_t>(value, 0x7fffffff));
}

/// Names without the slash at the end that rosmaster appends to parameters.
std::string without_trailing_slashes(std::string name) {
  while (name.size() > 1 && name.back() == '/') name.pop_back();
  return name;
}

bool within(const std::string& name, const std::string& prefix) {
  return prefix == "/" || name == prefix ||
         (name.size() > prefix.size() && name.compare(0, prefix.size(), prefix) == 0 &&
          name[prefix.size()] == '/');
}

bool speaks_tcpros(const XmlValue& protocols) {
  const auto* list = protocols.as<XmlArray>();
  if (list == nullptr) return false;
  return std::any_of(list->begin(), list->end(), [](const XmlValue& entry) {
    const auto* protocol = entry.as<XmlArray>();
    const auto* name =
        protocol != nullptr && !protocol->empty() ? protocol->front().as<std::string>() : nullptr;
    return name != nullptr && *name == "TCPROS";
  });
}

XmlValue request_topic(PeerCore& core, const XmlCall& call) {
  const auto* topic = text_at(call, 1);
  if (topic == nullptr || call.arguments.size() < 3)
    return refusal("requestTopic takes caller id, topic, protocols");
  if (newest(core.publications, *topic) == nullptr) {
    return answer(0, "Not a publisher of [" + *topic + "]", 0);
  }
  if (!speaks_tcpros(call.arguments[2])) return answer(0, "no protocol in common: only TCPROS", 0);
  const auto host = core.params.advertised_host.empty() ? core.host : core.params.advertised_host;
  return answer(1, "ready on " + host, XmlArray{"TCPROS", host, std::int32_t{core.tcpros_port}});
}

XmlValue publisher_update(PeerCore& core, const XmlCall& call) {
  const auto* topic = text_at(call, 1);
  if (topic == nullptr || call.arguments.size() < 3)
    return refusal("publisherUpdate takes caller id, topic, publishers");
  // The answer does not wait: the master sends the next update only after it.
  core.loop.post([weak = core.weak_from_this(), topic = *topic, uris = uris_in(call.arguments[2])] {
    const auto self = weak.lock();
    if (!self || self->closed) return;
    std::vector<std::shared_ptr<SubscriptionState>> states;
    const auto range = self->subscriptions.equal_range(topic);
    for (auto at = range.first; at != range.second; ++at) states.push_back(at->second->shared_from_this());
    for (const auto& state : states) state->update(uris);
  });
  return success(0);
}

XmlValue param_update(PeerCore& core, const XmlCall& call) {
  const auto* key = text_at(call, 1);
  if (key == nullptr || call.arguments.size() < 3) return refusal("paramUpdate takes caller id, name, value");
  core.loop.post(
      [weak = core.weak_from_this(), name = without_trailing_slashes(*key), value = call.arguments[2]] {
        const auto self = weak.lock();
        if (!self || self->closed) return;
        const auto watches = self->param_watches;
        for (const auto& watch : watches) {
          if (within(name, watch->prefix) || within(watch->prefix, name)) watch->on_change(name, value);
        }
      });
  return success(0);
}

std::vector<BusLink> all_links(const PeerCore& core) {
  std::vector<BusLink> rows;
  const auto append = [&rows](std::vector<BusLink> more) {
    rows.insert(rows.end(), more.begin(), more.end());
  };
  for (const auto& [topic, state] : core.publications) append(state->bus());
  for (const auto& [topic, state] : core.subscriptions) append(state->bus());
  return rows;
}

XmlValue bus_info(const PeerCore& core) {
  XmlArray rows;
  for (const auto& link : all_links(core)) {
    const auto* arrow = link.outbound ? " to " : " from ";
    rows.emplace_back(XmlArray{
        number(link.id), link.other, link.outbound ? "o" : "i", "TCPROS", link.topic, true,
        "TCPROS connection on port " + std::to_string(core.tcpros_port) + arrow + "[" + link.other + "]"});
  }
  return rows;
}

XmlValue bus_stats(const PeerCore& core) {
  XmlArray published;
  XmlArray subscribed;
  for (const auto& link : all_links(core)) {
    const auto bytes = number(link.stats.bytes);
    const auto messages = number(link.stats.messages);
    if (link.outbound) {
      published.emplace_back(
          XmlArray{link.topic, bytes, XmlArray{XmlArray{number(link.id), bytes, messages, true}}});
    } else {
      subscribed.emplace_back(
          XmlArray{link.topic, XmlArray{XmlArray{number(link.id), bytes, messages, -1, true}}});
    }
  }
  return XmlArray{std::move(published), std::move(subscribed), XmlArray{0, 0, 0}};
}

template <typename Map>
XmlValue names_in(const Map& map) {
  XmlArray rows;
  std::set<std::string> seen;
  for (const auto& [name, state] : map) {
    if (seen.insert(name).second) rows.emplace_back(XmlArray{name, state->type()});
  }
  return rows;
}

XmlValue shutdown(PeerCore& core, const XmlCall& call) {
  const auto* reason = text_at(call, 1);
  core.log(core.params.master_uri + " or a node there asks " + core.params.name + " to shut down" +
           (reason != nullptr ? " (" + *reason + ")" : ""));
  core.loop.post([weak = core.weak_from_this()] {  // after the answer
    const auto self = weak.lock();
    if (self && !self->closed && self->handlers.on_shutdown) self->handlers.on_shutdown();
  });
  return success(0);
}

using Method = XmlValue (*)(PeerCore&, const XmlCall&);
struct Entry {
  const char* name;
  Method method;
};

constexpr std::array<Entry, 11> kMethods{{
    {"requestTopic", request_topic},
    {"publisherUpdate", publisher_update},
    {"paramUpdate", param_update},
    {"getPid", [](PeerCore&, const XmlCall&) { return success(static_cast<std::int32_t>(::getpid())); }},
    {"getBusInfo", [](PeerCore& core, const XmlCall&) { return success(bus_info(core)); }},
    {"getBusStats", [](PeerCore& core, const XmlCall&) { return success(bus_stats(core)); }},
    {"getPublications", [](PeerCore& core, const XmlCall&) { return success(names_in(core.publications)); }},
    {"getSubscriptions",
     [](PeerCore& core, const XmlCall&) { return success(names_in(core.subscriptions)); }},
    {"getMasterUri", [](PeerCore& core, const XmlCall&) { return success(core.params.master_uri); }},
    {"getName", [](PeerCore& core, const XmlCall&) { return success(core.params.name); }},
    {"shutdown", shutdown},
}};

}  // namespace

XmlValue answer_slave_call(PeerCore& core, const XmlCall& call, const std::string& from) {
  for (const auto& entry : kMethods) {
    if (call.method == entry.name) return entry.method(core, call);
  }
  return refusal("method [" + call.method + "] called from [" + from + "] not found");
}

}  // namespace extperfc::translate
