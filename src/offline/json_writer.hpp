#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace extperfc::offline {

/// Writes one JSON text, value by value. Numbers that are not finite become null.
class JsonWriter {
 public:
  void begin_object(std::string_view key = {}) { open(key, '{'); }
  void end_object() { close('}'); }
  void begin_array(std::string_view key = {}) { open(key, '['); }
  void end_array() { close(']'); }

  void number(std::string_view key, double value);
  void count(std::string_view key, std::size_t value);
  void boolean(std::string_view key, bool value);
  void text(std::string_view key, std::string_view value);

  [[nodiscard]] const std::string& str() const { return out_; }

 private:
  void open(std::string_view key, char bracket);
  void close(char bracket);
  void begin_value(std::string_view key);
  void quote(std::string_view text);

  std::string out_;
  std::vector<bool> has_values_;  // of each object or array that is open
};

}  // namespace extperfc::offline
