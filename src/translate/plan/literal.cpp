#include <charconv>
#include <cstring>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "extperfc/translate/plan.hpp"

#include "translate/plan/field_size.hpp"
#include "translate/plan/numbers.hpp"

namespace extperfc::translate {

namespace {

constexpr std::size_t kMaxBytes = 0xFFFFFFFF;  // of a message: its length is a uint32

tl::unexpected<Error> refuse(const std::string& text, const Field& field) {
  return fail(ErrorCode::kInvalidArgument, "'" + text + "' is not a value of " + to_string(field));
}

template <typename T>
std::optional<T> parse_whole(std::string_view text, int base) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc() || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

/// Appends a number given in one primitive as another; false when it does not fit.
template <typename T>
bool append_as(Primitive from, Primitive to, T value, ByteBuffer& out) {
  std::uint8_t bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof value);
  return convert_numbers(from, to, false, bytes, out.extend(*size_of(to)), 1) == 1;
}

bool append_integer(std::string_view text, Primitive to, ByteBuffer& out) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  if (text.substr(0, 2) == "0x" || text.substr(0, 2) == "0X") {
    const auto value = parse_whole<std::uint64_t>(text.substr(2), 16);
    return value && append_as(Primitive::kUint64, to, *value, out);
  }
  if (const auto value = parse_whole<std::int64_t>(text, 10))
    return append_as(Primitive::kInt64, to, *value, out);
  const auto value = parse_whole<std::uint64_t>(text, 10);
  return value && append_as(Primitive::kUint64, to, *value, out);
}

bool append_floating(std::string_view text, Primitive to, ByteBuffer& out) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || text.empty()) return false;
  return append_as(Primitive::kFloat64, to, value, out);
}

bool append_bool(std::string_view text, ByteBuffer& out) {
  const bool yes = text == "true" || text == "True" || text == "1";
  const bool no = text == "false" || text == "False" || text == "0";
  *out.extend(1) = yes ? 1 : 0;
  return yes || no;
}

/// "-1.25" s as nanoseconds, exactly.
std::optional<std::int64_t> parse_seconds(std::string_view text) {
  const bool negative = !text.empty() && text.front() == '-';
  if (negative) text.remove_prefix(1);
  const auto point = text.find('.');
  std::string fraction(point == std::string_view::npos ? "" : text.substr(point + 1));
  if (fraction.size() > 9) return std::nullopt;
  fraction.resize(9, '0');
  const auto seconds = parse_whole<std::uint32_t>(text.substr(0, point), 10);
  const auto rest = parse_whole<std::uint32_t>(fraction, 10);
  if (!seconds || !rest) return std::nullopt;
  const auto whole = static_cast<std::int64_t>(*seconds) * kNanosecondsPerSecond + *rest;
  return negative ? -whole : whole;
}

bool append_stamp(std::string_view text, Primitive to, ByteBuffer& out) {
  const auto whole = parse_seconds(text);
  if (!whole) return false;
  const auto rest = (*whole % kNanosecondsPerSecond + kNanosecondsPerSecond) % kNanosecondsPerSecond;
  const auto seconds = (*whole - rest) / kNanosecondsPerSecond;
  const auto half = to == Primitive::kTime ? Primitive::kUint32 : Primitive::kInt32;
  return append_as(Primitive::kInt64, half, seconds, out) && append_as(Primitive::kInt64, half, rest, out);
}

bool append_scalar(const std::string& text, Primitive to, ByteBuffer& out) {
  if (to == Primitive::kString) {
    const auto size = static_cast<std::uint32_t>(text.size());
    out.append(&size, sizeof size);
    out.append(text.data(), text.size());
    return text.size() <= kMaxBytes;
  }
  if (to == Primitive::kBool) return append_bool(text, out);
  if (to == Primitive::kFloat32 || to == Primitive::kFloat64) return append_floating(text, to, out);
  if (to == Primitive::kTime || to == Primitive::kDuration) return append_stamp(text, to, out);
  return is_number(to) && append_integer(text, to, out);
}

Result<void> append_value(const Literal& value, const Field& field, ByteBuffer& out);

Result<void> append_list(const Literal& value, const Field& field, ByteBuffer& out) {
  if (value.kind != Literal::Kind::kList)
    return fail(ErrorCode::kInvalidArgument, to_string(field) + " takes a list");
  const auto count = static_cast<std::uint32_t>(value.list.size());
  if (field.arity == Arity::kVariable) out.append(&count, sizeof count);
  if (field.arity == Arity::kFixed && count != field.fixed_count)
    return fail(ErrorCode::kInvalidArgument, to_string(field) + " takes exactly that many elements, " +
                                                 std::to_string(count) + " are given");
  const Field element = element_of(field);
  for (const auto& item : value.list)
    if (auto done = append_value(item, element, out); !done) return done;
  return {};
}

Result<void> append_fields(const Literal& value, const MessageSchema& schema, ByteBuffer& out) {
  for (const auto& [name, inner] : value.fields)
    if (schema.find(name) == nullptr)
      return fail(ErrorCode::kNotFound, schema.type() + " has no field " + name);
  for (const auto& field : schema.fields()) {
    const Literal* given = nullptr;
    for (const auto& [name, inner] : value.fields)
      if (name == field.name) given = &inner;
    if (given != nullptr) {
      if (auto done = append_value(*given, field, out); !done) return done;
      continue;
    }
    const auto size = min_size(field);
    if (size > kMaxBytes) return fail(ErrorCode::kUnsupported, to_string(field) + " exceeds 4 GiB");
    if (size != 0) std::memset(out.extend(size), 0, size);
  }
  return {};
}

Result<void> append_value(const Literal& value, const Field& field, ByteBuffer& out) {
  if (field.arity != Arity::kSingle) return append_list(value, field, out);
  if (field.primitive == Primitive::kMessage) {
    if (value.kind != Literal::Kind::kFields)
      return fail(ErrorCode::kInvalidArgument, to_string(field) + " takes fields, e.g. {x: 1, y: 2}");
    return append_fields(value, *field.message, out);
  }
  if (value.kind != Literal::Kind::kScalar)
    return fail(ErrorCode::kInvalidArgument, to_string(field) + " takes a single value");
  if (!append_scalar(value.scalar, field.primitive, out)) return refuse(value.scalar, field);
  return {};
}

}  // namespace

Result<void> serialize(const Literal& value, const Field& field, ByteBuffer& out) {
  const auto before = out.size();
  auto done = append_value(value, field, out);
  if (!done) out.resize(before);
  return done;
}

void serialize_default(const MessageSchema& schema, ByteBuffer& out) {
  const auto size = schema.min_size();  // zero numbers, empty strings and empty arrays: all bytes are zero
  if (size > kMaxBytes) throw std::length_error(schema.type() + " exceeds 4 GiB");
  if (size != 0) std::memset(out.extend(size), 0, size);
}

}  // namespace extperfc::translate
