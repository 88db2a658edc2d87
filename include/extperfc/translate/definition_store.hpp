#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "extperfc/translate/schema.hpp"

namespace extperfc::translate {

/// Every definition that is known, by type and MD5, and named sets of them ("indigo", "noetic",
/// "baxter_sdk_0.7.0"): a set has one version of each type, as a workspace has. Not thread-safe.
class DefinitionStore {
 public:
  struct Limits {
    std::size_t learned{2000};  ///< definitions from connection headers at most: strangers send them
    std::size_t learned_bytes{32U << 20U};  ///< of their texts
    SchemaLimits schema;
  };

  DefinitionStore() : DefinitionStore(Limits{}) {}
  explicit DefinitionStore(Limits limits);
  ~DefinitionStore();
  DefinitionStore(DefinitionStore&&) noexcept;
  DefinitionStore& operator=(DefinitionStore&&) noexcept;

  /// Reads a store that write_store() made: one file per definition, named by type and MD5, and
  /// sets/<name>.txt. Returns the number of definitions. A file whose content has another MD5 than its name
  /// is an error.
  [[nodiscard]] Result<std::size_t> add_store(const std::filesystem::path& folder);
  /// Reads a tree of packages (interfaces/, a workspace's src, /opt/ros/*/share, /usr/share/...): every
  /// <package>/{msg,srv,action}/*. They join the set `set`; what they embed is looked up in the tree, then in
  /// the set, then in the set `fallback`. A type that the set has already is replaced, so add the folders of
  /// a ROS_PACKAGE_PATH from its end. Files that do not parse are reported, the rest is read.
  struct TreeReport {
    std::size_t read{0};
    std::vector<std::string> problems;  ///< one line each
  };
  [[nodiscard]] Result<TreeReport> add_tree(const std::filesystem::path& folder, const std::string& set,
                                            const std::string& fallback = "");
  /// From a connection header; refused when its MD5 is not `md5` (the sender lies or is damaged). A text
  /// without the definitions that it embeds, as some client libraries send it, is completed from a set when
  /// the MD5 fits. Beyond the limits the schema is returned, but not kept.
  [[nodiscard]] Result<SchemaPtr> learn(const std::string& type, const std::string& md5,
                                        std::string_view full_text);

  /// Messages are those with a file of their own, those of actions, and the halves of services
  /// ("package/NameRequest"). Of several layouts with one MD5 the first that was added.
  [[nodiscard]] SchemaPtr find_message(std::string_view type, std::string_view md5) const;
  [[nodiscard]] ServicePtr find_service(std::string_view type, std::string_view md5) const;
  /// The version that a set has; null when it has none.
  [[nodiscard]] SchemaPtr message_of_set(std::string_view set, std::string_view type) const;
  [[nodiscard]] ServicePtr service_of_set(std::string_view set, std::string_view type) const;
  [[nodiscard]] ActionPtr action_of_set(std::string_view set, std::string_view type) const;
  /// All versions of a type, in the order they were added.
  [[nodiscard]] std::vector<SchemaPtr> messages(std::string_view type) const;
  [[nodiscard]] std::vector<ServicePtr> services(std::string_view type) const;

  [[nodiscard]] std::vector<std::string> sets() const;
  struct SetContent {
    std::vector<std::string> messages, services, actions;  ///< types, sorted; messages include derived ones
  };
  [[nodiscard]] SetContent content(std::string_view set) const;
  /// Names of the sets that have exactly this version, e.g. {"indigo", "noetic"}; for messages to people.
  [[nodiscard]] std::vector<std::string> sets_with(std::string_view type, std::string_view md5) const;

  /// Writes everything but what was learned, for add_store().
  [[nodiscard]] Result<void> write_store(const std::filesystem::path& folder) const;

 private:
  [[nodiscard]] SchemaPtr find_without_embedded(const std::string& type, const std::string& md5,
                                                std::string_view text) const;

  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace extperfc::translate
