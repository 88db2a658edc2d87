#include "test/unit/translate/plan/reference.hpp"

#include <cfloat>
#include <climits>
#include <cmath>
#include <cstring>

namespace extperfc::translate::reference {

namespace {

std::uint32_t number_at(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
  return value;
}

std::string number_bytes(std::uint32_t value) {
  std::string bytes;
  for (unsigned i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i));
  return bytes;
}

std::optional<std::string> take(std::string& rest, std::size_t size) {
  if (rest.size() < size) return std::nullopt;
  auto taken = rest.substr(0, size);
  rest.erase(0, size);
  return taken;
}

std::optional<Value> decode_element(const Field& field, std::string& rest) {
  if (field.primitive == Primitive::kMessage) return decode(*field.message, rest);
  std::size_t size = 0;
  if (field.primitive == Primitive::kString) {
    const auto count = take(rest, 4);
    if (!count) return std::nullopt;
    size = number_at(*count, 0);
  } else {
    size = size_of(field.primitive).value();
  }
  auto bytes = take(rest, size);
  if (!bytes) return std::nullopt;
  return Value{*bytes, {}};
}

std::optional<Value> decode_field(const Field& field, std::string& rest) {
  if (field.arity == Arity::kSingle) return decode_element(field, rest);
  std::size_t count = field.fixed_count;
  if (field.arity == Arity::kVariable) {
    const auto bytes = take(rest, 4);
    if (!bytes) return std::nullopt;
    count = number_at(*bytes, 0);
  }
  Value array;
  for (std::size_t i = 0; i < count; ++i) {
    auto one = decode_element(field, rest);
    if (!one) return std::nullopt;
    array.parts.push_back(std::move(*one));
  }
  return array;
}

void encode_element(const Field& field, const Value& value, std::string& out) {
  if (field.primitive == Primitive::kMessage) return encode(*field.message, value, out);
  if (field.primitive == Primitive::kString)
    out += number_bytes(static_cast<std::uint32_t>(value.bytes.size()));
  out += value.bytes;
}

void encode_field(const Field& field, const Value& value, std::string& out) {
  if (field.arity == Arity::kSingle) return encode_element(field, value, out);
  if (field.arity == Arity::kVariable) out += number_bytes(static_cast<std::uint32_t>(value.parts.size()));
  for (const auto& part : value.parts) encode_element(field, part, out);
}

Value zero(const MessageSchema& schema);

Value zero_element(const Field& field) {
  if (field.primitive == Primitive::kMessage) return zero(*field.message);
  return Value{std::string(size_of(field.primitive).value_or(0), '\0'), {}};
}

Value zero_field(const Field& field) {
  if (field.arity == Arity::kSingle) return zero_element(field);
  Value array;
  if (field.arity == Arity::kFixed) array.parts.assign(field.fixed_count, zero_element(field));
  return array;
}

Value zero(const MessageSchema& schema) {
  Value value;
  for (const auto& field : schema.fields()) value.parts.push_back(zero_field(field));
  return value;
}

template <typename T>
T as(const std::string& bytes) {
  T value{};
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

template <typename T>
std::string bytes_of(T value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

/// An extended double holds every value of every primitive.
long double read(Primitive primitive, const std::string& bytes) {
  switch (primitive) {
    case Primitive::kBool:
      return bytes[0] != 0 ? 1 : 0;
    case Primitive::kInt8:
      return as<std::int8_t>(bytes);
    case Primitive::kUint8:
      return as<std::uint8_t>(bytes);
    case Primitive::kInt16:
      return as<std::int16_t>(bytes);
    case Primitive::kUint16:
      return as<std::uint16_t>(bytes);
    case Primitive::kInt32:
      return as<std::int32_t>(bytes);
    case Primitive::kUint32:
      return as<std::uint32_t>(bytes);
    case Primitive::kInt64:
      return static_cast<long double>(as<std::int64_t>(bytes));
    case Primitive::kUint64:
      return static_cast<long double>(as<std::uint64_t>(bytes));
    case Primitive::kFloat32:
      return as<float>(bytes);
    default:
      return as<double>(bytes);
  }
}

template <typename T>
std::optional<std::string> whole(long double value, long double low, long double high) {
  if (std::isnan(value)) return std::nullopt;
  value = std::nearbyint(value);
  if (value < low || value > high) return std::nullopt;
  return bytes_of(static_cast<T>(value));
}

std::optional<std::string> write(Primitive primitive, long double value) {
  switch (primitive) {
    case Primitive::kBool:
      return whole<std::uint8_t>(value, 0, 1);
    case Primitive::kInt8:
      return whole<std::int8_t>(value, INT8_MIN, INT8_MAX);
    case Primitive::kUint8:
      return whole<std::uint8_t>(value, 0, UINT8_MAX);
    case Primitive::kInt16:
      return whole<std::int16_t>(value, INT16_MIN, INT16_MAX);
    case Primitive::kUint16:
      return whole<std::uint16_t>(value, 0, UINT16_MAX);
    case Primitive::kInt32:
      return whole<std::int32_t>(value, INT32_MIN, INT32_MAX);
    case Primitive::kUint32:
      return whole<std::uint32_t>(value, 0, UINT32_MAX);
    case Primitive::kInt64:
      return whole<std::int64_t>(value, static_cast<long double>(INT64_MIN),
                                 static_cast<long double>(INT64_MAX));
    case Primitive::kUint64:
      return whole<std::uint64_t>(value, 0, static_cast<long double>(UINT64_MAX));
    case Primitive::kFloat32:
      if (std::isfinite(value) && std::fabs(value) > static_cast<long double>(FLT_MAX)) return std::nullopt;
      return bytes_of(static_cast<float>(value));
    default:
      return bytes_of(static_cast<double>(value));
  }
}

std::string shift(const std::string& stamp, std::int64_t by_ns) {
  const std::uint32_t seconds = number_at(stamp, 0);
  const std::uint32_t rest = number_at(stamp, 4);
  if ((seconds == 0 && rest == 0) || by_ns == 0) return stamp;
  auto total = static_cast<long double>(seconds) * 1e9L + rest + static_cast<long double>(by_ns);
  const long double max_ns = 4294967295.0L * 1e9L + 999999999.0L;
  total = total < 0 ? 0 : total > max_ns ? max_ns : total;
  const auto whole_ns = static_cast<std::uint64_t>(total);
  return number_bytes(static_cast<std::uint32_t>(whole_ns / 1000000000U)) +
         number_bytes(static_cast<std::uint32_t>(whole_ns % 1000000000U));
}

struct Context {
  PlanOptions options;
  std::int64_t shift_ns;
};

std::optional<Value> pair_message(const MessageSchema& from, const MessageSchema& to, const Value& value,
                                  const Context& context);

std::string slashed(const std::string& name, PlanOptions::Slash slash) {
  if (slash == PlanOptions::Slash::kAdd) return name.empty() || name[0] == '/' ? name : "/" + name;
  return slash == PlanOptions::Slash::kStrip ? name.substr(std::min(name.find_first_not_of('/'), name.size()))
                                             : name;
}

std::optional<Value> pair_element(const Field& from, const Field& to, const Value& value,
                                  const Context& context) {
  if (from.primitive == Primitive::kMessage) return pair_message(*from.message, *to.message, value, context);
  if (from.primitive == Primitive::kTime && context.options.shift_times)
    return Value{shift(value.bytes, context.shift_ns), {}};
  const bool frame = to.name == "frame_id" || to.name == "child_frame_id";
  if (from.primitive == Primitive::kString && to.arity == Arity::kSingle && frame)
    return Value{slashed(value.bytes, context.options.frame_slash), {}};
  if (from.primitive == to.primitive) return value;
  auto bytes = write(to.primitive, read(from.primitive, value.bytes));
  if (!bytes) return std::nullopt;
  return Value{*bytes, {}};
}

std::optional<Value> pair_field(const Field& from, const Field& to, const Value& value,
                                const Context& context) {
  const bool from_text = from.primitive == Primitive::kString && from.arity == Arity::kSingle;
  const bool to_text = to.primitive == Primitive::kString && to.arity == Arity::kSingle;
  if (from.arity == Arity::kSingle && from_text == to_text) return pair_element(from, to, value, context);
  Value result;
  if (from_text) {
    for (const char c : value.bytes) result.parts.push_back({std::string(1, c), {}});
  } else if (to_text) {
    for (const auto& part : value.parts) result.bytes += part.bytes;
    return result;
  } else {
    for (const auto& part : value.parts) {
      auto one = pair_element(from, to, part, context);
      if (!one) return std::nullopt;
      result.parts.push_back(std::move(*one));
    }
  }
  if (to.arity == Arity::kFixed && result.parts.size() != to.fixed_count) return std::nullopt;
  return result;
}

std::optional<Value> pair_message(const MessageSchema& from, const MessageSchema& to, const Value& value,
                                  const Context& context) {
  Value result;
  for (const auto& field : to.fields()) {
    const auto* source = from.find(field.name);
    if (source == nullptr) {
      result.parts.push_back(zero_field(field));
      continue;
    }
    auto one = pair_field(*source, field,
                          value.parts[static_cast<std::size_t>(source - from.fields().data())], context);
    if (!one) return std::nullopt;
    result.parts.push_back(std::move(*one));
  }
  return result;
}

}  // namespace

std::optional<Value> decode(const MessageSchema& schema, std::string& rest) {
  Value value;
  for (const auto& field : schema.fields()) {
    auto one = decode_field(field, rest);
    if (!one) return std::nullopt;
    value.parts.push_back(std::move(*one));
  }
  return value;
}

void encode(const MessageSchema& schema, const Value& value, std::string& out) {
  for (std::size_t i = 0; i < schema.fields().size(); ++i)
    encode_field(schema.fields()[i], value.parts[i], out);
}

std::optional<std::string> convert(const MessageSchema& from, const MessageSchema& to,
                                   const std::string& message, const PlanOptions& options,
                                   std::int64_t shift_ns) {
  auto rest = message;
  const auto value = decode(from, rest);
  if (!value || !rest.empty()) return std::nullopt;
  const auto paired = pair_message(from, to, *value, {options, shift_ns});
  if (!paired) return std::nullopt;
  std::string out;
  encode(to, *paired, out);
  return out;
}

}  // namespace extperfc::translate::reference
