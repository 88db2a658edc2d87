#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "extperfc/base/rng.hpp"
#include "extperfc/translate/bytes.hpp"
#include "extperfc/translate/schema.hpp"

namespace extperfc::translate {

/// How large and how odd random messages are.
struct RandomMessageParams {
  int max_elements{4};    ///< of a variable array; fewer the deeper it is embedded
  int max_characters{9};  ///< of a string
  /// Numbers of any bits (also NaN, infinities and the extremes) instead of small whole ones, as a
  /// probability.
  double wild{0.3};
};

/// Serialized messages with random content, for tests: the same sequence for the same seed.
class RandomMessage {
 public:
  explicit RandomMessage(Rng& rng, RandomMessageParams params = {}) : rng_(rng), params_(params) {}

  [[nodiscard]] ByteBuffer make(const MessageSchema& schema) {
    ByteBuffer out;
    append(schema, out, 0);
    return out;
  }

 private:
  void append(const MessageSchema& schema, ByteBuffer& out, int depth) {
    for (const auto& field : schema.fields()) append(field, out, depth);
  }

  void append(const Field& field, ByteBuffer& out, int depth) {
    std::uint32_t count = field.arity == Arity::kFixed ? field.fixed_count : 1;
    if (field.arity == Arity::kVariable) {
      count = static_cast<std::uint32_t>(rng_.integer(0, std::max(1, params_.max_elements - depth)));
      out.append(&count, sizeof count);
    }
    for (std::uint32_t i = 0; i < count; ++i) append_element(field, out, depth);
  }

  void append_element(const Field& field, ByteBuffer& out, int depth) {
    switch (field.primitive) {
      case Primitive::kMessage:
        return append(*field.message, out, depth + 1);
      case Primitive::kString:
        return append_string(out);
      case Primitive::kBool:
        return append_as<std::uint8_t>(out, rng_.chance(0.5) ? 1 : 0);
      case Primitive::kTime:
      case Primitive::kDuration:
        return append_stamp(out);
      case Primitive::kFloat32:
        return rng_.chance(params_.wild) ? append_bits(out, 4) : append_as<float>(out, small() / 4.0);
      case Primitive::kFloat64:
        return rng_.chance(params_.wild) ? append_bits(out, 8) : append_as<double>(out, small() / 4.0);
      default:
        return append_integer(out, size_of(field.primitive).value_or(1));
    }
  }

  [[nodiscard]] int small() { return rng_.integer(0, 100); }

  template <typename T>
  void append_as(ByteBuffer& out, double value) {
    const auto typed = static_cast<T>(value);
    out.append(&typed, sizeof typed);
  }

  void append_bits(ByteBuffer& out, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) *out.extend(1) = static_cast<std::uint8_t>(rng_.integer(0, 255));
  }

  void append_integer(ByteBuffer& out, std::size_t size) {
    if (rng_.chance(params_.wild)) return append_bits(out, size);
    const std::uint64_t value = static_cast<std::uint64_t>(small());
    out.append(&value, size);
  }

  void append_string(ByteBuffer& out) {
    const auto size = static_cast<std::uint32_t>(rng_.integer(0, params_.max_characters));
    out.append(&size, sizeof size);
    if (rng_.chance(0.8)) {
      for (std::uint32_t i = 0; i < size; ++i)
        *out.extend(1) = static_cast<std::uint8_t>("/abcdefgh_"[rng_.integer(0, 9)]);
    } else {
      append_bits(out, size);  // strings are opaque bytes, not always UTF-8
    }
  }

  void append_stamp(ByteBuffer& out) {
    if (rng_.chance(0.2)) return append_as<std::uint64_t>(out, 0);
    if (rng_.chance(params_.wild)) return append_bits(out, 8);
    append_as<std::uint32_t>(out, rng_.integer(0, 2'000'000'000));
    append_as<std::uint32_t>(out, rng_.integer(0, 999'999'999));
  }

  Rng& rng_;
  RandomMessageParams params_;
};

}  // namespace extperfc::translate
