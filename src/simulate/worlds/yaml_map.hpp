#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <yaml-cpp/yaml.h>

#include "extperfc/base/error.hpp"

namespace extperfc::simulate::worlds {

/// What is wrong with a world, collected so that all of it is reported at once.
class Problems {
 public:
  explicit Problems(std::string source_name) : source_name_(std::move(source_name)) {}

  /// `line` counts from 1; 0: no line to blame.
  void add(int line, const std::string& key_path, const std::string& what);
  [[nodiscard]] bool empty() const { return list_.empty(); }
  [[nodiscard]] std::size_t size() const { return list_.size(); }
  /// One line per problem in the order of the file: "lab.yaml:12: objects[3].cube.size: what: remedy".
  [[nodiscard]] Error to_error() const;

 private:
  struct Problem {
    int line;
    std::string text;
  };
  std::string source_name_;
  std::vector<Problem> list_;
};

/// Where something stands in the file, for problems that are found after reading.
struct Origin {
  int line{0};
  std::string key_path;
};

/// Bounds of a number, both included.
struct Span {
  double low;
  double high;
};
inline constexpr Span kAny{-1e4, 1e4};      ///< positions [m] and angles [deg]
inline constexpr Span kLength{1e-4, 1000};  ///< sizes [m]
inline constexpr Span kFraction{0, 1};

/// One map of a YAML file. Every read notes what is wrong, with line, key and remedy, and returns a default
/// then; a read without a fallback asks for a key that must be there. Does not throw.
class YamlMap {
 public:
  /// Anything but a map is a problem, and is read as an empty map.
  YamlMap(const YAML::Node& node, std::string path, Problems& problems);

  [[nodiscard]] bool has(const std::string& key) const;
  [[nodiscard]] double number(const std::string& key, Span span, std::optional<double> fallback = {});
  [[nodiscard]] int integer(const std::string& key, int low, int high, std::optional<int> fallback = {});
  [[nodiscard]] bool flag(const std::string& key, bool fallback);
  [[nodiscard]] std::string text(const std::string& key, const std::optional<std::string>& fallback = {});
  /// Exactly `count` numbers.
  [[nodiscard]] std::vector<double> numbers(const std::string& key, std::size_t count, Span span,
                                            const std::optional<std::vector<double>>& fallback = {});
  [[nodiscard]] Eigen::Vector2d vector2(const std::string& key, Span span,
                                        const std::optional<Eigen::Vector2d>& fallback = {});
  [[nodiscard]] Eigen::Vector3d vector3(const std::string& key, Span span,
                                        const std::optional<Eigen::Vector3d>& fallback = {});
  /// [x, y] with z = 0, or [x, y, z].
  [[nodiscard]] Eigen::Vector3d place(const std::string& key);
  /// A list of [x, y] with at least `least` of them.
  [[nodiscard]] std::vector<Eigen::Vector2d> points(const std::string& key, std::size_t min_count);
  /// The node itself, empty when the key is absent.
  [[nodiscard]] std::optional<YAML::Node> node(const std::string& key);
  /// Maps in a list; an absent list is empty.
  [[nodiscard]] std::vector<YamlMap> maps(const std::string& key);

  /// Refuses keys that were not read (with the most similar known one as a hint) and keys given twice.
  void refuse_unknown();
  /// Accepts a key that is read elsewhere.
  void expect(const std::string& key) { known_.push_back(key); }
  void problem(const std::string& key, const std::string& what);
  [[nodiscard]] int line(const std::string& key = "") const;
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] Origin origin() const { return {line(), path_}; }
  [[nodiscard]] Problems& problems() const { return *problems_; }
  [[nodiscard]] const YAML::Node& raw() const { return node_; }

 private:
  [[nodiscard]] std::optional<YAML::Node> find(const std::string& key, bool required);
  [[nodiscard]] std::optional<YAML::Node> find_list(const std::string& key, bool required);
  [[nodiscard]] std::vector<double> read_numbers(const YAML::Node& list, const std::string& key, Span span);

  YAML::Node node_;
  std::string path_;
  Problems* problems_;
  std::vector<std::string> known_;
};

/// ", did you mean ...?" when one of `known` is at most two edits away from `name`, else empty.
[[nodiscard]] std::string hint_for(const std::string& name, const std::vector<std::string>& known);

/// The content of a node for a message, shortened.
[[nodiscard]] std::string shown(const YAML::Node& node);

/// A finite number written as in the "C" locale.
[[nodiscard]] std::optional<double> as_number(const YAML::Node& node);

}  // namespace extperfc::simulate::worlds
