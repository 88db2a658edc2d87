#pragma once

#include <cstring>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "extperfc/translate/plan.hpp"

#include "translate/rules/literal.hpp"

namespace extperfc::translate {

/// A message written as YAML, e.g. "{target: 0.5, speed: 50}", as bytes; fields not named are zero or empty.
inline ByteBuffer encode(const SchemaPtr& schema, const std::string& yaml) {
  Problems problems("message");
  Budget budget;
  const Literal read = read_literal(YAML::Load(yaml), "", problems, budget);
  for (const auto& line : problems.lines()) ADD_FAILURE() << line;
  Field field;
  field.name = "message";
  field.written_type = schema->type();
  field.primitive = Primitive::kMessage;
  field.message = schema;
  const auto literal = fit(read, field, *schema);
  EXPECT_TRUE(literal) << literal.error().message;
  ByteBuffer bytes;
  if (literal) {
    EXPECT_TRUE(serialize(*literal, field, bytes));
  }
  return bytes;
}

/// Serialized messages as text, for comparisons that people can read. Stops at bytes that end early.
class MessageText {
 public:
  [[nodiscard]] static std::string of(const MessageSchema& schema, ByteView bytes) {
    MessageText text(bytes);
    text.message(schema, "");
    if (text.at_ != bytes.size) text.out_ << "(" << bytes.size - text.at_ << " bytes more)\n";
    return text.out_.str();
  }

 private:
  explicit MessageText(ByteView bytes) : bytes_(bytes) {}

  void message(const MessageSchema& schema, const std::string& path) {
    for (const Field& field : schema.fields()) {
      const std::string name = path + (path.empty() ? "" : ".") + field.name;
      if (field.arity == Arity::kSingle) {
        element(field, name);
        continue;
      }
      const auto count = field.arity == Arity::kFixed ? field.fixed_count : take<std::uint32_t>();
      out_ << name << ": " << count << " elements\n";
      for (std::uint32_t i = 0; i < count && at_ <= bytes_.size; ++i)
        element(field, name + "[" + std::to_string(i) + "]");
    }
  }

  void element(const Field& field, const std::string& name) {
    if (field.primitive == Primitive::kMessage) return message(*field.message, name);
    out_ << name << ": ";
    value(field.primitive);
    out_ << "\n";
  }

  void value(Primitive primitive) {
    switch (primitive) {
      case Primitive::kBool:
      case Primitive::kUint8:
        out_ << int{take<std::uint8_t>()};
        return;
      case Primitive::kInt8:
        out_ << int{take<std::int8_t>()};
        return;
      case Primitive::kInt16:
        out_ << take<std::int16_t>();
        return;
      case Primitive::kUint16:
        out_ << take<std::uint16_t>();
        return;
      case Primitive::kInt32:
        out_ << take<std::int32_t>();
        return;
      case Primitive::kUint32:
        out_ << take<std::uint32_t>();
        return;
      case Primitive::kInt64:
        out_ << take<std::int64_t>();
        return;
      case Primitive::kUint64:
        out_ << take<std::uint64_t>();
        return;
      case Primitive::kFloat32:
        out_ << take<float>();
        return;
      case Primitive::kFloat64:
        out_ << take<double>();
        return;
      case Primitive::kTime:
      case Primitive::kDuration:
        out_ << take<std::int32_t>() << "s ";
        out_ << take<std::int32_t>() << "ns";
        return;
      case Primitive::kString:
        string();
        return;
      case Primitive::kMessage:
        return;
    }
  }

  void string() {
    const auto size = take<std::uint32_t>();
    const auto left = at_ < bytes_.size ? bytes_.size - at_ : 0;
    out_ << '"'
         << std::string(reinterpret_cast<const char*>(bytes_.data) + at_, std::min<std::size_t>(size, left))
         << '"';
    at_ += size;
  }

  template <typename T>
  T take() {
    T number{};
    if (at_ + sizeof(T) <= bytes_.size) std::memcpy(&number, bytes_.data + at_, sizeof(T));
    at_ += sizeof(T);
    return number;
  }

  ByteView bytes_;
  std::size_t at_{0};
  std::ostringstream out_;
};

}  // namespace extperfc::translate
