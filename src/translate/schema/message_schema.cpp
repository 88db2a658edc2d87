#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <unordered_set>
#include <utility>

#include "extperfc/base/md5.hpp"
#include "extperfc/translate/schema.hpp"

#include "translate/schema/raw_definition.hpp"

namespace extperfc::translate {
namespace {

constexpr std::size_t kMax = std::numeric_limits<std::size_t>::max();

/// Both saturate at kMax: counts come from strangers.
std::size_t add(std::size_t a, std::size_t b) {
  return a > kMax - b ? kMax : a + b;
}
std::size_t multiply(std::size_t a, std::size_t b) {
  return b != 0 && a > kMax / b ? kMax : a * b;
}

struct Size {
  std::size_t min{0};
  bool fixed{true};
};

Size size_of_element(const Field& field) {
  if (field.primitive == Primitive::kMessage)
    return {field.message->min_size(), field.message->fixed_size().has_value()};
  if (const auto size = size_of(field.primitive)) return {*size, true};
  return {sizeof(std::uint32_t), false};  // a string's length
}

Size size_of_field(const Field& field) {
  if (field.arity == Arity::kVariable) return {sizeof(std::uint32_t), false};
  auto size = size_of_element(field);
  if (field.arity == Arity::kFixed) {
    size.min = multiply(size.min, field.fixed_count);
    size.fixed = size.fixed || field.fixed_count == 0;
  }
  return size;
}

std::string brackets(const Field& field) {
  if (field.arity == Arity::kSingle) return "";
  if (field.arity == Arity::kVariable) return "[]";
  return "[" + std::to_string(field.fixed_count) + "]";
}

/// What is embedded, each once, in the order of the first use, depth first: the order of genmsg.
void collect(const MessageSchema& schema, std::vector<const MessageSchema*>& found,
             std::unordered_set<std::string>& seen) {
  for (const auto& field : schema.fields()) {
    if (!field.message || !seen.insert(field.message->type()).second) continue;
    found.push_back(field.message.get());
    collect(*field.message, found, seen);
  }
}

}  // namespace

std::string md5_text(const MessageSchema& schema) {
  std::string text;
  for (const auto& constant : schema.constants())
    text += constant.written_type + " " + constant.name + "=" + constant.value + "\n";
  for (const auto& field : schema.fields())
    text += (field.message ? field.message->md5() : field.written_type + brackets(field)) + " " + field.name +
            "\n";
  return std::string(strip(text));
}

MessageSchema::MessageSchema(std::string type, std::vector<Field> fields, std::vector<Constant> constants)
    : type_(std::move(type)), fields_(std::move(fields)), constants_(std::move(constants)) {
  bool fixed = true;
  for (const auto& field : fields_) {
    const auto size = size_of_field(field);
    min_size_ = add(min_size_, size.min);
    fixed = fixed && size.fixed;
    has_time_ =
        has_time_ || field.primitive == Primitive::kTime || (field.message && field.message->has_time());
    expanded_fields_ = add(expanded_fields_, field.message ? add(field.message->expanded_fields(), 1) : 1);
    if (field.message) depth_ = std::max(depth_, field.message->depth() + 1);
  }
  if (fixed && min_size_ != kMax) fixed_size_ = min_size_;
  md5_ = md5_hex(md5_text(*this));
}

const Field* MessageSchema::find(std::string_view field_name) const {
  const auto found = std::find_if(fields_.begin(), fields_.end(),
                                  [&](const Field& field) { return field.name == field_name; });
  return found == fields_.end() ? nullptr : &*found;
}

std::string MessageSchema::text() const {
  std::string text;
  for (const auto& constant : constants_)
    text += constant.written_type + " " + constant.name + "=" + constant.value + "\n";
  for (const auto& field : fields_) text += to_string(field) + "\n";
  return text;
}

std::string MessageSchema::full_text() const {
  std::vector<const MessageSchema*> found;
  std::unordered_set<std::string> seen;
  collect(*this, found, seen);
  auto text = this->text();
  for (const auto* schema : found)
    text += std::string(80, '=') + "\nMSG: " + schema->type() + "\n" + schema->text();
  return text;
}

bool same_layout(const MessageSchema& a, const MessageSchema& b) {
  if (&a == &b) return true;
  const auto equal = [](const Field& left, const Field& right) {
    return left.name == right.name && left.primitive == right.primitive && left.arity == right.arity &&
           left.fixed_count == right.fixed_count &&
           (left.primitive != Primitive::kMessage || same_layout(*left.message, *right.message));
  };
  return std::equal(a.fields().begin(), a.fields().end(), b.fields().begin(), b.fields().end(), equal);
}

const char* to_string(Primitive primitive) {
  static constexpr std::array<const char*, 15> kNames{"bool",    "int8",   "uint8", "int16",    "uint16",
                                                      "int32",   "uint32", "int64", "uint64",   "float32",
                                                      "float64", "string", "time",  "duration", "message"};
  const auto index = static_cast<std::size_t>(primitive);
  return index < kNames.size() ? kNames.at(index) : "unknown";
}

std::string to_string(const Field& field) {
  return field.written_type + brackets(field) + " " + field.name;
}

std::optional<std::size_t> size_of(Primitive primitive) {
  switch (primitive) {
    case Primitive::kBool:
    case Primitive::kInt8:
    case Primitive::kUint8:
      return 1;
    case Primitive::kInt16:
    case Primitive::kUint16:
      return 2;
    case Primitive::kInt32:
    case Primitive::kUint32:
    case Primitive::kFloat32:
      return 4;
    case Primitive::kInt64:
    case Primitive::kUint64:
    case Primitive::kFloat64:
    case Primitive::kTime:
    case Primitive::kDuration:
      return 8;
    case Primitive::kString:
    case Primitive::kMessage:
      return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace extperfc::translate
