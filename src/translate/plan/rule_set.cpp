#include <algorithm>
#include <deque>

#include "extperfc/translate/rules.hpp"

namespace extperfc::translate {

namespace {

using Key = std::pair<std::string, std::string>;  // type, MD5

Key source_of(const MigrationRule& rule) {
  return {rule.from_type, rule.from_md5};
}

Key target_of(const MigrationRule& rule) {
  return {rule.to_type, rule.to_md5};
}

/// `type` with the rename applied: that of the very type, or that of its package; empty when it does not
/// apply.
std::string renamed(const std::string& type, const std::string& from, const std::string& to) {
  if (type == from) return to;
  const bool of_package = from.find('/') == std::string::npos;
  if (of_package && type.size() > from.size() && type[from.size()] == '/' &&
      type.compare(0, from.size(), from) == 0)
    return to + type.substr(from.size());
  return "";
}

}  // namespace

std::string to_string(const Path& path) {
  std::string text;
  for (const PathStep& step : path) {
    text += (text.empty() ? "" : ".") + step.field;
    if (step.index) text += "[" + std::to_string(*step.index) + "]";
  }
  return text;
}

void RuleSet::add(MigrationRule rule) {
  from_[source_of(rule)].push_back(rules_.size());
  if (rule.from_type != rule.to_type) add_rename(rule.from_type, rule.to_type);
  rules_.push_back(std::move(rule));
}

void RuleSet::add_rename(const std::string& from, const std::string& to) {
  const bool one_is_package = from.find('/') == std::string::npos || to.find('/') == std::string::npos;
  const bool both_are = from.find('/') == std::string::npos && to.find('/') == std::string::npos;
  if (one_is_package && !both_are) return;
  const auto known = std::find(renames_.begin(), renames_.end(), std::make_pair(from, to));
  const auto reversed = std::find(renames_.begin(), renames_.end(), std::make_pair(to, from));
  if (from != to && known == renames_.end() && reversed == renames_.end()) renames_.emplace_back(from, to);
}

void RuleSet::add_schema(const SchemaPtr& schema) {
  if (schema) schemas_.emplace(Key{schema->type(), schema->md5()}, schema);
}

const MigrationRule* RuleSet::find(const MessageSchema& from, const MessageSchema& to) const {
  const auto candidates = from_.find({from.type(), from.md5()});
  if (candidates == from_.end()) return nullptr;
  for (const std::size_t index : candidates->second)
    if (target_of(rules_[index]) == Key{to.type(), to.md5()}) return &rules_[index];
  return nullptr;
}

// Breadth first, so the first way found is the shortest; among equals the one whose rules were added first.
std::vector<RuleSet::Link> RuleSet::chain(const SchemaPtr& from, const SchemaPtr& to) const {
  const Key start{from->type(), from->md5()};
  const Key goal{to->type(), to->md5()};
  if (start == goal) return {};
  std::map<Key, const MigrationRule*> reached_by{{start, nullptr}};
  std::deque<Key> open{start};
  while (!open.empty() && reached_by.count(goal) == 0) {
    const Key here = open.front();
    open.pop_front();
    const auto leaving = from_.find(here);
    if (leaving == from_.end()) continue;
    for (const std::size_t index : leaving->second) {
      const Key next = target_of(rules_[index]);
      if (here == start && next == goal) continue;  // a single rule is no chain: find() knows it
      if (next != goal && schemas_.count(next) == 0) continue;
      if (reached_by.emplace(next, &rules_[index]).second) open.push_back(next);
    }
  }
  return links_to(goal, reached_by, from, to);
}

std::vector<RuleSet::Link> RuleSet::links_to(const Key& goal,
                                             const std::map<Key, const MigrationRule*>& reached_by,
                                             const SchemaPtr& from, const SchemaPtr& to) const {
  std::vector<Link> links;
  for (auto step = reached_by.find(goal); step != reached_by.end() && step->second != nullptr;
       step = reached_by.find(source_of(*step->second)))
    links.push_back({step->second, nullptr, nullptr});
  std::reverse(links.begin(), links.end());
  SchemaPtr here = from;
  for (Link& link : links) {
    link.from = here;
    link.to = &link == &links.back() ? to : schemas_.at(target_of(*link.rule));
    here = link.to;
  }
  return links;
}

std::vector<std::string> RuleSet::other_names(std::string_view type) const {
  std::vector<std::string> names{std::string(type)};
  for (std::size_t i = 0; i < names.size(); ++i) {  // names grows: renames of renames
    for (const auto& [from, to] : renames_) {
      for (const auto& name : {renamed(names[i], from, to), renamed(names[i], to, from)})
        if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end())
          names.push_back(name);
    }
  }
  names.erase(names.begin());
  return names;
}

}  // namespace extperfc::translate
