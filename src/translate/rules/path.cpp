#include "translate/rules/path.hpp"

#include <charconv>

#include "extperfc/base/text.hpp"

namespace extperfc::translate {

namespace {

constexpr std::size_t kMaxSteps = 32;
constexpr std::size_t kMaxDigits = 9;

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// "name" or "name[12]" at the start of `text`, which loses it; nothing when it starts otherwise.
std::optional<PathStep> take_step(std::string_view& text) {
  std::size_t end = 0;
  while (end < text.size() && (is_letter(text[end]) || (end > 0 && is_digit(text[end])))) ++end;
  if (end == 0) return std::nullopt;
  PathStep step{std::string(text.substr(0, end)), std::nullopt};
  text.remove_prefix(end);
  if (text.empty() || text.front() != '[') return step;
  std::size_t digits = 0;
  while (digits + 1 < text.size() && is_digit(text[digits + 1])) ++digits;
  const std::size_t closing = digits + 1;
  if (digits == 0 || digits > kMaxDigits || closing >= text.size() || text[closing] != ']')
    return std::nullopt;
  std::size_t index = 0;
  std::from_chars(text.data() + 1, text.data() + closing, index);
  step.index = index;
  text.remove_prefix(closing + 1);
  return step;
}

Error no_field(const std::string& name, const MessageSchema& schema) {
  const std::string hint = hint_for(name, field_names(schema));
  return {ErrorCode::kNotFound,
          schema.type() + " has no field " + in_quotes(name) +
              (hint.empty() ? ": its fields are " + enumeration(field_names(schema)) : hint)};
}

Error bad_step(const PathStep& step, const std::string& why) {
  return {ErrorCode::kInvalidArgument, in_quotes(step.field) + " " + why};
}

/// What keeps this step from being taken; `last` when nothing follows it.
std::optional<Error> obstacle(const PathStep& step, const Field& field, bool last) {
  if (step.index && field.arity == Arity::kSingle) return bad_step(step, "is not an array: remove the index");
  if (step.index && field.arity == Arity::kFixed && *step.index >= field.fixed_count)
    return bad_step(step, "has " + std::to_string(field.fixed_count) + " elements, from index 0");
  if (last) return std::nullopt;
  if (field.primitive != Primitive::kMessage) return bad_step(step, "has no fields: end the path there");
  if (!step.index && field.arity != Arity::kSingle)
    return bad_step(step, "is an array: say which element, e.g. " + step.field + "[0]");
  return std::nullopt;
}

}  // namespace

Result<Path> parse_path(const std::string& text) {
  std::string_view rest = text;
  Path path;
  while (path.size() < kMaxSteps) {
    auto step = take_step(rest);
    if (!step) break;
    path.push_back(std::move(*step));
    if (rest.empty()) return path;
    if (rest.front() != '.') break;
    rest.remove_prefix(1);
  }
  return fail(ErrorCode::kInvalidArgument,
              in_quotes(text) + " is not a field path: write it like pose.position.x or names[0]");
}

Result<PathEnd> resolve(const Path& path, const MessageSchema& root) {
  PathEnd end{nullptr, &root, false};
  for (const PathStep& step : path) {
    if (end.field != nullptr) end.owner = end.field->message.get();
    end.field = end.owner->find(step.field);
    if (end.field == nullptr) return tl::unexpected<Error>(no_field(step.field, *end.owner));
    if (auto error = obstacle(step, *end.field, &step == &path.back())) return tl::unexpected<Error>(*error);
    end.element = step.index.has_value();
  }
  if (end.field == nullptr) return fail(ErrorCode::kInvalidArgument, "an empty path does not name a field");
  return end;
}

std::vector<std::string> field_names(const MessageSchema& schema) {
  std::vector<std::string> names;
  for (const Field& field : schema.fields()) names.push_back(field.name);
  return names;
}

}  // namespace extperfc::translate
