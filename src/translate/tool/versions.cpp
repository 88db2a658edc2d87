#include "versions.hpp"

#include <algorithm>
#include <set>

#include "sources.hpp"

namespace extperfc::translate::tool {
namespace {

bool is_md5_start(const std::string& text) {
  constexpr std::size_t kFewest = 6;
  constexpr std::size_t kMost = 32;
  return text.size() >= kFewest && text.size() <= kMost &&
         text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

/// Of each kind in a set.
std::map<std::string, Version> versions_in(const DefinitionStore& store, const std::string& set,
                                           const std::string& type) {
  std::map<std::string, Version> found;
  if (auto schema = store.message_of_set(set, type)) found["msg"] = version_of(std::move(schema));
  if (auto schema = store.service_of_set(set, type)) found["srv"] = version_of(std::move(schema));
  if (auto schema = store.action_of_set(set, type)) found["action"] = version_of(std::move(schema));
  return found;
}

std::string known_versions(const DefinitionStore& store, const std::string& type) {
  std::set<std::string> lines;
  for (const auto& set : store.sets())
    for (const auto& [kind, version] : versions_in(store, set, type))
      lines.insert(kind + " " + version.md5 + " (" + joined(store.sets_with(type, version.md5)) + ")");
  if (lines.empty()) return "no set has the type " + type;
  return "there are: " + joined({lines.begin(), lines.end()}, "; ");
}

}  // namespace

Version version_of(SchemaPtr schema) {
  Version version;
  version.md5 = schema->md5();
  version.message = std::move(schema);
  return version;
}
Version version_of(ServicePtr schema) {
  Version version;
  version.md5 = schema->md5;
  version.service = std::move(schema);
  return version;
}
Version version_of(ActionPtr schema) {
  Version version;
  version.md5 = schema->action->md5();
  version.action = std::move(schema);
  return version;
}

Side side_of_set(const DefinitionStore& store, const std::string& set) {
  Side side;
  const auto content = store.content(set);
  for (const auto& type : content.messages)
    side[{type, "msg"}] = {version_of(store.message_of_set(set, type))};
  for (const auto& type : content.services)
    side[{type, "srv"}] = {version_of(store.service_of_set(set, type))};
  for (const auto& type : content.actions)
    side[{type, "action"}] = {version_of(store.action_of_set(set, type))};
  return side;
}

namespace {

tl::unexpected<Error> ambiguous(const DefinitionStore& store, const std::string& type,
                                const std::string& start) {
  return fail(ErrorCode::kInvalidArgument,
              start + " is the start of several MD5s of " + type + "; " + known_versions(store, type));
}

}  // namespace

Result<std::map<std::string, Version>> find_versions(const DefinitionStore& store, const std::string& type,
                                                     const std::string& which) {
  const auto sets = store.sets();
  const bool is_set = std::find(sets.begin(), sets.end(), which) != sets.end();
  if (!is_set && !is_md5_start(which))
    return fail(ErrorCode::kInvalidArgument,
                "'" + which + "' is neither a set (" + joined(sets) + ") nor an MD5 (six digits or more)");
  std::map<std::string, Version> found;
  for (const auto& set : sets) {
    if (is_set && set != which) continue;
    for (auto& [kind, version] : versions_in(store, set, type)) {
      if (!is_set && version.md5.compare(0, which.size(), which) != 0) continue;
      const auto [known, is_new] = found.emplace(kind, version);
      if (!is_new && known->second.md5 != version.md5) return ambiguous(store, type, which);
    }
  }
  if (found.empty())
    return fail(ErrorCode::kNotFound, type + " has no version " + which + "; " + known_versions(store, type));
  return found;
}

}  // namespace extperfc::translate::tool
