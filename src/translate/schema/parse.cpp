#include <algorithm>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>

#include "extperfc/base/md5.hpp"
#include "extperfc/translate/schema.hpp"

#include "translate/schema/raw_definition.hpp"

namespace extperfc::translate {
namespace {

/// Embedded definitions are divided by a line of 80 '='; shorter ones are taken too.
bool is_divider(std::string_view line) {
  const auto bare = strip(line);
  return bare.size() >= 10 && bare.find_first_not_of('=') == std::string_view::npos;
}

/// The definitions of a full text: the first is the one asked for.
struct NamedPart {
  std::string type;
  TextPart part;
};

/// Reads "MSG: package/Name", the first line after a divider.
Result<NamedPart> read_title(const std::string& owner, std::string_view& rest, std::size_t line) {
  const auto title = strip(take_line(rest));
  const auto name = title.substr(0, 4) == "MSG:" ? strip(title.substr(4)) : std::string_view();
  if (!valid_type_name(name))
    return fail(ErrorCode::kCorrupt,
                owner + " line " + std::to_string(line) +
                    ": after a line of '=' comes 'MSG: package/Name' of an embedded definition");
  return NamedPart{std::string(name), {rest.substr(0, 0), line + 1}};
}

Result<std::vector<NamedPart>> split_full_text(const std::string& type, std::string_view rest,
                                               const SchemaLimits& limits) {
  std::vector<NamedPart> parts{{type, {rest.substr(0, 0), 1}}};
  const char* begin = rest.data();
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const auto line = take_line(rest);
    if (!is_divider(line)) {
      parts.back().part.text = {begin, static_cast<std::size_t>(line.data() + line.size() - begin)};
      continue;
    }
    if (parts.size() >= limits.definitions)
      return fail(ErrorCode::kCorrupt,
                  type + ": more than " + std::to_string(limits.definitions) + " definitions in one text");
    auto title = read_title(type, rest, ++number);
    if (!title) return tl::unexpected(title.error());
    parts.push_back(std::move(*title));
    begin = rest.data();
  }
  return parts;
}

/// Makes schemas of the parts of one full text, on demand; every type once.
class FullText {
 public:
  explicit FullText(const SchemaLimits& limits) : limits_(limits) {}

  Result<void> add(const NamedPart& part) {
    const auto [known, is_new] = texts_.emplace(part.type, part.part);
    if (!is_new && strip(known->second.text) != strip(part.part.text))
      return fail(ErrorCode::kCorrupt, part.type + " line " + std::to_string(part.part.first_line) +
                                           ": is defined twice in one text, and differently");
    return {};
  }

  Result<SchemaPtr> build(const std::string& type) {
    if (const auto known = done_.find(type); known != done_.end()) return known->second;
    const auto text = texts_.find(type);
    if (text == texts_.end())
      return fail(ErrorCode::kNotFound, type + " is embedded, but the text does not hold its definition");
    if (std::find(open_.begin(), open_.end(), type) != open_.end())
      return fail(ErrorCode::kCorrupt, type + " embeds itself");
    if (open_.size() > limits_.depth)
      return fail(ErrorCode::kCorrupt,
                  type + ": more than " + std::to_string(limits_.depth) + " definitions embed one another");
    auto raw = parse_lines(type, text->second, limits_);
    if (!raw) return tl::unexpected(raw.error());
    open_.push_back(type);
    for (const auto& field : raw->fields) {
      if (field.embedded.empty()) continue;
      if (auto embedded = build(field.embedded); !embedded) return embedded;
    }
    open_.pop_back();
    auto schema = resolve(
        type, std::move(*raw), [&](const std::string& name) { return done_.at(name); }, limits_);
    if (schema) done_.emplace(type, *schema);
    return schema;
  }

 private:
  const SchemaLimits& limits_;
  std::unordered_map<std::string, TextPart> texts_;
  std::unordered_map<std::string, SchemaPtr> done_;
  std::vector<std::string> open_;
};

Result<void> check_size(const std::string& type, std::string_view text, const SchemaLimits& limits) {
  if (!valid_type_name(type))
    return fail(ErrorCode::kInvalidArgument,
                "'" + type.substr(0, 60) + "' is not a type name: write package/Name");
  if (text.size() <= limits.text_bytes) return {};
  return fail(ErrorCode::kCorrupt, type + ": a definition of " + std::to_string(text.size()) +
                                       " bytes; the limit is " + std::to_string(limits.text_bytes));
}

Result<SchemaPtr> parse_part(const std::string& type, const TextPart& part, const FindSchema& find,
                             const SchemaLimits& limits) {
  auto raw = parse_lines(type, part, limits);
  if (!raw) return tl::unexpected(raw.error());
  return resolve(type, std::move(*raw), find, limits);
}

/// The messages that every action has, built from the three of its definition.
class ActionBuilder {
 public:
  ActionBuilder(const std::string& type, const FindSchema& find, const SchemaLimits& limits)
      : type_(type), name_(type.substr(type.find('/') + 1)), find_(find), limits_(limits) {}

  /// E.g. "Goal" with "goal_id" of actionlib_msgs/GoalID.
  Result<SchemaPtr> wrap(const std::string& part, const std::string& stamp, const SchemaPtr& content) {
    const auto field = static_cast<char>(part.front() - 'A' + 'a') + part.substr(1);
    return build("Action" + part, "Header header\n" + stamp + "\n" + name_ + part + " " + field + "\n",
                 {content});
  }
  Result<SchemaPtr> build(const std::string& part, const std::string& text,
                          const std::vector<SchemaPtr>& own) {
    const auto find = [&](const std::string& wanted) -> SchemaPtr {
      for (const auto& schema : own)
        if (schema->type() == wanted) return schema;
      return find_ ? find_(wanted) : nullptr;
    };
    return parse_part(type_ + part, {text, 1}, find, limits_);
  }
  Result<ActionPtr> derive(SchemaPtr goal, SchemaPtr result, SchemaPtr feedback) {
    ActionSchema action{type_, std::move(goal), std::move(result), std::move(feedback), {}, {}, {}, {}};
    auto action_goal = wrap("Goal", "actionlib_msgs/GoalID goal_id", action.goal);
    auto action_result = wrap("Result", "actionlib_msgs/GoalStatus status", action.result);
    auto action_feedback = wrap("Feedback", "actionlib_msgs/GoalStatus status", action.feedback);
    for (const auto* made : {&action_goal, &action_result, &action_feedback})
      if (!*made) return tl::unexpected(made->error());
    auto whole = build("Action",
                       name_ + "ActionGoal action_goal\n" + name_ + "ActionResult action_result\n" + name_ +
                           "ActionFeedback action_feedback\n",
                       {*action_goal, *action_result, *action_feedback});
    if (!whole) return tl::unexpected(whole.error());
    action.action_goal = *action_goal;
    action.action_result = *action_result;
    action.action_feedback = *action_feedback;
    action.action = *whole;
    return std::make_shared<const ActionSchema>(std::move(action));
  }

 private:
  const std::string& type_;
  std::string name_;
  const FindSchema& find_;
  const SchemaLimits& limits_;
};

}  // namespace

Result<SchemaPtr> parse_message(const std::string& type, std::string_view text, const FindSchema& find,
                                const SchemaLimits& limits) {
  if (auto fits = check_size(type, text, limits); !fits) return tl::unexpected(fits.error());
  return parse_part(type, {text, 1}, find, limits);
}

Result<SchemaPtr> parse_full_text(const std::string& type, std::string_view full_text,
                                  const SchemaLimits& limits) {
  if (auto fits = check_size(type, full_text, limits); !fits) return tl::unexpected(fits.error());
  const auto parts = split_full_text(type, full_text, limits);
  if (!parts) return tl::unexpected(parts.error());
  FullText text(limits);
  for (const auto& part : *parts)
    if (auto added = text.add(part); !added) return tl::unexpected(added.error());
  return text.build(type);
}

Result<ServicePtr> parse_service(const std::string& type, std::string_view text, const FindSchema& find,
                                 const SchemaLimits& limits) {
  if (auto fits = check_size(type, text, limits); !fits) return tl::unexpected(fits.error());
  const auto parts = split_at_dashes(text);
  if (parts.size() != 2)
    return fail(ErrorCode::kCorrupt,
                type + ": a service has a request and a response, divided by one line '---'; " +
                    std::to_string(parts.size() - 1) + " such lines found");
  auto request = parse_part(type + "Request", parts[0], find, limits);
  if (!request) return tl::unexpected(request.error());
  auto response = parse_part(type + "Response", parts[1], find, limits);
  if (!response) return tl::unexpected(response.error());
  auto md5 = md5_hex(md5_text(**request) + md5_text(**response));
  return std::make_shared<const ServiceSchema>(ServiceSchema{type, std::move(md5), *request, *response});
}

Result<ActionPtr> parse_action(const std::string& type, std::string_view text, const FindSchema& find,
                               const SchemaLimits& limits) {
  if (auto fits = check_size(type, text, limits); !fits) return tl::unexpected(fits.error());
  const auto parts = split_at_dashes(text);
  if (parts.size() != 3)
    return fail(ErrorCode::kCorrupt,
                type + ": an action has goal, result and feedback, divided by two lines '---'; " +
                    std::to_string(parts.size() - 1) + " such lines found");
  auto goal = parse_part(type + "Goal", parts[0], find, limits);
  if (!goal) return tl::unexpected(goal.error());
  auto result = parse_part(type + "Result", parts[1], find, limits);
  if (!result) return tl::unexpected(result.error());
  auto feedback = parse_part(type + "Feedback", parts[2], find, limits);
  if (!feedback) return tl::unexpected(feedback.error());
  return ActionBuilder(type, find, limits).derive(*goal, *result, *feedback);
}

Result<std::vector<std::string>> embedded_types(const std::string& type, std::string_view text) {
  const SchemaLimits limits;
  if (auto fits = check_size(type, text, limits); !fits) return tl::unexpected(fits.error());
  std::vector<std::string> found;
  for (const auto& part : split_at_dashes(text)) {
    const auto raw = parse_lines(type, part, limits);
    if (!raw) return tl::unexpected(raw.error());
    for (const auto& field : raw->fields)
      if (!field.embedded.empty() && std::find(found.begin(), found.end(), field.embedded) == found.end())
        found.push_back(field.embedded);
  }
  return found;
}

}  // namespace extperfc::translate
