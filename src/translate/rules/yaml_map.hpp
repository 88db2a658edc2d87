#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "translate/rules/problems.hpp"

namespace extperfc::translate::rules {

/// Line of a node in its file, from 1; 0 when it has none.
[[nodiscard]] int line_of(const YAML::Node& node);
/// The content of a node for a message: "a map", "a list of 3", the text in quotes, "nothing".
[[nodiscard]] std::string shown(const YAML::Node& node);

/// A map of keys and values with its place in the file. Reading notes what is wrong; nothing throws.
class YamlMap {
 public:
  struct Item {
    std::string key;
    YAML::Node value;
    int line{0};  ///< of the key
  };

  /// Anything but a map is a problem and is read as an empty one; so are keys that are no text, or given
  /// twice.
  YamlMap(const YAML::Node& node, std::string where, Problems& problems);

  [[nodiscard]] const std::vector<Item>& items() const { return items_; }
  [[nodiscard]] const Item* find(const std::string& key) const;
  [[nodiscard]] bool has(const std::string& key) const { return find(key) != nullptr; }
  /// A scalar's text; a problem when it is something else. Nothing when the key is absent.
  [[nodiscard]] std::optional<std::string> text(const std::string& key) const;
  /// A finite number written in the "C" way.
  [[nodiscard]] std::optional<double> number(const std::string& key) const;
  /// Notes every key that is not among `known`, with the nearest of them.
  void allow_only(const std::vector<std::string>& known) const;

  [[nodiscard]] int line() const { return line_; }
  [[nodiscard]] const std::string& where() const { return where_; }
  /// Place of a key: "forward.speed_ratio".
  [[nodiscard]] std::string where(const std::string& key) const;
  void problem(const std::string& key, const std::string& what) const;

 private:
  std::string where_;
  Problems* problems_;
  int line_{0};
  std::vector<Item> items_;
};

}  // namespace extperfc::translate::rules
