#include "translate/schema/catalogue.hpp"

#include <algorithm>
#include <utility>

namespace extperfc::translate {
namespace {

bool same_definition(const SchemaPtr& a, const SchemaPtr& b) {
  return a->md5() == b->md5() && same_layout(*a, *b);
}
bool same_definition(const ServicePtr& a, const ServicePtr& b) {
  return a->md5 == b->md5 && same_layout(*a->request, *b->request) && same_layout(*a->response, *b->response);
}
bool same_definition(const ActionPtr& a, const ActionPtr& b) {
  return same_definition(a->action, b->action);
}

const std::string& md5_of(const SchemaPtr& schema) {
  return schema->md5();
}
const std::string& md5_of(const ServicePtr& schema) {
  return schema->md5;
}
const std::string& md5_of(const ActionPtr& schema) {
  return schema->action->md5();
}

/// The version that equals `schema`, null when there is none.
template <typename T, typename Ptr>
T* equal_of(std::vector<T>& versions, const Ptr& schema) {
  const auto found = std::find_if(versions.begin(), versions.end(),
                                  [&](const T& version) { return same_definition(version.schema, schema); });
  return found == versions.end() ? nullptr : &*found;
}

template <typename T, typename Ptr>
std::string new_key(const std::vector<T>& versions, const Ptr& schema) {
  const auto& md5 = md5_of(schema);
  const auto same_md5 = std::count_if(versions.begin(), versions.end(),
                                      [&](const T& version) { return md5_of(version.schema) == md5; });
  return same_md5 == 0 ? md5 : md5 + "-" + std::to_string(same_md5 + 1);
}

template <typename T>
const T* find_key(const Catalogue::Versions<T>& all, std::string_view type, std::string_view key) {
  const auto versions = all.find(type);
  if (versions == all.end()) return nullptr;
  for (const auto& version : versions->second)
    if (version.key == key) return &version;
  return nullptr;
}

}  // namespace

SchemaPtr Catalogue::add(const SchemaPtr& schema, Origin origin) {
  auto& versions = messages_[schema->type()];
  if (auto* known = equal_of(versions, schema)) {
    known->origin = std::max(known->origin, origin);
    return known->schema;
  }
  versions.push_back({schema, new_key(versions, schema), origin});
  return schema;
}

ServicePtr Catalogue::add(const ServicePtr& schema) {
  auto& versions = services_[schema->type];
  if (const auto* known = equal_of(versions, schema)) return known->schema;
  versions.push_back({schema, new_key(versions, schema)});
  add(schema->request, Origin::kHalf);
  add(schema->response, Origin::kHalf);
  return schema;
}

ActionPtr Catalogue::add(const ActionPtr& schema) {
  auto& versions = actions_[schema->type];
  if (const auto* known = equal_of(versions, schema)) return known->schema;
  versions.push_back({schema, new_key(versions, schema)});
  for (const auto& message : messages_of(*schema)) add(message, Origin::kDerived);
  return schema;
}

void Catalogue::put(const std::string& set, const SchemaPtr& schema) {
  sets_[set].messages[schema->type()] = schema;
}
void Catalogue::put(const std::string& set, const ServicePtr& schema) {
  sets_[set].services[schema->type] = schema;
}
void Catalogue::put(const std::string& set, const ActionPtr& schema) {
  auto& target = sets_[set];
  target.actions[schema->type] = schema;
  for (const auto& message : messages_of(*schema)) target.messages[message->type()] = message;
}

const Catalogue::Message* Catalogue::find_message(std::string_view type, std::string_view key) const {
  return find_key(messages_, type, key);
}
const Catalogue::Service* Catalogue::find_service(std::string_view type, std::string_view key) const {
  return find_key(services_, type, key);
}
const Catalogue::Action* Catalogue::find_action(std::string_view type, std::string_view key) const {
  return find_key(actions_, type, key);
}

const DefinitionSet* Catalogue::find_set(std::string_view set) const {
  const auto found = sets_.find(set);
  return found == sets_.end() ? nullptr : &found->second;
}

const Catalogue::Message* Catalogue::find_equal(const SchemaPtr& schema) const {
  const auto versions = messages_.find(schema->type());
  if (versions == messages_.end()) return nullptr;
  for (const auto& version : versions->second)
    if (same_definition(version.schema, schema)) return &version;
  return nullptr;
}

std::string Catalogue::key_of(const MessageSchema& schema) const {
  const auto versions = messages_.find(schema.type());
  if (versions != messages_.end())
    for (const auto& version : versions->second)
      if (version.schema->md5() == schema.md5() && same_layout(*version.schema, schema)) return version.key;
  return schema.md5();
}

std::vector<SchemaPtr> messages_of(const ActionSchema& action) {
  return {action.goal,          action.result,          action.feedback, action.action_goal,
          action.action_result, action.action_feedback, action.action};
}

SchemaPtr find_in(const DefinitionSet& set, std::string_view type) {
  if (const auto found = set.messages.find(type); found != set.messages.end()) return found->second;
  for (const std::string_view half : {"Request", "Response"}) {
    if (type.size() <= half.size() || type.substr(type.size() - half.size()) != half) continue;
    const auto service = set.services.find(type.substr(0, type.size() - half.size()));
    if (service != set.services.end())
      return half == "Request" ? service->second->request : service->second->response;
  }
  return nullptr;
}

}  // namespace extperfc::translate
