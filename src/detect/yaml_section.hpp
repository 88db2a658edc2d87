#pragma once

#include <optional>
#include <string>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "extperfc/base/error.hpp"

namespace extperfc::detect {

/// What is wrong with a model description, collected so that all of it is reported at once.
class Problems {
 public:
  void add(ErrorCode code, std::string text) { list_.push_back({code, std::move(text)}); }
  [[nodiscard]] bool empty() const { return list_.empty(); }
  /// All texts in one line after `where`; the code is that of the first problem.
  [[nodiscard]] Error to_error(const std::string& where) const;

 private:
  std::vector<Error> list_;
};

template <typename T>
struct Range {
  T low;
  T high;
};

/// One map of a YAML file. Every read notes what is wrong, with the full key and the remedy, and returns a
/// default then; a read without a fallback asks for a key that must be there. Does not throw.
class YamlSection {
 public:
  YamlSection(const YAML::Node& node, std::string path, Problems& problems);

  [[nodiscard]] std::string text(const std::string& key, const std::optional<std::string>& fallback = {});
  [[nodiscard]] bool flag(const std::string& key, bool fallback);
  [[nodiscard]] int integer(const std::string& key, Range<int> range, std::optional<int> fallback = {});
  [[nodiscard]] float number(const std::string& key, Range<float> range, std::optional<float> fallback = {});
  /// Exactly `count` numbers; a single number stands for all of them when `spread` is set.
  [[nodiscard]] std::vector<float> numbers(const std::string& key, std::size_t count, Range<float> range,
                                           const std::optional<std::vector<float>>& fallback = {},
                                           bool spread = false);
  /// A list of numbers of any length, empty when the key is absent.
  [[nodiscard]] std::vector<float> number_list(const std::string& key, Range<float> range);
  /// A list of rows of `count` numbers.
  [[nodiscard]] std::vector<std::vector<float>> rows(const std::string& key, std::size_t count,
                                                     Range<float> range);
  [[nodiscard]] std::vector<std::string> texts(const std::string& key, bool required = true);
  /// A map below this one; an absent one is an error only when `required`.
  [[nodiscard]] YamlSection section(const std::string& key, bool required);
  /// A list of maps.
  [[nodiscard]] std::vector<YamlSection> sections(const std::string& key);

  [[nodiscard]] bool has(const std::string& key) const;
  [[nodiscard]] bool is_list(const std::string& key) const;
  /// Whether this key has been read, there or not.
  [[nodiscard]] bool asked_for(const std::string& key) const;
  /// Refuses `key`, if it is there, for a reason better than "unknown".
  void refuse(const std::string& key, const std::string& reason);
  /// Refuses every key that was not read, with the most similar known key as a hint, and keys given
  /// twice.
  void refuse_unknown();
  void problem(const std::string& key, const std::string& what, ErrorCode code = ErrorCode::kInvalidArgument);

 private:
  /// The node of a key; notes a problem when it is `required` and absent.
  [[nodiscard]] std::optional<YAML::Node> find(const std::string& key, bool required);
  [[nodiscard]] std::optional<YAML::Node> find_list(const std::string& key, bool required);
  [[nodiscard]] std::vector<float> read_numbers(const YAML::Node& list, const std::string& key,
                                                Range<float> range);
  [[nodiscard]] std::string full(const std::string& key) const;

  YAML::Node node_;
  std::string path_;
  Problems* problems_;
  std::vector<std::string> known_;
};

}  // namespace extperfc::detect
