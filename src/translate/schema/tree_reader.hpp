#pragma once

#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/schema.hpp"

#include "translate/schema/package_tree.hpp"

namespace extperfc::translate {

/// Makes schemas of a tree of packages. What a definition embeds is read from the tree first, in any
/// order the files are, then asked from `elsewhere`.
class TreeReader {
 public:
  TreeReader(const PackageTree& tree, FindSchema elsewhere, const SchemaLimits& limits);

  struct Definitions {
    std::vector<SchemaPtr> messages;
    std::vector<ServicePtr> services;
    std::vector<ActionPtr> actions;
    std::vector<std::string> problems;  ///< "file: reason"
  };
  [[nodiscard]] Definitions read_all();

 private:
  SchemaPtr find(const std::string& type);
  SchemaPtr read_message(const DefinitionFile& file);
  ActionPtr read_action(const DefinitionFile& file);
  void index(const DefinitionFile& file);
  template <typename T>
  T keep(const DefinitionFile& file, Result<T> parsed);
  void report(const DefinitionFile& file, const std::string& reason);

  const PackageTree& tree_;
  FindSchema elsewhere_;
  SchemaLimits limits_;
  std::unordered_map<std::string, const DefinitionFile*>
      files_;                                            ///< of messages, and of actions by their messages
  std::unordered_map<std::string, SchemaPtr> messages_;  ///< null: does not parse, or is being read
  std::unordered_map<std::string, ActionPtr> actions_;
  std::size_t depth_{0};
  Definitions read_;
};

}  // namespace extperfc::translate
