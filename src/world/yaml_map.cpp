#include "extperfc/world/yaml_map.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <locale>
#include <sstream>
#include <unordered_set>
#include <utility>

#include "extperfc/base/number_reader.hpp"
#include "extperfc/base/text.hpp"

namespace extperfc {

namespace {

// Written so that NaN is outside.
bool inside(double value, Span span) {
  return value >= span.low && value <= span.high;
}

std::string text_of(Span span) {
  return "in [" + number_text(span.low) + ", " + number_text(span.high) + "]";
}

std::string wanted(const std::string& what, Span span) {
  if (span.low == kFinite.low && span.high == kFinite.high) return "must be a finite number";
  return "must be a " + what + " " + text_of(span);
}

std::optional<double> as_number(const YAML::Node& node) {
  return node.IsScalar() ? parse_number(node.Scalar()) : std::nullopt;
}

std::string nth(const std::string& key, std::size_t i) {
  return key + "[" + std::to_string(i) + "]";
}

std::string text_of(Count count) {
  if (count.max == kAnyNumber) return std::to_string(count.min) + " or more";
  const std::string low = count.min == count.max ? "" : std::to_string(count.min) + " to ";
  return low + std::to_string(count.max);
}

}  // namespace

std::optional<YAML::Node> parse_yaml(const std::string& text, Problems& problems) try {
  return YAML::Load(text);
} catch (const YAML::Exception& error) {
  problems.add(error.mark.is_null() ? 0 : error.mark.line + 1, "",
               "not YAML: " + error.msg + ": correct this line", ErrorCode::kCorrupt);
  return std::nullopt;
}

std::optional<YAML::Node> load_yaml(const std::filesystem::path& file, Problems& problems) {
  std::error_code error;
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  if (std::filesystem::is_regular_file(file, error) && (in.peek() == EOF || text << in.rdbuf()))
    return parse_yaml(text.str(), problems);
  problems.add(0, "", "cannot be read: check the path and its permissions", ErrorCode::kNotFound);
  return std::nullopt;
}

int line_of(const YAML::Node& node) {
  return node.IsDefined() && !node.Mark().is_null() ? node.Mark().line + 1 : 0;
}

std::string shown(const YAML::Node& node) {
  if (node.IsMap()) return "a map";
  if (node.IsSequence()) return "a list of " + std::to_string(node.size());
  return node.IsScalar() ? in_quotes(node.Scalar()) : "nothing";
}

YamlMap::YamlMap(const YAML::Node& node, std::string path, Problems& problems)
    : path_(std::move(path)), problems_(&problems), line_(line_of(node)), is_map_(node.IsMap()) {
  if (!is_map_) {
    problem("", "must be a map of keys and values, not " + shown(node));
    return;
  }
  std::unordered_set<std::string> seen;
  for (const auto& pair : node) {
    const int line = line_of(pair.first);
    if (!pair.first.IsScalar())
      problems.add(line, path_, "a key must be a text, not " + shown(pair.first));
    else if (!seen.insert(pair.first.Scalar()).second)
      problems.add(line, this->path(pair.first.Scalar()), "is given twice: remove one");
    else
      items_.push_back({pair.first.Scalar(), pair.second, line});
  }
}

const YamlMap::Item* YamlMap::find(const std::string& key) const {
  const auto found =
      std::find_if(items_.begin(), items_.end(), [&key](const Item& item) { return item.key == key; });
  return found == items_.end() ? nullptr : &*found;
}

bool YamlMap::is_list(const std::string& key) const {
  const Item* item = find(key);
  return item != nullptr && item->value.IsSequence();
}

bool YamlMap::asked_for(const std::string& key) const {
  return std::find(known_.begin(), known_.end(), key) != known_.end();
}

int YamlMap::line(const std::string& key) const {
  const Item* item = find(key.substr(0, key.find_first_of("[.")));
  return item != nullptr ? item->line : line_;
}

std::string YamlMap::path(const std::string& key) const {
  return path_.empty() || key.empty() ? path_ + key : path_ + "." + key;
}

void YamlMap::problem(const std::string& key, const std::string& what) const {
  problems_->add(line(key), path(key), what);
}

void YamlMap::problem(const std::string& key, const std::string& what, ErrorCode code) const {
  problems_->add(line(key), path(key), what, code);
}

void YamlMap::refuse(const std::string& key, const std::string& reason) {
  if (read(key, false) != nullptr) problem(key, reason);
}

void YamlMap::allow_only(const std::vector<std::string>& known) const {
  for (const Item& item : items_) {
    if (std::find(known.begin(), known.end(), item.key) != known.end()) continue;
    problems_->add(item.line, path_, "unknown key " + in_quotes(item.key) + hint_or_names(item.key, known));
  }
}

const YAML::Node* YamlMap::read(const std::string& key, bool required) {
  if (!asked_for(key)) known_.push_back(key);
  const Item* item = find(key);
  if (item == nullptr && required && is_map_) problem(key, "is missing: add it");
  return item == nullptr ? nullptr : &item->value;
}

const YAML::Node* YamlMap::read_list(const std::string& key, bool required) {
  const YAML::Node* found = read(key, required);
  if (found == nullptr || found->IsSequence()) return found;
  problem(key, "must be a list, not " + shown(*found));
  return nullptr;
}

std::optional<YAML::Node> YamlMap::node(const std::string& key) {
  const YAML::Node* found = read(key, false);
  return found == nullptr ? std::nullopt : std::optional(*found);
}

std::optional<double> YamlMap::find_number(const std::string& key, Span span) {
  const YAML::Node* found = read(key, false);
  if (found == nullptr) return std::nullopt;
  const auto value = as_number(*found);
  if (value && inside(*value, span)) return value;
  problem(key, wanted("number", span) + ", not " + shown(*found));
  return std::nullopt;
}

double YamlMap::number(const std::string& key, Span span, std::optional<double> fallback) {
  if (!fallback) (void)read(key, true);
  return find_number(key, span).value_or(fallback.value_or(span.low));
}

int YamlMap::integer(const std::string& key, int low, int high, std::optional<int> fallback) {
  const YAML::Node* found = read(key, !fallback);
  if (found == nullptr) return fallback.value_or(low);
  const Span span{static_cast<double>(low), static_cast<double>(high)};
  const auto value = as_number(*found);
  if (value && *value == std::floor(*value) && inside(*value, span)) return static_cast<int>(*value);
  problem(key, wanted("whole number", span) + ", not " + shown(*found));
  return fallback.value_or(low);
}

bool YamlMap::flag(const std::string& key, std::optional<bool> fallback) {
  const YAML::Node* found = read(key, !fallback);
  bool value = fallback.value_or(false);
  if (found == nullptr) return value;
  if (found->IsScalar() && (found->Scalar() == "0" || found->Scalar() == "1")) return found->Scalar() == "1";
  if (!found->IsScalar() || !YAML::convert<bool>::decode(*found, value))
    problem(key, "must be true or false, not " + shown(*found));
  return value;
}

std::optional<std::string> YamlMap::find_text(const std::string& key) {
  const YAML::Node* found = read(key, false);
  if (found == nullptr) return std::nullopt;
  if (found->IsScalar()) return found->Scalar();
  problem(key, "must be a text, not " + shown(*found));
  return std::nullopt;
}

std::string YamlMap::text(const std::string& key, const std::optional<std::string>& fallback) {
  if (!fallback && read(key, true) == nullptr) return "";
  const auto found = find_text(key);
  if (found && found->empty() && !fallback) problem(key, "must be a text that is not empty");
  return found.value_or(fallback.value_or(""));
}

std::size_t YamlMap::choice(const std::string& key, const std::vector<std::string>& names,
                            std::size_t fallback) {
  const auto name = find_text(key);
  if (!name) return fallback;
  const auto found = std::find(names.begin(), names.end(), *name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  problem(key, "must be " + enumeration(names, " or ") + ", not " + in_quotes(*name));
  return fallback;
}

double YamlMap::number_in(const YAML::Node& node, const std::string& key, Span span) const {
  const auto value = as_number(node);
  if (value && inside(*value, span)) return *value;
  problem(key, wanted("number", span) + ", not " + shown(node));
  return span.low;
}

std::vector<double> YamlMap::numbers_in(const YAML::Node& list, const std::string& key, Span span) const {
  std::vector<double> values;
  for (std::size_t i = 0; i < list.size(); ++i) values.push_back(number_in(list[i], nth(key, i), span));
  return values;
}

std::vector<double> YamlMap::numbers(const std::string& key, Count count, Span span,
                                     const std::optional<std::vector<double>>& fallback) {
  std::vector<double> otherwise = fallback.value_or(std::vector<double>(count.min, span.low));
  const YAML::Node* list = read_list(key, !fallback);
  if (list == nullptr) return otherwise;
  if (list->size() >= count.min && list->size() <= count.max) return numbers_in(*list, key, span);
  problem(key, "must have " + text_of(count) + " numbers, not " + std::to_string(list->size()));
  return otherwise;
}

Eigen::Vector2d YamlMap::vector2(const std::string& key, Span span,
                                 const std::optional<Eigen::Vector2d>& fallback) {
  std::optional<std::vector<double>> otherwise;
  if (fallback) otherwise = {fallback->x(), fallback->y()};
  const auto values = numbers(key, 2, span, otherwise);
  return {values[0], values[1]};
}

Eigen::Vector3d YamlMap::vector3(const std::string& key, Span span,
                                 const std::optional<Eigen::Vector3d>& fallback) {
  std::optional<std::vector<double>> otherwise;
  if (fallback) otherwise = {fallback->x(), fallback->y(), fallback->z()};
  const auto values = numbers(key, 3, span, otherwise);
  return {values[0], values[1], values[2]};
}

std::vector<std::vector<double>> YamlMap::rows(const std::string& key, std::size_t columns, Span span,
                                               std::size_t min_rows) {
  std::vector<std::vector<double>> result;
  const YAML::Node* list = read_list(key, true);
  if (list == nullptr) return result;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const YAML::Node row = (*list)[i];
    if (row.IsSequence() && row.size() == columns)
      result.push_back(numbers_in(row, nth(key, i), span));
    else
      problem(nth(key, i), "must be a list of " + std::to_string(columns) + " numbers, not " + shown(row));
  }
  if (list->size() < min_rows)
    problem(key, "must have at least " + std::to_string(min_rows) + " rows of " + std::to_string(columns) +
                     " numbers: add some");
  return result;
}

std::vector<std::string> YamlMap::texts(const std::string& key, bool required) {
  std::vector<std::string> result;
  const YAML::Node* list = read_list(key, required);
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
    const YAML::Node item = (*list)[i];
    if (!item.IsScalar() || item.Scalar().empty())
      problem(nth(key, i), "must be a text that is not empty, not " + shown(item));
    result.push_back(item.IsScalar() ? item.Scalar() : "");
  }
  if (list != nullptr && result.empty()) problem(key, "is empty: list at least one");
  return result;
}

YamlMap YamlMap::section(const std::string& key, bool required) {
  const YAML::Node* found = read(key, required);
  YamlMap map(found != nullptr ? *found : YAML::Node(YAML::NodeType::Map), path(key), *problems_);
  if (found == nullptr) map.line_ = line_;
  return map;
}

std::vector<YamlMap> YamlMap::maps(const std::string& key, std::size_t min_count) {
  std::vector<YamlMap> result;
  const YAML::Node* list = read_list(key, min_count > 0);
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i)
    result.emplace_back((*list)[i], path(nth(key, i)), *problems_);
  if (list != nullptr && result.size() < min_count) problem(key, "is empty: list at least one");
  return result;
}

}  // namespace extperfc
