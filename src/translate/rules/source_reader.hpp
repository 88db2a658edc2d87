#pragma once

#include <string>

#include <yaml-cpp/yaml.h>

#include "extperfc/translate/rules.hpp"
#include "extperfc/world/yaml_map.hpp"

#include "translate/rules/literal.hpp"
#include "translate/rules/path.hpp"

namespace extperfc::translate {

/// Reads where a target's value comes from, and checks it against the definitions of both ends.
class SourceReader {
 public:
  /// `from` is the message that paths start in; null when it is not known: then only the grammar is checked.
  SourceReader(const MessageSchema* from, Problems& problems, Budget& budget)
      : from_(from), problems_(&problems), budget_(&budget) {}

  /// The field that takes the value, in the message `owner`; both null when they are not known.
  struct Target {
    const Field* field{nullptr};
    const MessageSchema* owner{nullptr};
  };
  [[nodiscard]] Source read(const YAML::Node& node, const std::string& where, Target target, int depth = 0);

 private:
  void read_field(YamlMap& map, Target target, Source& source);
  void read_options(YamlMap& map, Target target, const PathEnd& end, Source& source);
  void read_arithmetic(YamlMap& map, const PathEnd& end, Source& source);
  void read_constants(YamlMap& map, Target target, const PathEnd& end, Source& source);
  void read_relative(YamlMap& map, const PathEnd& end, Source& source);
  void read_value(YamlMap& map, Target target, Source& source);
  void read_list(YamlMap& map, Target target, int depth, Source& source);
  void read_message(YamlMap& map, Target target, int depth, Source& source);
  /// The literal fitted to its field, or as it stands when the field is not known or it does not fit.
  [[nodiscard]] Literal literal(const YAML::Node& node, const std::string& where, Target target, int line);
  /// The path of a key and where it ends: nothing known after a problem.
  PathEnd path(const std::string& text, int line, const std::string& where, Path& path);

  const MessageSchema* from_;
  Problems* problems_;
  Budget* budget_;
};

}  // namespace extperfc::translate
