#include "translate/schema/tree_reader.hpp"

#include <array>
#include <unordered_set>

#include "translate/schema/catalogue.hpp"

namespace extperfc::translate {
namespace {

constexpr std::array<const char*, 7> kActionParts{"Goal",         "Result",         "Feedback", "ActionGoal",
                                                  "ActionResult", "ActionFeedback", "Action"};

}  // namespace

TreeReader::TreeReader(const PackageTree& tree, FindSchema elsewhere, const SchemaLimits& limits)
    : tree_(tree), elsewhere_(std::move(elsewhere)), limits_(limits) {
  for (const auto& file : tree_.files)
    if (file.kind == DefinitionKind::kMessage) index(file);
  for (const auto& file : tree_.files)
    if (file.kind == DefinitionKind::kAction) index(file);
}

void TreeReader::index(const DefinitionFile& file) {
  if (file.kind == DefinitionKind::kMessage) {
    files_.emplace(file.type, &file);
    return;
  }
  for (const auto* part : kActionParts) files_.emplace(file.type + part, &file);
}

TreeReader::Definitions TreeReader::read_all() {
  read_.problems = tree_.problems;
  std::unordered_set<std::string> seen;
  for (const auto& file : tree_.files) {
    // A package that appears twice counts once, as in an overlaid workspace.
    if (!seen.insert(to_string(file.kind) + file.type).second) continue;
    if (file.kind == DefinitionKind::kMessage) {
      if (auto schema = find(file.type)) read_.messages.push_back(std::move(schema));
    } else if (file.kind == DefinitionKind::kAction) {
      if (auto schema = read_action(file)) read_.actions.push_back(std::move(schema));
    } else {
      const auto text = read_text(file.path, limits_.text_bytes);
      const auto find_any = [this](const std::string& type) { return find(type); };
      if (!text)
        report(file, text.error().message);
      else if (auto schema = keep(file, parse_service(file.type, *text, find_any, limits_)))
        read_.services.push_back(std::move(schema));
    }
  }
  return std::move(read_);
}

SchemaPtr TreeReader::find(const std::string& type) {
  if (const auto known = messages_.find(type); known != messages_.end()) return known->second;
  const auto file = files_.find(type);
  if (file == files_.end()) return elsewhere_ ? elsewhere_(type) : nullptr;
  if (depth_ > limits_.depth) return nullptr;
  messages_.emplace(type, nullptr);  // found null when it embeds itself
  ++depth_;
  SchemaPtr schema;
  if (file->second->kind == DefinitionKind::kMessage) {
    schema = read_message(*file->second);
  } else if (const auto action = read_action(*file->second)) {
    for (const auto& message : messages_of(*action))
      if (message->type() == type) schema = message;
  }
  --depth_;
  messages_[type] = schema;
  return schema;
}

SchemaPtr TreeReader::read_message(const DefinitionFile& file) {
  const auto text = read_text(file.path, limits_.text_bytes);
  if (!text) {
    report(file, text.error().message);
    return nullptr;
  }
  return keep(file, parse_message(
                        file.type, *text, [this](const std::string& type) { return find(type); }, limits_));
}

ActionPtr TreeReader::read_action(const DefinitionFile& file) {
  if (const auto known = actions_.find(file.type); known != actions_.end()) return known->second;
  actions_.emplace(file.type, nullptr);
  const auto text = read_text(file.path, limits_.text_bytes);
  if (!text) {
    report(file, text.error().message);
    return nullptr;
  }
  auto action =
      keep(file, parse_action(
                     file.type, *text, [this](const std::string& type) { return find(type); }, limits_));
  actions_[file.type] = action;
  return action;
}

template <typename T>
T TreeReader::keep(const DefinitionFile& file, Result<T> parsed) {
  if (parsed) return *std::move(parsed);
  report(file, parsed.error().message);
  return nullptr;
}

void TreeReader::report(const DefinitionFile& file, const std::string& reason) {
  read_.problems.push_back(file.path.string() + ": " + reason);
}

}  // namespace extperfc::translate
