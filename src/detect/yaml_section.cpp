#include "detect/yaml_section.hpp"

#include <algorithm>
#include <sstream>
#include <utility>

#include "extperfc/base/edit_distance.hpp"

namespace extperfc::detect {

namespace {

constexpr std::size_t kLongestHint = 2;  // edits between an unknown key and the known one that is suggested

std::string hint_for(const std::string& key, const std::vector<std::string>& known) {
  const auto nearest = std::min_element(known.begin(), known.end(), [&key](const auto& a, const auto& b) {
    return edit_distance(key, a) < edit_distance(key, b);
  });
  if (nearest == known.end() || edit_distance(key, *nearest) > kLongestHint) return "";
  return ", did you mean \"" + *nearest + "\"?";
}

template <typename T>
std::optional<T> decoded(const YAML::Node& node) {
  T value{};
  if (!node.IsScalar() || !YAML::convert<T>::decode(node, value)) return std::nullopt;
  return value;
}

/// The content of a node for a message, shortened.
std::string shown(const YAML::Node& node) {
  if (!node.IsScalar()) return node.IsNull() ? "nothing" : node.IsMap() ? "a map" : "a list";
  const std::string& text = node.Scalar();
  return '"' + (text.size() > 40 ? text.substr(0, 37) + "..." : text) + '"';
}

template <typename T>
std::string range_text(Range<T> range) {
  std::ostringstream out;
  out << '[' << range.low << ", " << range.high << ']';
  return out.str();
}

// Written so that NaN is outside.
template <typename T>
bool inside(T value, Range<T> range) {
  return value >= range.low && value <= range.high;
}

}  // namespace

Error Problems::to_error(const std::string& where) const {
  std::string message = where + ": ";
  for (const Error& problem : list_) message += (&problem == list_.data() ? "" : "; ") + problem.message;
  return {list_.empty() ? ErrorCode::kFailed : list_.front().code, message};
}

YamlSection::YamlSection(const YAML::Node& node, std::string path, Problems& problems)
    : node_(node), path_(std::move(path)), problems_(&problems) {
  if (node_.IsMap()) return;
  problems_->add(ErrorCode::kInvalidArgument, (path_.empty() ? "the file" : path_) +
                                                  " must be a map of keys and values, not " + shown(node_));
  node_ = YAML::Node(YAML::NodeType::Map);
}

std::string YamlSection::text(const std::string& key, const std::optional<std::string>& fallback) {
  const auto node = find(key, !fallback);
  if (!node) return fallback.value_or("");
  const auto value = decoded<std::string>(*node);
  if (!value || (value->empty() && !fallback)) problem(key, "must be text, not " + shown(*node));
  return value.value_or("");
}

bool YamlSection::flag(const std::string& key, bool fallback) {
  const auto node = find(key, false);
  if (!node) return fallback;
  const auto value = decoded<bool>(*node);
  if (!value) problem(key, "must be true or false, not " + shown(*node));
  return value.value_or(fallback);
}

int YamlSection::integer(const std::string& key, Range<int> range, std::optional<int> fallback) {
  const auto node = find(key, !fallback);
  if (!node) return fallback.value_or(range.low);
  const auto value = decoded<int>(*node);
  if (value && inside(*value, range)) return *value;
  problem(key, "must be a whole number in " + range_text(range) + ", not " + shown(*node));
  return range.low;
}

float YamlSection::number(const std::string& key, Range<float> range, std::optional<float> fallback) {
  const auto node = find(key, !fallback);
  if (!node) return fallback.value_or(range.low);
  const auto value = decoded<float>(*node);
  if (value && inside(*value, range)) return *value;
  problem(key, "must be a number in " + range_text(range) + ", not " + shown(*node));
  return range.low;
}

std::vector<float> YamlSection::numbers(const std::string& key, std::size_t count, Range<float> range,
                                        const std::optional<std::vector<float>>& fallback, bool spread) {
  std::vector<float> otherwise = fallback.value_or(std::vector<float>(count, range.low));
  if (spread && has(key) && !is_list(key)) return std::vector<float>(count, number(key, range));
  const auto list = find_list(key, !fallback);
  if (!list) return otherwise;
  if (list->size() == count) return read_numbers(*list, key, range);
  problem(key, "must have " + std::to_string(count) + " numbers, not " + std::to_string(list->size()));
  return otherwise;
}

std::vector<float> YamlSection::number_list(const std::string& key, Range<float> range) {
  const auto list = find_list(key, false);
  return list ? read_numbers(*list, key, range) : std::vector<float>{};
}

std::vector<std::vector<float>> YamlSection::rows(const std::string& key, std::size_t count,
                                                  Range<float> range) {
  std::vector<std::vector<float>> result;
  const auto list = find_list(key, true);
  for (std::size_t i = 0; list && i < list->size(); ++i) {
    const YAML::Node row = (*list)[i];
    const std::string row_key = key + "[" + std::to_string(i) + "]";
    if (row.IsSequence() && row.size() == count)
      result.push_back(read_numbers(row, row_key, range));
    else
      problem(row_key, "must be a list of " + std::to_string(count) + " numbers");
  }
  if (list && list->size() == 0) problem(key, "is empty: list at least one");
  return result;
}

std::vector<std::string> YamlSection::texts(const std::string& key, bool required) {
  std::vector<std::string> result;
  const auto list = find_list(key, required);
  for (std::size_t i = 0; list && i < list->size(); ++i) {
    const auto value = decoded<std::string>((*list)[i]);
    if (!value || value->empty()) problem(key + "[" + std::to_string(i) + "]", "must be text");
    result.push_back(value.value_or(""));
  }
  if (list && result.empty()) problem(key, "is empty: list at least one");
  return result;
}

YamlSection YamlSection::section(const std::string& key, bool required) {
  const auto node = find(key, required);
  return {node.value_or(YAML::Node(YAML::NodeType::Map)), full(key), *problems_};
}

std::vector<YamlSection> YamlSection::sections(const std::string& key) {
  std::vector<YamlSection> result;
  const auto list = find_list(key, true);
  for (std::size_t i = 0; list && i < list->size(); ++i)
    result.emplace_back((*list)[i], full(key) + "[" + std::to_string(i) + "]", *problems_);
  if (list && result.empty()) problem(key, "is empty: list at least one");
  return result;
}

bool YamlSection::has(const std::string& key) const {
  return std::as_const(node_)[key].IsDefined();
}

bool YamlSection::is_list(const std::string& key) const {
  return has(key) && std::as_const(node_)[key].IsSequence();
}

bool YamlSection::asked_for(const std::string& key) const {
  return std::find(known_.begin(), known_.end(), key) != known_.end();
}

void YamlSection::refuse(const std::string& key, const std::string& reason) {
  if (find(key, false)) problem(key, reason);
}

void YamlSection::refuse_unknown() {
  std::vector<std::string> seen;
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "(a key that is not text)";
    if (!asked_for(key)) problem(key, "unknown key" + hint_for(key, known_));
    if (std::find(seen.begin(), seen.end(), key) != seen.end()) problem(key, "is there twice: keep one");
    seen.push_back(key);
  }
}

void YamlSection::problem(const std::string& key, const std::string& what, ErrorCode code) {
  problems_->add(code, full(key) + ": " + what);
}

std::optional<YAML::Node> YamlSection::find(const std::string& key, bool required) {
  known_.push_back(key);
  if (has(key)) return std::as_const(node_)[key];
  if (required) problem(key, "is missing: add it");
  return std::nullopt;
}

std::optional<YAML::Node> YamlSection::find_list(const std::string& key, bool required) {
  auto node = find(key, required);
  if (!node || node->IsSequence()) return node;
  problem(key, "must be a list, not " + shown(*node));
  return std::nullopt;
}

std::vector<float> YamlSection::read_numbers(const YAML::Node& list, const std::string& key,
                                             Range<float> range) {
  std::vector<float> result;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto value = decoded<float>(list[i]);
    if (!value || !inside(*value, range))
      problem(key + "[" + std::to_string(i) + "]",
              "must be a number in " + range_text(range) + ", not " + shown(list[i]));
    result.push_back(value.value_or(range.low));
  }
  return result;
}

std::string YamlSection::full(const std::string& key) const {
  return path_.empty() ? key : path_ + "." + key;
}

}  // namespace extperfc::detect
