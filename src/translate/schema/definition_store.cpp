#include "extperfc/translate/definition_store.hpp"

#include <utility>

#include "translate/schema/catalogue.hpp"
#include "translate/schema/package_tree.hpp"
#include "translate/schema/store_files.hpp"
#include "translate/schema/tree_reader.hpp"

namespace extperfc::translate {
namespace {

template <typename T>
std::vector<std::string> names_of(const std::map<std::string, T, std::less<>>& map) {
  std::vector<std::string> names;
  names.reserve(map.size());
  for (const auto& [name, value] : map) names.push_back(name);
  return names;
}

template <typename T>
T find_in(const std::map<std::string, T, std::less<>>& map, std::string_view type) {
  const auto found = map.find(type);
  return found == map.end() ? nullptr : found->second;
}

}  // namespace

struct DefinitionStore::Content {
  Limits limits;
  Catalogue catalogue;
  std::size_t learned{0}, learned_bytes{0};
};

DefinitionStore::DefinitionStore(Limits limits) : content_(std::make_unique<Content>()) {
  content_->limits = limits;
}
DefinitionStore::~DefinitionStore() = default;
DefinitionStore::DefinitionStore(DefinitionStore&&) noexcept = default;
DefinitionStore& DefinitionStore::operator=(DefinitionStore&&) noexcept = default;

Result<std::size_t> DefinitionStore::add_store(const std::filesystem::path& folder) {
  return read_store(folder, content_->limits.schema, content_->catalogue);
}

Result<DefinitionStore::TreeReport> DefinitionStore::add_tree(const std::filesystem::path& folder,
                                                              const std::string& set,
                                                              const std::string& fallback) {
  const auto tree = find_packages(folder);
  if (!tree) return tl::unexpected(tree.error());
  const auto elsewhere = [&](const std::string& type) {
    auto found = message_of_set(set, type);
    return found ? found : message_of_set(fallback, type);
  };
  auto read = TreeReader(*tree, elsewhere, content_->limits.schema).read_all();
  auto& catalogue = content_->catalogue;
  // Messages come last: a workspace's own file of a derived message is what it uses.
  for (const auto& action : read.actions) catalogue.put(set, catalogue.add(action));
  for (const auto& service : read.services) catalogue.put(set, catalogue.add(service));
  for (const auto& message : read.messages) catalogue.put(set, catalogue.add(message, Origin::kOwn));
  return TreeReport{read.messages.size() + read.services.size() + read.actions.size(),
                    std::move(read.problems)};
}

Result<SchemaPtr> DefinitionStore::learn(const std::string& type, const std::string& md5,
                                         std::string_view full_text) {
  const auto& limits = content_->limits;
  auto schema = parse_full_text(type, full_text, limits.schema);
  if (schema && (*schema)->md5() != md5)
    return fail(ErrorCode::kCorrupt, type + ": the definition on the connection has the MD5 " +
                                         (*schema)->md5() + ", but it is announced as " + md5.substr(0, 32));
  if (!schema)
    if (auto found = find_without_embedded(type, md5, full_text)) schema = std::move(found);
  if (!schema) return schema;
  if (const auto* known = content_->catalogue.find_equal(*schema)) return known->schema;
  // Beyond the limits a definition is known to the caller alone.
  if (content_->learned >= limits.learned ||
      content_->learned_bytes + full_text.size() > limits.learned_bytes)
    return schema;
  ++content_->learned;
  content_->learned_bytes += full_text.size();
  return content_->catalogue.add(*schema, Origin::kLearned);
}

SchemaPtr DefinitionStore::find_without_embedded(const std::string& type, const std::string& md5,
                                                 std::string_view text) const {
  for (const auto& [name, set] : content_->catalogue.sets()) {
    const auto find = [&known = set](const std::string& wanted) { return translate::find_in(known, wanted); };
    const auto found = parse_message(type, text, find, content_->limits.schema);
    if (found && (*found)->md5() == md5) return *found;
  }
  return nullptr;
}

SchemaPtr DefinitionStore::find_message(std::string_view type, std::string_view md5) const {
  const auto* found = content_->catalogue.find_message(type, md5);
  return found == nullptr ? nullptr : found->schema;
}
ServicePtr DefinitionStore::find_service(std::string_view type, std::string_view md5) const {
  const auto* found = content_->catalogue.find_service(type, md5);
  return found == nullptr ? nullptr : found->schema;
}

SchemaPtr DefinitionStore::message_of_set(std::string_view set, std::string_view type) const {
  const auto* found = content_->catalogue.find_set(set);
  return found == nullptr ? nullptr : translate::find_in(*found, type);
}
ServicePtr DefinitionStore::service_of_set(std::string_view set, std::string_view type) const {
  const auto* found = content_->catalogue.find_set(set);
  return found == nullptr ? nullptr : find_in(found->services, type);
}
ActionPtr DefinitionStore::action_of_set(std::string_view set, std::string_view type) const {
  const auto* found = content_->catalogue.find_set(set);
  return found == nullptr ? nullptr : find_in(found->actions, type);
}

std::vector<SchemaPtr> DefinitionStore::messages(std::string_view type) const {
  std::vector<SchemaPtr> found;
  const auto& all = content_->catalogue.messages();
  if (const auto versions = all.find(type); versions != all.end())
    for (const auto& version : versions->second) found.push_back(version.schema);
  return found;
}
std::vector<ServicePtr> DefinitionStore::services(std::string_view type) const {
  std::vector<ServicePtr> found;
  const auto& all = content_->catalogue.services();
  if (const auto versions = all.find(type); versions != all.end())
    for (const auto& version : versions->second) found.push_back(version.schema);
  return found;
}

std::vector<std::string> DefinitionStore::sets() const {
  return names_of(content_->catalogue.sets());
}

DefinitionStore::SetContent DefinitionStore::content(std::string_view set) const {
  const auto* found = content_->catalogue.find_set(set);
  if (found == nullptr) return {};
  return {names_of(found->messages), names_of(found->services), names_of(found->actions)};
}

std::vector<std::string> DefinitionStore::sets_with(std::string_view type, std::string_view md5) const {
  std::vector<std::string> found;
  for (const auto& [name, set] : content_->catalogue.sets()) {
    const auto message = translate::find_in(set, type);
    const auto service = find_in(set.services, type);
    const auto action = find_in(set.actions, type);
    if ((message && message->md5() == md5) || (service && service->md5 == md5) ||
        (action && action->action->md5() == md5))
      found.push_back(name);
  }
  return found;
}

Result<void> DefinitionStore::write_store(const std::filesystem::path& folder) const {
  return write_store_files(folder, content_->catalogue);
}

}  // namespace extperfc::translate
