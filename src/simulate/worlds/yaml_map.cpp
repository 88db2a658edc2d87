#include "simulate/worlds/yaml_map.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "extperfc/base/edit_distance.hpp"

namespace extperfc::simulate::worlds {

namespace {

constexpr std::size_t kFarthestHint = 2;  // edits between an unknown name and the known one that is suggested
constexpr std::size_t kLongestShown = 40;

std::string text_of(Span span) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << '[' << span.low << ", " << span.high << ']';
  return out.str();
}

// Written so that NaN is outside.
bool inside(double value, Span span) {
  return value >= span.low && value <= span.high;
}

int line_of(const YAML::Node& node) {
  return node.Mark().is_null() ? 0 : node.Mark().line + 1;
}

}  // namespace

void Problems::add(int line, const std::string& key_path, const std::string& what) {
  const std::string place = line > 0 ? source_name_ + ":" + std::to_string(line) : source_name_;
  list_.push_back({line, place + ": " + (key_path.empty() ? "" : key_path + ": ") + what});
}

Error Problems::to_error() const {
  std::vector<Problem> sorted = list_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Problem& a, const Problem& b) { return a.line < b.line; });
  std::string message;
  for (const Problem& problem : sorted) message += (message.empty() ? "" : "\n") + problem.text;
  return {ErrorCode::kInvalidArgument, message};
}

std::string hint_for(const std::string& name, const std::vector<std::string>& known) {
  const auto nearest = std::min_element(known.begin(), known.end(), [&name](const auto& a, const auto& b) {
    return edit_distance(name, a) < edit_distance(name, b);
  });
  if (nearest == known.end() || edit_distance(name, *nearest) > kFarthestHint) return "";
  return ", did you mean \"" + *nearest + "\"?";
}

std::string shown(const YAML::Node& node) {
  if (node.IsMap()) return "a map";
  if (node.IsSequence()) return "a list of " + std::to_string(node.size());
  if (!node.IsScalar()) return "nothing";
  const std::string& text = node.Scalar();
  return '"' + (text.size() > kLongestShown ? text.substr(0, kLongestShown - 3) + "..." : text) + '"';
}

std::optional<double> as_number(const YAML::Node& node) {
  if (!node.IsScalar()) return std::nullopt;
  std::istringstream in(node.Scalar());
  in.imbue(std::locale::classic());
  double value = 0;
  if (!(in >> value) || !in.eof() || !std::isfinite(value)) return std::nullopt;
  return value;
}

YamlMap::YamlMap(const YAML::Node& node, std::string path, Problems& problems)
    : node_(node), path_(std::move(path)), problems_(&problems) {
  if (node_.IsMap()) return;
  problems_->add(line_of(node_), path_.empty() ? "the file" : path_,
                 "must be a map of keys and values, not " + shown(node_));
  node_ = YAML::Node(YAML::NodeType::Map);
}

bool YamlMap::has(const std::string& key) const {
  return std::as_const(node_)[key].IsDefined();
}

int YamlMap::line(const std::string& key) const {
  if (!key.empty() && has(key)) return line_of(std::as_const(node_)[key]);
  return line_of(node_);
}

void YamlMap::problem(const std::string& key, const std::string& what) {
  const std::string name = key.substr(0, key.find('['));
  problems_->add(line(name), path_.empty() ? key : (key.empty() ? path_ : path_ + "." + key), what);
}

std::optional<YAML::Node> YamlMap::find(const std::string& key, bool required) {
  known_.push_back(key);
  if (has(key)) return std::as_const(node_)[key];
  if (required) problem(key, "is missing: add it");
  return std::nullopt;
}

std::optional<YAML::Node> YamlMap::node(const std::string& key) {
  return find(key, false);
}

std::optional<YAML::Node> YamlMap::find_list(const std::string& key, bool required) {
  auto found = find(key, required);
  if (!found || found->IsSequence()) return found;
  problem(key, "must be a list, not " + shown(*found));
  return std::nullopt;
}

double YamlMap::number(const std::string& key, Span span, std::optional<double> fallback) {
  const auto found = find(key, !fallback);
  if (!found) return fallback.value_or(span.low);
  const auto value = as_number(*found);
  if (value && inside(*value, span)) return *value;
  problem(key, "must be a number in " + text_of(span) + ", not " + shown(*found));
  return fallback.value_or(span.low);
}

int YamlMap::integer(const std::string& key, int low, int high, std::optional<int> fallback) {
  const auto found = find(key, !fallback);
  if (!found) return fallback.value_or(low);
  const auto value = as_number(*found);
  if (value && *value == std::floor(*value) && *value >= low && *value <= high)
    return static_cast<int>(*value);
  problem(key, "must be a whole number in " + text_of({static_cast<double>(low), static_cast<double>(high)}) +
                   ", not " + shown(*found));
  return fallback.value_or(low);
}

bool YamlMap::flag(const std::string& key, bool fallback) {
  const auto found = find(key, false);
  if (!found) return fallback;
  bool value = fallback;
  if (!found->IsScalar() || !YAML::convert<bool>::decode(*found, value))
    problem(key, "must be true or false, not " + shown(*found));
  return value;
}

std::string YamlMap::text(const std::string& key, const std::optional<std::string>& fallback) {
  const auto found = find(key, !fallback);
  if (!found) return fallback.value_or("");
  if (found->IsScalar() && (!found->Scalar().empty() || fallback)) return found->Scalar();
  problem(key, "must be text, not " + shown(*found));
  return fallback.value_or("");
}

std::vector<double> YamlMap::read_numbers(const YAML::Node& list, const std::string& key, Span span) {
  std::vector<double> values;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto value = as_number(list[i]);
    if (!value || !inside(*value, span))
      problem(key + "[" + std::to_string(i) + "]",
              "must be a number in " + text_of(span) + ", not " + shown(list[i]));
    values.push_back(value && inside(*value, span) ? *value : span.low);
  }
  return values;
}

std::vector<double> YamlMap::numbers(const std::string& key, std::size_t count, Span span,
                                     const std::optional<std::vector<double>>& fallback) {
  std::vector<double> otherwise = fallback.value_or(std::vector<double>(count, span.low));
  const auto list = find_list(key, !fallback);
  if (!list) return otherwise;
  if (list->size() == count) return read_numbers(*list, key, span);
  problem(key, "must have " + std::to_string(count) + " numbers, not " + std::to_string(list->size()));
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

Eigen::Vector3d YamlMap::place(const std::string& key) {
  const auto list = find_list(key, true);
  if (!list) return Eigen::Vector3d::Zero();
  if (list->size() != 2 && list->size() != 3) {
    problem(key, "must be [x, y] or [x, y, z] in metres, not " + shown(*list));
    return Eigen::Vector3d::Zero();
  }
  auto values = read_numbers(*list, key, kAny);
  values.resize(3, 0.0);
  return {values[0], values[1], values[2]};
}

std::vector<Eigen::Vector2d> YamlMap::points(const std::string& key, std::size_t min_count) {
  std::vector<Eigen::Vector2d> result;
  const auto list = find_list(key, true);
  if (!list) return result;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const std::string name = key + "[" + std::to_string(i) + "]";
    if (!(*list)[i].IsSequence() || (*list)[i].size() != 2) {
      problem(name, "must be a point [x, y] in metres, not " + shown((*list)[i]));
      continue;
    }
    const auto values = read_numbers((*list)[i], name, kAny);
    result.emplace_back(values[0], values[1]);
  }
  if (list->size() < min_count)
    problem(key, "must have at least " + std::to_string(min_count) + " points [x, y]: add some");
  return result;
}

std::vector<YamlMap> YamlMap::maps(const std::string& key) {
  std::vector<YamlMap> result;
  const auto list = find_list(key, false);
  for (std::size_t i = 0; list && i < list->size(); ++i)
    result.emplace_back((*list)[i], (path_.empty() ? key : path_ + "." + key) + "[" + std::to_string(i) + "]",
                        *problems_);
  return result;
}

void YamlMap::refuse_unknown() {
  std::set<std::string> seen;
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "(a key that is not text)";
    const std::string full = path_.empty() ? key : path_ + "." + key;
    const bool known = std::find(known_.begin(), known_.end(), key) != known_.end();
    if (!known) problems_->add(line_of(entry.first), full, "unknown key: remove it" + hint_for(key, known_));
    if (!seen.insert(key).second) problems_->add(line_of(entry.first), full, "is there twice: keep one");
  }
}

}  // namespace extperfc::simulate::worlds
