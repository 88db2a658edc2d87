#include "translate/schema/raw_definition.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <limits>
#include <optional>
#include <unordered_set>
#include <utility>

namespace extperfc::translate {
namespace {

struct Builtin {
  std::string_view name;
  Primitive primitive;
};
constexpr std::array<Builtin, 16> kBuiltins{{
    {"bool", Primitive::kBool},
    {"int8", Primitive::kInt8},
    {"uint8", Primitive::kUint8},
    {"int16", Primitive::kInt16},
    {"uint16", Primitive::kUint16},
    {"int32", Primitive::kInt32},
    {"uint32", Primitive::kUint32},
    {"int64", Primitive::kInt64},
    {"uint64", Primitive::kUint64},
    {"float32", Primitive::kFloat32},
    {"float64", Primitive::kFloat64},
    {"string", Primitive::kString},
    {"time", Primitive::kTime},
    {"duration", Primitive::kDuration},
    {"byte", Primitive::kInt8},
    {"char", Primitive::kUint8},
}};

std::optional<Primitive> find_builtin(std::string_view name) {
  for (const auto& builtin : kBuiltins)
    if (builtin.name == name) return builtin.primitive;
  return std::nullopt;
}

bool is_space(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r') || (c >= '\x1c' && c <= '\x1f');
}
bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

bool valid_name(std::string_view name) {
  return !name.empty() && is_letter(name.front()) && std::all_of(name.begin(), name.end(), [](char c) {
    return is_letter(c) || is_digit(c) || c == '_';
  });
}

std::string_view first_token(std::string_view text) {
  return text.substr(0, std::find_if(text.begin(), text.end(), is_space) - text.begin());
}

/// What a stranger wrote, short enough and without control characters, for an error's text.
std::string in_single_quotes(std::string_view text) {
  constexpr std::size_t kShown = 60;
  std::string shown = "'";
  for (const char c : text.substr(0, kShown)) shown += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  return shown + (text.size() > kShown ? "...'" : "'");
}

template <typename Integer>
bool holds(std::string_view digits) {
  Integer value{};
  const auto* end = digits.data() + digits.size();
  const auto read = std::from_chars(digits.data(), end, value);
  return read.ec == std::errc() && read.ptr == end;
}

bool is_number(const std::string& text) {
  if (text.find_first_of("xX") != std::string::npos) return false;  // strtod reads hexadecimal numbers
  char* end = nullptr;
  std::strtod(text.c_str(), &end);
  return !text.empty() && end == text.c_str() + text.size();
}

/// As genmsg judges it: the value must be one that the type can hold.
bool valid_constant(Primitive primitive, std::string_view value) {
  const auto digits =
      !value.empty() && value.front() == '+' && value.substr(0, 2) != "+-" ? value.substr(1) : value;
  switch (primitive) {
    case Primitive::kBool:
      return value == "True" || value == "False" || holds<std::int64_t>(digits);
    case Primitive::kInt8:
      return holds<std::int8_t>(digits);
    case Primitive::kUint8:
      return holds<std::uint8_t>(digits) || digits == "-0";
    case Primitive::kInt16:
      return holds<std::int16_t>(digits);
    case Primitive::kUint16:
      return holds<std::uint16_t>(digits) || digits == "-0";
    case Primitive::kInt32:
      return holds<std::int32_t>(digits);
    case Primitive::kUint32:
      return holds<std::uint32_t>(digits) || digits == "-0";
    case Primitive::kInt64:
      return holds<std::int64_t>(digits);
    case Primitive::kUint64:
      return holds<std::uint64_t>(digits) || digits == "-0";
    case Primitive::kFloat32:
    case Primitive::kFloat64:
      return is_number(std::string(value));
    case Primitive::kString:
      return true;
    case Primitive::kTime:
    case Primitive::kDuration:
    case Primitive::kMessage:
      return false;
  }
  return false;
}

/// Reads the lines of one definition; knows where it is, for errors.
class LineReader {
 public:
  LineReader(const std::string& type, std::size_t first_line, const SchemaLimits& limits)
      : type_(type), package_(package_of(type)), line_(first_line), limits_(limits) {}

  Result<void> read(std::string_view text) {
    for (; !text.empty(); ++line_) {
      const auto line = take_line(text);
      if (auto done = read_line(line); !done) return done;
    }
    return {};
  }
  RawDefinition take() { return std::move(raw_); }

 private:
  tl::unexpected<Error> refuse(const std::string& reason) const {
    return fail(ErrorCode::kCorrupt, type_ + " line " + std::to_string(line_) + ": " + reason);
  }

  Result<void> read_line(std::string_view line) {
    const auto code = strip(line.substr(0, line.find('#')));
    if (code.empty()) return {};
    if (raw_.fields.size() + raw_.constants.size() >= limits_.fields)
      return refuse("more than " + std::to_string(limits_.fields) +
                    " fields and constants in one definition");
    return code.find('=') == std::string_view::npos ? read_field(code) : read_constant(line, code);
  }

  Result<void> read_constant(std::string_view line, std::string_view code) {
    const auto written = first_token(code);
    const auto primitive = find_builtin(written);
    if (!primitive || *primitive == Primitive::kTime || *primitive == Primitive::kDuration)
      return refuse(in_single_quotes(written) +
                    " is not a type for a constant: use a number, bool or string");
    // A string goes to the end of the line: no comments there.
    const auto whole = *primitive == Primitive::kString ? line : code;
    const auto equals = whole.find('=');
    const auto name =
        strip(code.substr(written.size(), code.find('=') - std::min(written.size(), code.find('='))));
    const auto value = strip(whole.substr(equals + 1));
    if (!valid_name(name)) return refuse(in_single_quotes(name) + " is not a name for a constant");
    if (!valid_constant(*primitive, value))
      return refuse("constant " + std::string(name) + ": " + in_single_quotes(value) + " does not fit " +
                    std::string(written));
    raw_.constants.push_back({std::string(written), std::string(name), std::string(value)});
    return {};
  }

  Result<void> read_field(std::string_view code) {
    const auto written = first_token(code);
    const auto name = strip(code.substr(written.size()));
    if (name.empty()) return refuse("a field needs a type and a name, not only " + in_single_quotes(code));
    if (!valid_name(name)) return refuse(in_single_quotes(name) + " is not a name for a field");
    if (!names_.insert(std::string(name)).second)
      return refuse("field " + std::string(name) + " appears twice");
    RawField raw;
    raw.line = line_;
    raw.field.name = std::string(name);
    if (auto done = read_type(written, raw); !done) return done;
    raw_.fields.push_back(std::move(raw));
    return {};
  }

  Result<void> read_type(std::string_view written, RawField& raw) {
    const auto bracket = written.find('[');
    const auto base = written.substr(0, bracket);
    raw.field.written_type = std::string(base);
    if (bracket != std::string_view::npos)
      if (auto done = read_arity(written.substr(bracket), raw.field); !done) return done;
    if (const auto primitive = find_builtin(base)) {
      raw.field.primitive = *primitive;
      return {};
    }
    raw.field.primitive = Primitive::kMessage;
    // Only the single Header is the one of std_msgs; `Header[]` is the package's own, as in genmsg.
    if (base == "Header" && raw.field.arity == Arity::kSingle)
      raw.embedded = "std_msgs/Header";
    else if (base.find('/') == std::string_view::npos)
      raw.embedded = package_ + "/" + std::string(base);
    else
      raw.embedded = std::string(base);
    if (!valid_type_name(raw.embedded)) return refuse(in_single_quotes(base) + " is not a type name");
    return {};
  }

  Result<void> read_arity(std::string_view brackets, Field& field) {
    if (brackets == "[]") {
      field.arity = Arity::kVariable;
      return {};
    }
    const bool closed = brackets.size() > 2 && brackets.back() == ']';
    const auto digits = closed ? brackets.substr(1, brackets.size() - 2) : std::string_view();
    if (!holds<std::uint32_t>(digits) || (digits.size() > 1 && digits.front() == '0'))
      return refuse(in_single_quotes(brackets) + " is not an array: write [] or [count], one dimension");
    std::from_chars(digits.data(), digits.data() + digits.size(), field.fixed_count);
    field.arity = Arity::kFixed;
    if (field.fixed_count > limits_.fixed_count)
      return refuse("an array of " + std::string(digits) + " elements; the limit is " +
                    std::to_string(limits_.fixed_count));
    return {};
  }

  const std::string& type_;
  std::string package_;
  std::size_t line_;
  const SchemaLimits& limits_;
  RawDefinition raw_;
  std::unordered_set<std::string> names_;
};

}  // namespace

bool valid_type_name(std::string_view type) {
  constexpr std::size_t kLongest = 200;
  const auto slash = type.find('/');
  return type.size() <= kLongest && slash != std::string_view::npos && valid_name(type.substr(0, slash)) &&
         valid_name(type.substr(slash + 1));
}

std::string package_of(std::string_view type) {
  return std::string(type.substr(0, type.find('/')));
}

std::string_view strip(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::string_view take_line(std::string_view& rest) {
  const auto end = rest.find_first_of("\r\n");
  const auto line = rest.substr(0, end);
  if (end == std::string_view::npos) {
    rest = {};
    return line;
  }
  rest.remove_prefix(end + (rest.substr(end, 2) == "\r\n" ? 2 : 1));
  return line;
}

std::vector<TextPart> split_at_dashes(std::string_view text) {
  std::vector<TextPart> parts{{text.substr(0, 0), 1}};
  const char* begin = text.data();
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto line = take_line(text);
    if (line.substr(0, 3) == "---") {
      parts.push_back({text.substr(0, 0), number + 1});
      begin = text.data();
    } else {
      parts.back().text =
          std::string_view(begin, static_cast<std::size_t>(line.data() + line.size() - begin));
    }
  }
  return parts;
}

Result<RawDefinition> parse_lines(const std::string& type, const TextPart& part, const SchemaLimits& limits) {
  if (!valid_type_name(type))
    return fail(ErrorCode::kInvalidArgument,
                in_single_quotes(type) + " is not a type name: write package/Name");
  if (part.text.size() > limits.text_bytes)
    return fail(ErrorCode::kCorrupt, type + ": a definition of " + std::to_string(part.text.size()) +
                                         " bytes; the limit is " + std::to_string(limits.text_bytes));
  LineReader reader(type, part.first_line, limits);
  if (auto done = reader.read(part.text); !done) return tl::unexpected(done.error());
  return reader.take();
}

namespace {

tl::unexpected<Error> not_known(const std::string& type, std::size_t line, const std::string& field,
                                const std::string& embedded) {
  return fail(ErrorCode::kNotFound, type + " line " + std::to_string(line) + ": field " + field + " embeds " +
                                        embedded + ", whose definition is not known");
}

}  // namespace

Result<SchemaPtr> resolve(const std::string& type, RawDefinition raw, const FindSchema& find,
                          const SchemaLimits& limits) {
  std::vector<Field> fields;
  fields.reserve(raw.fields.size());
  for (auto& [field, embedded, line] : raw.fields) {
    if (field.primitive == Primitive::kMessage) {
      field.message = find ? find(embedded) : nullptr;
      if (!field.message) return not_known(type, line, field.name, embedded);
    }
    fields.push_back(std::move(field));
  }
  auto schema = std::make_shared<const MessageSchema>(type, std::move(fields), std::move(raw.constants));
  if (schema->depth() > limits.depth)
    return fail(ErrorCode::kCorrupt,
                type + ": embeds more than " + std::to_string(limits.depth) + " definitions in one another");
  if (schema->expanded_fields() > limits.expanded_fields)
    return fail(ErrorCode::kCorrupt, type + ": has more than " + std::to_string(limits.expanded_fields) +
                                         " fields with those of the definitions that it embeds");
  if (schema->min_size() > std::numeric_limits<std::uint32_t>::max())
    return fail(ErrorCode::kCorrupt, type + ": its fixed arrays are longer than any message (4 GiB)");
  return schema;
}

}  // namespace extperfc::translate
