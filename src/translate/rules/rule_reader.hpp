#pragma once

#include <string>
#include <utility>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "extperfc/translate/rules.hpp"
#include "extperfc/world/yaml_map.hpp"

#include "translate/rules/literal.hpp"

namespace extperfc::translate {

/// A rule that was read, with what is needed to check it once all rules are known.
struct Draft {
  MigrationRule rule;
  SchemaPtr from, to;
  int line{0};
  bool sound{true};  ///< nothing was found wrong with it so far
};

/// Everything that one file says.
struct RuleFile {
  std::vector<Draft> drafts;
  std::vector<std::pair<std::string, std::string>> renames;
};

/// Reads the entries of one file. Every entry gives a rule each way, for each half that differs.
class RuleReader {
 public:
  RuleReader(const DefinitionStore& definitions, Problems& problems)
      : definitions_(&definitions), problems_(&problems) {}

  /// The document's root: a list of entries, or a map with `rules` and `renames`.
  [[nodiscard]] RuleFile read(const YAML::Node& root);

 private:
  /// One side of an entry.
  struct End {
    std::string type, md5;
    int line{0};
  };
  /// The keys that say what happens, of a message or of one half of a service.
  struct Pair {
    SchemaPtr from, to;  ///< null when not known
    int line{0};
  };

  void read_renames(YamlMap& root);
  void read_rules(const YAML::Node& list);
  void read_entry(const YAML::Node& node);
  void read_message_entry(YamlMap& entry);
  void read_service_entry(YamlMap& entry);
  void read_half(YamlMap& entry, const std::string& key, const Pair& pair);
  [[nodiscard]] End read_end(YamlMap& entry, const std::string& key, const std::string& type);
  void read_both_directions(YamlMap& map, const Pair& pair);
  [[nodiscard]] Draft read_one_direction(YamlMap& map, const std::string& direction, const Pair& pair);
  void read_dropped(YamlMap& map, const std::string& key, Draft& draft);
  [[nodiscard]] SchemaPtr find_message(const End& end);
  [[nodiscard]] ServicePtr find_service(const End& end);
  void report_unknown(const End& end, const std::vector<std::string>& known_md5s, bool is_service);

  const DefinitionStore* definitions_;
  Problems* problems_;
  Budget budget_;
  RuleFile file_;
};

}  // namespace extperfc::translate
