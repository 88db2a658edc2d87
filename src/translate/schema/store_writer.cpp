#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/base/atomic_file.hpp"

#include "translate/schema/store_files.hpp"

namespace extperfc::translate {
namespace {

namespace fs = std::filesystem;

class StoreWriter {
 public:
  StoreWriter(fs::path folder, const Catalogue& catalogue)
      : folder_(std::move(folder)), catalogue_(catalogue) {}

  Result<void> write() {
    for (const auto& [name, set] : catalogue_.sets())
      if (auto done = write_set(name, set); !done) return done;
    for (const auto& [type, versions] : catalogue_.messages())
      for (const auto& version : versions)
        if (version.origin == Origin::kOwn)
          if (auto done = write_message(*version.schema); !done) return done;
    for (const auto& [type, versions] : catalogue_.services())
      for (const auto& version : versions)
        if (auto done = write_service(version); !done) return done;
    for (const auto& [type, versions] : catalogue_.actions())
      for (const auto& version : versions)
        if (auto done = write_action(version); !done) return done;
    return {};
  }

 private:
  using Embeds = std::map<std::string, std::string>;  ///< type -> key

  Result<void> write_set(const std::string& name, const DefinitionSet& set) {
    std::set<SchemaPtr> derived;
    std::map<std::pair<std::string, std::string>, std::string> lines;  // by type and kind
    for (const auto& [type, action] : set.actions) {
      for (const auto& message : messages_of(*action)) derived.insert(message);
      lines[{type, "action"}] = key_in(catalogue_.actions(), type, action);
    }
    for (const auto& [type, service] : set.services)
      lines[{type, "srv"}] = key_in(catalogue_.services(), type, service);
    for (const auto& [type, message] : set.messages)
      if (derived.count(message) == 0) lines[{type, "msg"}] = catalogue_.key_of(*message);
    std::string text;
    for (const auto& [id, key] : lines) text += id.first + " " + id.second + " " + key + "\n";
    return write_text_atomically(folder_ / "sets" / (name + ".txt"), text);
  }

  template <typename T, typename Ptr>
  static std::string key_in(const Catalogue::Versions<T>& all, const std::string& type, const Ptr& schema) {
    if (const auto versions = all.find(type); versions != all.end())
      for (const auto& version : versions->second)
        if (version.schema == schema) return version.key;
    return "missing";
  }

  /// Writes a message once, and what it embeds, which may be a message of an action.
  Result<void> write_message(const MessageSchema& schema) {
    const auto key = catalogue_.key_of(schema);
    if (!written_.insert({schema.type(), key}).second) return {};
    Embeds embeds;
    if (auto done = embed(schema, embeds); !done) return done;
    return write_definition(schema.type(), key, "msg", embeds, schema.text());
  }

  Result<void> embed(const MessageSchema& schema, Embeds& embeds) {
    for (const auto& field : schema.fields()) {
      if (!field.message) continue;
      embeds[field.message->type()] = catalogue_.key_of(*field.message);
      if (auto done = write_message(*field.message); !done) return done;
    }
    return {};
  }

  Result<void> write_service(const Catalogue::Service& service) {
    Embeds embeds;
    for (const auto* half : {service.schema->request.get(), service.schema->response.get()})
      if (auto done = embed(*half, embeds); !done) return done;
    return write_definition(service.schema->type, service.key, "srv", embeds,
                            service.schema->request->text() + "---\n" + service.schema->response->text());
  }

  Result<void> write_action(const Catalogue::Action& action) {
    const auto& parts = *action.schema;
    Embeds embeds;
    for (const auto* part : {parts.goal.get(), parts.result.get(), parts.feedback.get()})
      if (auto done = embed(*part, embeds); !done) return done;
    // The derived messages embed the header and the two of actionlib besides the action's own.
    for (const auto* part : {parts.action_goal.get(), parts.action_result.get()})
      for (const auto& field : part->fields()) {
        if (field.message == parts.goal || field.message == parts.result) continue;
        embeds[field.message->type()] = catalogue_.key_of(*field.message);
        if (auto done = write_message(*field.message); !done) return done;
      }
    return write_definition(
        parts.type, action.key, "action", embeds,
        parts.goal->text() + "---\n" + parts.result->text() + "---\n" + parts.feedback->text());
  }

  [[nodiscard]] Result<void> write_definition(const std::string& type, const std::string& key,
                                              const char* kind, const Embeds& embeds,
                                              const std::string& content) const {
    std::string text;
    for (const auto& [embedded, embedded_key] : embeds)
      text.append("# embeds ").append(embedded).append(" ").append(embedded_key).append("\n");
    return write_text_atomically(folder_ / (type + "." + key + "." + kind), text + content);
  }

  fs::path folder_;
  const Catalogue& catalogue_;
  std::set<std::pair<std::string, std::string>> written_;
};

}  // namespace

Result<void> write_store_files(const fs::path& folder, const Catalogue& catalogue) {
  return StoreWriter(folder, catalogue).write();
}

}  // namespace extperfc::translate
