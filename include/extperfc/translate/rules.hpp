#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/definition_store.hpp"
#include "extperfc/translate/schema.hpp"

/// Rules for what pairing fields by name cannot know. Written in YAML (docs/translation_rules.md has the
/// grammar), one entry per pair of definitions, in terms of the target's fields: each names where its value
/// comes from.
namespace extperfc::translate {

/// A value written in a rule: a scalar's text, a list, or the fields of a message.
struct Literal {
  enum class Kind : std::uint8_t { kScalar, kList, kFields };
  Kind kind{Kind::kScalar};
  std::string scalar;
  std::vector<Literal> list;
  std::vector<std::pair<std::string, Literal>> fields;
};

/// One step of a path such as `claimed_resources[0].hardware_interface`.
struct PathStep {
  std::string field;
  std::optional<std::size_t> index;
};
using Path = std::vector<PathStep>;
[[nodiscard]] std::string to_string(const Path& path);

enum class Overflow : std::uint8_t {
  kRefuse,    ///< a value that the target cannot hold refuses the message
  kSaturate,  ///< the nearest value that it can hold
};

/// Where the value of a target field comes from.
struct Source {
  enum class Kind : std::uint8_t {
    kField,    ///< {from: path, scale, offset, map, otherwise, overflow, relative_to}
    kValue,    ///< {value: literal}
    kList,     ///< {list: [source, ...]}: an array of so many elements (join)
    kMessage,  ///< {fields: {name: source, ...}}: an embedded message, built anew
  };
  Kind kind{Kind::kField};

  // kField
  Path path;
  double scale{1.0};  ///< target = source * scale + offset, for numbers and arrays of numbers
  double offset{0.0};
  std::vector<std::pair<Literal, Literal>> map;  ///< constants: the first pair whose key is the value
  std::optional<Literal>
      otherwise;  ///< for an index beyond the end, and a value that `map` lacks (else: unchanged)
  Overflow overflow{Overflow::kRefuse};
  /// Path of a geometry_msgs/Pose in the source: each pose of the field is expressed in that pose's parent,
  /// i.e. composed (parent_T_pose * pose).
  Path relative_to;

  Literal value;                                       // kValue
  std::vector<Source> list;                            // kList
  std::vector<std::pair<std::string, Source>> fields;  // kMessage
};

/// How one definition is converted to another, in one direction.
struct MigrationRule {
  std::string from_type, from_md5;
  std::string to_type, to_md5;
  std::vector<std::pair<std::string, Source>> targets;  ///< fields of the target not named here pair by name
  std::vector<std::string> dropped;  ///< fields of the source that are dropped by a rule: no warning
  std::string origin;                ///< "file:line" for messages
};

/// Rules by pair of definitions, and the chains that they form.
class RuleSet {
 public:
  void add(MigrationRule rule);
  /// Two names of one type ("tf/tfMessage", "tf2_msgs/TFMessage") or of one package ("multimaster_msgs_fkie",
  /// "fkie_multimaster_msgs"). A rule between types of different names says it for its two types. A
  /// package is never another name of a type: such a pair is ignored.
  void add_rename(const std::string& from, const std::string& to);
  /// A definition that chains may pass through. load_rules() adds those of its rules.
  void add_schema(const SchemaPtr& schema);
  [[nodiscard]] std::size_t size() const { return rules_.size(); }
  [[nodiscard]] const std::vector<MigrationRule>& rules() const { return rules_; }

  /// The rule of exactly this pair, or null.
  [[nodiscard]] const MigrationRule* find(const MessageSchema& from, const MessageSchema& to) const;
  /// The shortest chain of rules from one to the other, two rules or more; empty if no chain exists. The
  /// schemas of the steps between come from the definitions given at load.
  struct Link {
    const MigrationRule* rule;
    SchemaPtr from, to;
  };
  [[nodiscard]] std::vector<Link> chain(const SchemaPtr& from, const SchemaPtr& to) const;
  /// Every other name of a type, in either direction and through several renames; nearest first. Empty for
  /// most.
  [[nodiscard]] std::vector<std::string> other_names(std::string_view type) const;

 private:
  using Key = std::pair<std::string, std::string>;  ///< type, MD5
  [[nodiscard]] std::vector<Link> links_to(const Key& goal,
                                           const std::map<Key, const MigrationRule*>& reached_by,
                                           const SchemaPtr& from, const SchemaPtr& to) const;

  std::vector<MigrationRule> rules_;
  std::map<Key, std::vector<std::size_t>> from_;
  std::map<Key, SchemaPtr> schemas_;
  std::vector<std::pair<std::string, std::string>> renames_;  ///< of types and of packages
};

/// Reads files, in order. A rule that does not fit its definitions (unknown type or MD5, no such field, a
/// value that its field cannot hold, types that do not convert) is refused: "file:line: reason"; all of
/// them at once.
[[nodiscard]] Result<RuleSet> load_rules(const std::vector<std::filesystem::path>& files,
                                         const DefinitionStore& definitions);
/// As load_rules(), from text; `name` stands for the file in messages.
[[nodiscard]] Result<RuleSet> parse_rules(const std::string& text, const std::string& name,
                                          const DefinitionStore& definitions);

}  // namespace extperfc::translate
