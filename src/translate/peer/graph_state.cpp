#include <utility>

#include "translate/peer/master_calls.hpp"

namespace extperfc::translate {
namespace {

using Names = std::vector<std::string>;

const XmlValue* element(const XmlValue& value, std::size_t index) {
  const auto* values = value.as<XmlArray>();
  return values != nullptr && index < values->size() ? &(*values)[index] : nullptr;
}

const std::string* text_at(const XmlValue& value, std::size_t index) {
  const auto* found = element(value, index);
  return found != nullptr ? found->as<std::string>() : nullptr;
}

/// Calls `use(name, nodes)` for each [name, [node, ...]]; false when something else stands there.
template <typename Use>
bool for_each_entry(const XmlValue* list, const Use& use) {
  const auto* entries = list != nullptr ? list->as<XmlArray>() : nullptr;
  if (entries == nullptr) return false;
  for (const auto& entry : *entries) {
    const auto* name = text_at(entry, 0);
    const auto* nodes = element(entry, 1);
    const auto* list_of_nodes = nodes != nullptr ? nodes->as<XmlArray>() : nullptr;
    if (name == nullptr || list_of_nodes == nullptr) return false;
    Names names;
    for (const auto& node : *list_of_nodes) {
      const auto* text = node.as<std::string>();
      if (text == nullptr) return false;
      names.push_back(*text);
    }
    use(*name, std::move(names));
  }
  return true;
}

}  // namespace

Result<GraphState> read_graph(const XmlValue& system_state, const XmlValue& topic_types) {
  GraphState graph;
  const bool whole = for_each_entry(element(system_state, 0),
                                    [&](const std::string& topic, Names nodes) {
                                      graph.topics[topic].publishers = std::move(nodes);
                                    }) &&
                     for_each_entry(element(system_state, 1),
                                    [&](const std::string& topic, Names nodes) {
                                      graph.topics[topic].subscribers = std::move(nodes);
                                    }) &&
                     for_each_entry(element(system_state, 2), [&](const std::string& service, Names nodes) {
                       graph.services[service] = std::move(nodes);
                     });
  const auto* types = topic_types.as<XmlArray>();
  if (!whole || types == nullptr)
    return fail(ErrorCode::kCorrupt,
                "the master's answer to getSystemState or getTopicTypes has an unexpected format");
  for (const auto& pair : *types) {
    const auto* topic = text_at(pair, 0);
    const auto* type = text_at(pair, 1);
    if (topic == nullptr || type == nullptr)
      return fail(ErrorCode::kCorrupt, "the master's answer to getTopicTypes has an unexpected format");
    // The master remembers types of topics that no longer exist.
    if (const auto found = graph.topics.find(*topic); found != graph.topics.end()) found->second.type = *type;
  }
  return graph;
}

Result<XmlValue> unpack_reply(const std::string& method, XmlValue reply) {
  auto* elements = std::get_if<XmlArray>(&reply.data);
  const bool whole = elements != nullptr && elements->size() >= 3;
  const auto* code = whole ? (*elements)[0].as<std::int32_t>() : nullptr;
  const auto* status = whole ? (*elements)[1].as<std::string>() : nullptr;
  if (code == nullptr || status == nullptr)
    return fail(ErrorCode::kCorrupt,
                method + ": the answer is not [code, status, value]; is this a ROS master?");
  if (*code == 1) return std::move((*elements)[2]);
  return fail(*code == -1 ? ErrorCode::kNotFound : ErrorCode::kFailed, method + ": " + *status);
}

const char* Registered::method() const {
  switch (kind) {
    case Kind::kPublisher:
      return "registerPublisher";
    case Kind::kSubscriber:
      return "registerSubscriber";
    case Kind::kService:
      return "registerService";
    case Kind::kParam:
      break;
  }
  return "subscribeParam";
}

const char* Registered::undo_method() const {
  switch (kind) {
    case Kind::kPublisher:
      return "unregisterPublisher";
    case Kind::kSubscriber:
      return "unregisterSubscriber";
    case Kind::kService:
      return "unregisterService";
    case Kind::kParam:
      break;
  }
  return "unsubscribeParam";
}

XmlArray Registered::arguments(const std::string& caller_api) const {
  if (kind == Kind::kParam) return {caller_api, name};
  return {name, detail, caller_api};
}

XmlArray Registered::undo_arguments(const std::string& caller_api) const {
  if (kind == Kind::kParam) return {caller_api, name};
  return {name, kind == Kind::kService ? detail : caller_api};
}

}  // namespace extperfc::translate
