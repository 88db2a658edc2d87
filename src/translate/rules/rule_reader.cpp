#include "translate/rules/rule_reader.hpp"

#include <algorithm>

#include "extperfc/base/text.hpp"

#include "translate/rules/source_reader.hpp"

namespace extperfc::translate {

namespace {

bool is_md5(const std::string& text) {
  const auto hexadecimal = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  return text.size() == 32 && std::all_of(text.begin(), text.end(), hexadecimal);
}

std::string sets_in_brackets(const std::vector<std::string>& sets) {
  return sets.empty() ? "" : " (" + enumeration(sets) + ")";
}

const std::vector<std::string> kSides{"forward", "backward", "drop_forward", "drop_backward"};

}  // namespace

RuleFile RuleReader::read(const YAML::Node& root) {
  if (root.IsSequence()) {
    read_rules(root);
  } else if (!root.IsNull()) {
    YamlMap map(root, "", *problems_);
    map.allow_only({"rules", "renames"});
    if (map.has("renames")) read_renames(map);
    if (map.has("rules")) read_rules(map.find("rules")->value);
  }
  return std::move(file_);
}

void RuleReader::read_renames(YamlMap& root) {
  const YAML::Node list = root.find("renames")->value;
  if (!list.IsSequence()) {
    root.problem("renames", "must be a list of {from: ..., to: ...}, not " + shown(list));
    return;
  }
  for (const auto& node : list) {
    if (!budget_.take(*problems_, line_of(node))) return;
    YamlMap map(node, "renames", *problems_);
    map.allow_only({"from", "to"});
    const std::string from = map.text("from", ""), to = map.text("to", "");
    const bool same_kind = (from.find('/') == std::string::npos) == (to.find('/') == std::string::npos);
    if (from.empty() || to.empty() || from == to || !same_kind)
      map.problem("", "needs from and to: two types or two packages");
    else
      file_.renames.emplace_back(from, to);
  }
}

void RuleReader::read_rules(const YAML::Node& list) {
  if (!list.IsSequence()) {
    problems_->add(line_of(list), "rules", "must be a list of entries, not " + shown(list));
    return;
  }
  for (const auto& node : list) {
    if (!budget_.take(*problems_, line_of(node))) return;
    read_entry(node);
  }
}

void RuleReader::read_entry(const YAML::Node& node) {
  std::string where;
  if (node.IsMap())
    for (const char* key : {"type", "service"})
      if (const YAML::Node name = node[key]; name.IsDefined() && name.IsScalar()) where = name.Scalar();
  YamlMap entry(node, where.empty() ? "rule" : where, *problems_);
  if (!node.IsMap()) return;
  if (entry.has("service"))
    read_service_entry(entry);
  else
    read_message_entry(entry);
}

void RuleReader::read_message_entry(YamlMap& entry) {
  std::vector<std::string> known{"type", "from", "to"};
  known.insert(known.end(), kSides.begin(), kSides.end());
  entry.allow_only(known);
  const std::string type = entry.text("type", "");
  const End from = read_end(entry, "from", type), to = read_end(entry, "to", type);
  if (!from.md5.empty() && from.type == to.type && from.md5 == to.md5)
    entry.problem("to", "is the same definition as from");
  read_both_directions(entry, {find_message(from), find_message(to), entry.line()});
}

void RuleReader::read_service_entry(YamlMap& entry) {
  entry.allow_only({"service", "from", "to", "request", "response"});
  const std::string type = entry.text("service", "");
  const End from = read_end(entry, "from", type), to = read_end(entry, "to", type);
  const ServicePtr old_service = find_service(from), new_service = find_service(to);
  if (from.type != to.type && !from.type.empty() && !to.type.empty())
    file_.renames.emplace_back(from.type, to.type);
  const auto half = [&](SchemaPtr ServiceSchema::*which) {
    return Pair{old_service ? (*old_service).*which : nullptr, new_service ? (*new_service).*which : nullptr,
                entry.line()};
  };
  read_half(entry, "request", half(&ServiceSchema::request));
  read_half(entry, "response", half(&ServiceSchema::response));
}

// A half that differs gets its rules even when the entry says nothing of it: chains lead through them.
void RuleReader::read_half(YamlMap& entry, const std::string& key, const Pair& pair) {
  const auto* item = entry.find(key);
  const bool same =
      pair.from && pair.to && pair.from->type() == pair.to->type() && pair.from->md5() == pair.to->md5();
  if (same && item != nullptr) entry.problem(key, "is the same on both sides: remove this");
  if (same) return;
  YamlMap map = entry.section(key);
  map.allow_only(kSides);
  read_both_directions(map, pair);
}

RuleReader::End RuleReader::read_end(YamlMap& entry, const std::string& key, const std::string& type) {
  const auto* item = entry.find(key);
  if (item == nullptr) {
    entry.problem("", "has no " + key + ": give {md5: ...}");
    return {};
  }
  End end{type, "", item->line};
  if (item->value.IsScalar()) {
    end.md5 = item->value.Scalar();
  } else {
    YamlMap map(item->value, entry.path(key), *problems_);
    map.allow_only({"type", "md5", "name"});
    end.type = map.text("type", type);
    end.md5 = map.text("md5", "");
  }
  if (!is_md5(end.md5)) {
    entry.problem(key, "needs an MD5 of 32 hexadecimal digits, not " + in_quotes(end.md5));
    end.md5.clear();
  }
  if (end.type.find('/') == std::string::npos) {
    entry.problem(key, "needs a type like package/Name: give type, or from and to a type each");
    end.md5.clear();
  }
  return end;
}

void RuleReader::read_both_directions(YamlMap& map, const Pair& pair) {
  file_.drafts.push_back(read_one_direction(map, "forward", pair));
  file_.drafts.push_back(read_one_direction(map, "backward", {pair.to, pair.from, pair.line}));
}

Draft RuleReader::read_one_direction(YamlMap& map, const std::string& direction, const Pair& pair) {
  const std::size_t before = problems_->size();
  const auto* item = map.find(direction);
  Draft draft;
  draft.from = pair.from;
  draft.to = pair.to;
  draft.line = item != nullptr ? item->line : pair.line;
  draft.rule.origin = problems_->place(draft.line);
  const YamlMap targets = map.section(direction);
  SourceReader reader(pair.from.get(), *problems_, budget_);
  for (const auto& target : targets.items()) {
    const Field* field = pair.to ? pair.to->find(target.key) : nullptr;
    if (pair.to && field == nullptr)
      problems_->add(target.line, targets.path(),
                     pair.to->type() + " has no field " + in_quotes(target.key) +
                         hint_for(target.key, field_names(*pair.to)));
    draft.rule.targets.emplace_back(
        target.key, reader.read(target.value, targets.path(target.key), {field, pair.to.get()}));
  }
  read_dropped(map, "drop_" + direction, draft);
  draft.sound = problems_->size() == before && pair.from && pair.to;
  if (!draft.sound) return draft;
  draft.rule.from_type = pair.from->type();
  draft.rule.from_md5 = pair.from->md5();
  draft.rule.to_type = pair.to->type();
  draft.rule.to_md5 = pair.to->md5();
  return draft;
}

void RuleReader::read_dropped(YamlMap& map, const std::string& key, Draft& draft) {
  const auto* item = map.find(key);
  if (item == nullptr) return;
  if (!item->value.IsSequence()) map.problem(key, "must be a list of fields, not " + shown(item->value));
  if (!item->value.IsSequence()) return;
  for (const auto& node : item->value) {
    if (!budget_.take(*problems_, line_of(node))) return;
    const std::string name = node.IsScalar() ? node.Scalar() : "";
    if (draft.from && draft.from->find(name) == nullptr)
      problems_->add(
          line_of(node), map.path(key),
          draft.from->type() + " has no field " + in_quotes(name) + hint_for(name, field_names(*draft.from)));
    draft.rule.dropped.push_back(name);
  }
}

SchemaPtr RuleReader::find_message(const End& end) {
  if (end.md5.empty()) return nullptr;
  auto schema = definitions_->find_message(end.type, end.md5);
  if (schema) return schema;
  std::vector<std::string> known;
  for (const SchemaPtr& other : definitions_->messages(end.type))
    known.push_back(other->md5() + sets_in_brackets(definitions_->sets_with(end.type, other->md5())));
  report_unknown(end, known, false);
  return nullptr;
}

ServicePtr RuleReader::find_service(const End& end) {
  if (end.md5.empty()) return nullptr;
  auto service = definitions_->find_service(end.type, end.md5);
  if (service) return service;
  std::vector<std::string> known;
  for (const ServicePtr& other : definitions_->services(end.type))
    known.push_back(other->md5 + sets_in_brackets(definitions_->sets_with(end.type, other->md5)));
  report_unknown(end, known, true);
  return nullptr;
}

void RuleReader::report_unknown(const End& end, const std::vector<std::string>& known_md5s, bool is_service) {
  const std::string kind = is_service ? "service " : "message ";
  if (!known_md5s.empty()) {
    problems_->add(end.line, end.type,
                   "no definition with MD5 " + end.md5 + "; known are " + enumeration(known_md5s));
    return;
  }
  std::vector<std::string> types;
  for (const std::string& set : definitions_->sets()) {
    const auto content = definitions_->content(set);
    const auto& names = is_service ? content.services : content.messages;
    types.insert(types.end(), names.begin(), names.end());
  }
  problems_->add(end.line, end.type,
                 "no definition of this " + kind + "is known" + hint_for(end.type, types));
}

}  // namespace extperfc::translate
