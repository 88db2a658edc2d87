#include "translate/rules/yaml_map.hpp"

#include <algorithm>
#include <cmath>
#include <locale>
#include <set>
#include <sstream>

namespace extperfc::translate::rules {

int line_of(const YAML::Node& node) {
  return node.IsDefined() && !node.Mark().is_null() ? node.Mark().line + 1 : 0;
}

std::string shown(const YAML::Node& node) {
  if (node.IsMap()) return "a map";
  if (node.IsSequence()) return "a list of " + std::to_string(node.size());
  return node.IsScalar() ? in_quotes(node.Scalar()) : "nothing";
}

YamlMap::YamlMap(const YAML::Node& node, std::string where, Problems& problems)
    : where_(std::move(where)), problems_(&problems), line_(line_of(node)) {
  if (!node.IsMap()) {
    problems.add(line_, where_, "must be a map of keys and values, not " + shown(node));
    return;
  }
  std::set<std::string> seen;
  for (const auto& pair : node) {
    const int line = line_of(pair.first);
    if (!pair.first.IsScalar())
      problems.add(line, where_, "a key must be a text, not " + shown(pair.first));
    else if (!seen.insert(pair.first.Scalar()).second)
      problems.add(line, where_, in_quotes(pair.first.Scalar()) + " is given twice: remove one");
    else
      items_.push_back({pair.first.Scalar(), pair.second, line});
  }
}

const YamlMap::Item* YamlMap::find(const std::string& key) const {
  const auto found =
      std::find_if(items_.begin(), items_.end(), [&key](const Item& item) { return item.key == key; });
  return found == items_.end() ? nullptr : &*found;
}

std::optional<std::string> YamlMap::text(const std::string& key) const {
  const Item* item = find(key);
  if (item == nullptr) return std::nullopt;
  if (item->value.IsScalar()) return item->value.Scalar();
  problem(key, "must be a text, not " + shown(item->value));
  return std::nullopt;
}

std::optional<double> YamlMap::number(const std::string& key) const {
  const Item* item = find(key);
  if (item == nullptr) return std::nullopt;
  if (item->value.IsScalar()) {
    std::istringstream in(item->value.Scalar());
    in.imbue(std::locale::classic());
    double value = 0;
    if (in >> value && in.eof() && std::isfinite(value)) return value;
  }
  problem(key, "must be a finite number, not " + shown(item->value));
  return std::nullopt;
}

void YamlMap::allow_only(const std::vector<std::string>& known) const {
  for (const Item& item : items_) {
    if (std::find(known.begin(), known.end(), item.key) != known.end()) continue;
    const std::string hint = hint_for(item.key, known);
    problems_->add(item.line, where_,
                   "unknown key " + in_quotes(item.key) +
                       (hint.empty() ? ": known here are " + enumeration(known) : hint));
  }
}

std::string YamlMap::where(const std::string& key) const {
  return where_.empty() || key.empty() ? where_ + key : where_ + "." + key;
}

void YamlMap::problem(const std::string& key, const std::string& what) const {
  const Item* item = find(key);
  problems_->add(item != nullptr ? item->line : line_, where(key), what);
}

}  // namespace extperfc::translate::rules
