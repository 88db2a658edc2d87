#pragma once

#include <string>

#include "extperfc/translate/plan.hpp"

namespace extperfc::translate {

/// Bytes of values in order, as on the wire.
class Bytes {
 public:
  template <typename T>
  Bytes& put(T value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Bytes& text(const std::string& value) {
    put(static_cast<std::uint32_t>(value.size()));
    text_ += value;
    return *this;
  }
  Bytes& count(std::uint32_t value) { return put(value); }
  [[nodiscard]] const std::string& str() const { return text_; }

 private:
  std::string text_;
};

[[nodiscard]] inline ByteView view_of(const std::string& bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

[[nodiscard]] inline std::string string_of(const ByteBuffer& bytes) {
  return {bytes.data(), bytes.data() + bytes.size()};
}

/// The converted bytes, or "error: <message>".
[[nodiscard]] inline std::string converted(const Plan& plan, const std::string& message,
                                           std::int64_t shift_ns = 0) {
  ByteBuffer out;
  const auto done = plan.convert(view_of(message), out, shift_ns);
  return done ? string_of(out) : "error: " + done.error().message;
}

}  // namespace extperfc::translate
