#include "translate/tool/type_definitions.hpp"

#include <algorithm>
#include <set>

#include "extperfc/base/text.hpp"

#include "translate/tool/sources.hpp"

namespace extperfc::translate {
namespace {

bool is_md5_start(const std::string& text) {
  constexpr std::size_t kMin = 6;
  constexpr std::size_t kMax = 32;
  return text.size() >= kMin && text.size() <= kMax &&
         text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

/// Of each kind in a set.
std::map<std::string, TypeDefinition> definitions_in(const DefinitionStore& store, const std::string& set,
                                                     const std::string& type) {
  std::map<std::string, TypeDefinition> found;
  if (auto schema = store.message_of_set(set, type)) found["msg"] = definition_of(std::move(schema));
  if (auto schema = store.service_of_set(set, type)) found["srv"] = definition_of(std::move(schema));
  if (auto schema = store.action_of_set(set, type)) found["action"] = definition_of(std::move(schema));
  return found;
}

std::string known_versions(const DefinitionStore& store, const std::string& type) {
  std::set<std::string> lines;
  for (const auto& set : store.sets())
    for (const auto& [kind, definition] : definitions_in(store, set, type))
      lines.insert(kind + " " + definition.md5 + " (" + joined(store.sets_with(type, definition.md5)) + ")");
  if (lines.empty()) return "no set has the type " + type;
  return "there are: " + joined({lines.begin(), lines.end()}, "; ");
}

}  // namespace

TypeDefinition definition_of(SchemaPtr schema) {
  TypeDefinition definition;
  definition.md5 = schema->md5();
  definition.message = std::move(schema);
  return definition;
}
TypeDefinition definition_of(ServicePtr schema) {
  TypeDefinition definition;
  definition.md5 = schema->md5;
  definition.service = std::move(schema);
  return definition;
}
TypeDefinition definition_of(ActionPtr schema) {
  TypeDefinition definition;
  definition.md5 = schema->action->md5();
  definition.action = std::move(schema);
  return definition;
}

TypeSet types_of_set(const DefinitionStore& store, const std::string& set) {
  TypeSet side;
  const auto content = store.content(set);
  for (const auto& type : content.messages)
    side[{type, "msg"}] = {definition_of(store.message_of_set(set, type))};
  for (const auto& type : content.services)
    side[{type, "srv"}] = {definition_of(store.service_of_set(set, type))};
  for (const auto& type : content.actions)
    side[{type, "action"}] = {definition_of(store.action_of_set(set, type))};
  return side;
}

namespace {

tl::unexpected<Error> ambiguous(const DefinitionStore& store, const std::string& type,
                                const std::string& start) {
  return fail(ErrorCode::kInvalidArgument,
              start + " is the start of several MD5s of " + type + "; " + known_versions(store, type));
}

}  // namespace

Result<std::map<std::string, TypeDefinition>> find_definitions(const DefinitionStore& store,
                                                               const std::string& type,
                                                               const std::string& which) {
  const auto sets = store.sets();
  const bool is_set = std::find(sets.begin(), sets.end(), which) != sets.end();
  if (!is_set && !is_md5_start(which))
    return fail(ErrorCode::kInvalidArgument,
                "'" + which + "' is neither a set (" + joined(sets) + ") nor an MD5 (six digits or more)");
  std::map<std::string, TypeDefinition> found;
  for (const auto& set : sets) {
    if (is_set && set != which) continue;
    for (auto& [kind, definition] : definitions_in(store, set, type)) {
      if (!is_set && definition.md5.compare(0, which.size(), which) != 0) continue;
      const auto [known, is_new] = found.emplace(kind, definition);
      if (!is_new && known->second.md5 != definition.md5) return ambiguous(store, type, which);
    }
  }
  if (found.empty())
    return fail(ErrorCode::kNotFound, type + " has no version " + which + "; " + known_versions(store, type));
  return found;
}

}  // namespace extperfc::translate
