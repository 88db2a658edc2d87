#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <yaml-cpp/yaml.h>

#include "extperfc/base/problems.hpp"

namespace extperfc {

/// Bounds of a number, both included.
struct Span {
  double low;
  double high;
};
inline constexpr Span kFinite{std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max()};
inline constexpr Span kFraction{0, 1};

/// How many items a list may have.
struct Count {
  // NOLINTNEXTLINE(google-explicit-constructor): a list of 3 numbers
  Count(std::size_t exact) : min(exact), max(exact) {}
  Count(std::size_t at_least, std::size_t at_most) : min(at_least), max(at_most) {}
  std::size_t min;
  std::size_t max;
};
inline constexpr std::size_t kAnyNumber = std::numeric_limits<std::size_t>::max();

/// The document in `text`; empty after noting (kCorrupt) why it is not YAML.
[[nodiscard]] std::optional<YAML::Node> parse_yaml(const std::string& text, Problems& problems);
/// The document in a file; empty after noting why it cannot be read (kNotFound) or is not YAML (kCorrupt).
[[nodiscard]] std::optional<YAML::Node> load_yaml(const std::filesystem::path& file, Problems& problems);

/// Line of a node in its file, from 1; 0 when it has none.
[[nodiscard]] int line_of(const YAML::Node& node);
/// The content of a node for a message: "a map", "a list of 3", the text in quotes, "nothing".
[[nodiscard]] std::string shown(const YAML::Node& node);

/// One map of a YAML file. Every read notes what is wrong, with line, key and remedy, and returns a default
/// then; a read without a fallback asks for a key that must be there. Does not throw.
class YamlMap {
 public:
  struct Item {
    std::string key;
    YAML::Node value;
    int line{0};  ///< of the key
  };

  /// Anything but a map is a problem and is read as an empty one; so are keys that are no text, or given
  /// twice.
  YamlMap(const YAML::Node& node, std::string path, Problems& problems);

  [[nodiscard]] std::optional<double> find_number(const std::string& key, Span span = kFinite);
  [[nodiscard]] double number(const std::string& key, Span span, std::optional<double> fallback = {});
  [[nodiscard]] int integer(const std::string& key, int low, int high, std::optional<int> fallback = {});
  /// true, false, 0 or 1.
  [[nodiscard]] bool flag(const std::string& key, std::optional<bool> fallback = {});
  [[nodiscard]] std::optional<std::string> find_text(const std::string& key);
  [[nodiscard]] std::string text(const std::string& key, const std::optional<std::string>& fallback = {});
  /// Index among `names` of the text.
  [[nodiscard]] std::size_t choice(const std::string& key, const std::vector<std::string>& names,
                                   std::size_t fallback = 0);
  [[nodiscard]] std::vector<double> numbers(const std::string& key, Count count, Span span,
                                            const std::optional<std::vector<double>>& fallback = {});
  [[nodiscard]] Eigen::Vector2d vector2(const std::string& key, Span span,
                                        const std::optional<Eigen::Vector2d>& fallback = {});
  [[nodiscard]] Eigen::Vector3d vector3(const std::string& key, Span span,
                                        const std::optional<Eigen::Vector3d>& fallback = {});
  /// A list of lists of `columns` numbers, without those that are wrong.
  [[nodiscard]] std::vector<std::vector<double>> rows(const std::string& key, std::size_t columns, Span span,
                                                      std::size_t min_rows = 1);
  /// A list of texts that is not empty; an absent one is only a problem when `required`.
  [[nodiscard]] std::vector<std::string> texts(const std::string& key, bool required = true);
  /// A map below this one; an absent one is empty, and only a problem when `required`.
  [[nodiscard]] YamlMap section(const std::string& key, bool required = false);
  /// Maps in a list; an absent list is empty.
  [[nodiscard]] std::vector<YamlMap> maps(const std::string& key, std::size_t min_count = 0);
  /// The node itself, empty when the key is absent.
  [[nodiscard]] std::optional<YAML::Node> node(const std::string& key);

  [[nodiscard]] const std::vector<Item>& items() const { return items_; }
  [[nodiscard]] const Item* find(const std::string& key) const;
  [[nodiscard]] bool has(const std::string& key) const { return find(key) != nullptr; }
  [[nodiscard]] bool is_list(const std::string& key) const;
  /// Whether this key has been read, there or not.
  [[nodiscard]] bool asked_for(const std::string& key) const;
  /// Accepts a key that is read elsewhere.
  void expect(const std::string& key) { known_.push_back(key); }
  /// Refuses `key`, if it is there, for a reason better than "unknown".
  void refuse(const std::string& key, const std::string& reason);
  /// Refuses keys that were not read.
  void refuse_unknown() const { allow_only(known_); }
  /// Refuses keys that are not among `known`, and names the nearest of them or all.
  void allow_only(const std::vector<std::string>& known) const;

  void problem(const std::string& key, const std::string& what) const;
  void problem(const std::string& key, const std::string& what, ErrorCode code) const;
  /// Line of a key, or of the map.
  [[nodiscard]] int line(const std::string& key = "") const;
  [[nodiscard]] const std::string& path() const { return path_; }
  /// "objects[3].size".
  [[nodiscard]] std::string path(const std::string& key) const;
  [[nodiscard]] Problems& problems() const { return *problems_; }

 private:
  [[nodiscard]] const YAML::Node* read(const std::string& key, bool required);
  [[nodiscard]] const YAML::Node* read_list(const std::string& key, bool required);
  [[nodiscard]] double number_in(const YAML::Node& node, const std::string& key, Span span) const;
  [[nodiscard]] std::vector<double> numbers_in(const YAML::Node& list, const std::string& key,
                                               Span span) const;

  std::string path_;
  Problems* problems_;
  int line_{0};
  bool is_map_;  ///< what is missing is reported
  std::vector<Item> items_;
  std::vector<std::string> known_;
};

}  // namespace extperfc
