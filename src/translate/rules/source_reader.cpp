#include "translate/rules/source_reader.hpp"

#include "extperfc/base/text.hpp"

#include "translate/plan/field_size.hpp"

namespace extperfc::translate {

namespace {

constexpr const char* kPose = "geometry_msgs/Pose";

bool is_pose(const Field& field) {
  return field.primitive == Primitive::kMessage && field.message->type() == kPose;
}

const std::vector<std::string>& keys_of(Source::Kind kind) {
  static const std::vector<std::string> kField{"from",      "scale",    "offset",     "map",
                                               "otherwise", "overflow", "relative_to"};
  static const std::vector<std::string> kValue{"value"};
  static const std::vector<std::string> kList{"list"};
  static const std::vector<std::string> kMessage{"fields"};
  switch (kind) {
    case Source::Kind::kValue:
      return kValue;
    case Source::Kind::kList:
      return kList;
    case Source::Kind::kMessage:
      return kMessage;
    case Source::Kind::kField:
      break;
  }
  return kField;
}

std::vector<std::string> every_key() {
  std::vector<std::string> keys = keys_of(Source::Kind::kField);
  for (const auto kind : {Source::Kind::kValue, Source::Kind::kList, Source::Kind::kMessage})
    keys.push_back(keys_of(kind).front());
  return keys;
}

/// By the one key that every source has; nothing when there is none of them.
std::optional<Source::Kind> kind_of(YamlMap& map) {
  for (const auto kind :
       {Source::Kind::kField, Source::Kind::kValue, Source::Kind::kList, Source::Kind::kMessage})
    if (map.has(keys_of(kind).front())) return kind;
  return std::nullopt;
}

}  // namespace

Source SourceReader::read(const YAML::Node& node, const std::string& where, Target target, int depth) {
  Source source;
  const int line = line_of(node);
  if (!budget_->take(*problems_, line)) return source;
  if (depth > kDeepest) {
    problems_->add(line, where, "is nested too deeply");
    return source;
  }
  if (node.IsScalar()) {
    if (parse_path(node.Scalar()))
      path(node.Scalar(), line, where, source.path);
    else
      problems_->add(line, where,
                     in_quotes(node.Scalar()) + " does not name a field: write {value: ...} for a value");
    return source;
  }
  YamlMap map(node, where, *problems_);
  if (!node.IsMap()) return source;
  const auto kind = kind_of(map);
  if (!kind) {
    map.allow_only(every_key());
    map.problem("", "has no source: give one of from, value, list and fields");
    return source;
  }
  source.kind = *kind;
  map.allow_only(keys_of(*kind));
  if (*kind == Source::Kind::kField) read_field(map, target, source);
  if (*kind == Source::Kind::kValue) read_value(map, target, source);
  if (*kind == Source::Kind::kList) read_list(map, target, depth, source);
  if (*kind == Source::Kind::kMessage) read_message(map, target, depth, source);
  return source;
}

void SourceReader::read_field(YamlMap& map, Target target, Source& source) {
  const auto text = map.find_text("from");
  if (!text) return;
  const PathEnd end = path(*text, map.find("from")->line, map.path("from"), source.path);
  read_options(map, target, end, source);
}

void SourceReader::read_options(YamlMap& map, Target target, const PathEnd& end, Source& source) {
  read_arithmetic(map, end, source);
  read_constants(map, target, end, source);
  read_relative(map, end, source);
  if (map.choice("overflow", {"refuse", "saturate"}) == 1) source.overflow = Overflow::kSaturate;
}

void SourceReader::read_arithmetic(YamlMap& map, const PathEnd& end, Source& source) {
  if (!map.has("scale") && !map.has("offset")) return;
  source.scale = map.number("scale", kFinite, 1.0);
  source.offset = map.number("offset", kFinite, 0.0);
  if (source.scale == 0.0) map.problem("scale", "must not be 0: use {value: ...} for a constant");
  if (end.field != nullptr && !is_arithmetic(end.field->primitive))
    map.problem(map.has("scale") ? "scale" : "offset",
                "is for numbers, but " + to_string(source.path) + " is " + to_string(*end.field));
}

void SourceReader::read_constants(YamlMap& map, Target target, const PathEnd& end, Source& source) {
  const Field key = end.field != nullptr ? element_of(*end.field) : Field{};
  const Field value = target.field != nullptr ? element_of(*target.field) : Field{};
  const Target key_target{end.field != nullptr ? &key : nullptr, end.owner};
  const Target value_target{target.field != nullptr ? &value : nullptr, target.owner};
  if (const auto* constants = map.find("map")) {
    const YamlMap pairs(constants->value, map.path("map"), *problems_);
    for (const auto& item : pairs.items()) {
      const std::string where = pairs.path(in_quotes(item.key));
      source.map.emplace_back(literal(YAML::Node(item.key), where, key_target, item.line),
                              literal(item.value, where, value_target, item.line));
    }
    if (pairs.items().empty() && constants->value.IsMap()) map.problem("map", "is empty: remove it");
  }
  if (const auto* otherwise = map.find("otherwise")) {
    const bool whole = end.field != nullptr && !source.map.empty() && target.field != nullptr &&
                       target.field->arity != Arity::kSingle;
    source.otherwise =
        literal(otherwise->value, map.path("otherwise"), whole ? value_target : target, otherwise->line);
    bool has_index = false;
    for (const PathStep& step : source.path) has_index = has_index || step.index.has_value();
    if (source.map.empty() && !has_index)
      map.problem("otherwise", "applies to a map or to an index beyond the end, but there is neither");
  }
}

void SourceReader::read_relative(YamlMap& map, const PathEnd& end, Source& source) {
  const auto text = map.find_text("relative_to");
  if (!text) return;
  const PathEnd pose =
      path(*text, map.find("relative_to")->line, map.path("relative_to"), source.relative_to);
  if (pose.field != nullptr &&
      (!is_pose(*pose.field) || (pose.field->arity != Arity::kSingle && !pose.element)))
    map.problem("relative_to", "must be a " + std::string(kPose) + ", but is " + to_string(*pose.field));
  if (end.field != nullptr && !is_pose(*end.field))
    map.problem("relative_to", "is for fields of " + std::string(kPose) + ", but " + to_string(source.path) +
                                   " is " + to_string(*end.field));
}

void SourceReader::read_value(YamlMap& map, Target target, Source& source) {
  const auto* item = map.find("value");
  source.value = literal(item->value, map.path("value"), target, item->line);
}

void SourceReader::read_list(YamlMap& map, Target target, int depth, Source& source) {
  const auto* list = map.find("list");
  if (!list->value.IsSequence()) {
    map.problem("list", "must be a list, not " + shown(list->value));
    return;
  }
  const Field element = target.field != nullptr ? element_of(*target.field) : Field{};
  const Target element_target{target.field != nullptr ? &element : nullptr, target.owner};
  for (const auto& item : list->value)
    source.list.push_back(
        read(item, map.path("list[" + std::to_string(source.list.size()) + "]"), element_target, depth + 1));
  if (target.field == nullptr) return;
  if (target.field->arity == Arity::kSingle)
    map.problem("list", "is for arrays, but the field is " + to_string(*target.field));
  else if (target.field->arity == Arity::kFixed && target.field->fixed_count != source.list.size())
    map.problem("list", "has " + std::to_string(source.list.size()) + " elements, but the field is " +
                            to_string(*target.field));
}

void SourceReader::read_message(YamlMap& map, Target target, int depth, Source& source) {
  const auto* fields = map.find("fields");
  const MessageSchema* message = nullptr;
  if (target.field != nullptr && target.field->primitive == Primitive::kMessage &&
      target.field->arity == Arity::kSingle)
    message = target.field->message.get();
  else if (target.field != nullptr)
    map.problem("fields", "is for one embedded message, but the field is " + to_string(*target.field));
  const YamlMap inner(fields->value, map.path("fields"), *problems_);
  for (const auto& item : inner.items()) {
    const Field* field = message != nullptr ? message->find(item.key) : nullptr;
    if (message != nullptr && field == nullptr)
      problems_->add(item.line, inner.path(),
                     message->type() + " has no field " + in_quotes(item.key) +
                         hint_for(item.key, field_names(*message)));
    source.fields.emplace_back(
        item.key, read(item.value, inner.path(in_quotes(item.key)), {field, message}, depth + 1));
  }
}

Literal SourceReader::literal(const YAML::Node& node, const std::string& where, Target target, int line) {
  const std::size_t before = problems_->size();
  Literal read = read_literal(node, where, *problems_, *budget_);
  if (target.field == nullptr || problems_->size() != before) return read;
  auto fitted = fit(read, *target.field, *target.owner);
  if (fitted) return std::move(*fitted);
  problems_->add(line, where, fitted.error().message);
  return read;
}

PathEnd SourceReader::path(const std::string& text, int line, const std::string& where, Path& path) {
  auto parsed = parse_path(text);
  if (!parsed) {
    problems_->add(line, where, parsed.error().message);
    return {};
  }
  path = std::move(*parsed);
  if (from_ == nullptr) return {};
  const auto end = resolve(path, *from_);
  if (end) return *end;
  problems_->add(line, where, end.error().message);
  return {};
}

}  // namespace extperfc::translate
