#include "offline/json_writer.hpp"

#include <cmath>
#include <locale>
#include <sstream>

namespace extperfc::offline {

void JsonWriter::begin_value(std::string_view key) {
  if (!has_values_.empty()) {
    if (has_values_.back()) out_ += ',';
    has_values_.back() = true;
    out_ += '\n';
    out_.append(2 * has_values_.size(), ' ');
  }
  if (key.empty()) return;
  quote(key);
  out_ += ": ";
}

void JsonWriter::open(std::string_view key, char bracket) {
  begin_value(key);
  out_ += bracket;
  has_values_.push_back(false);
}

void JsonWriter::close(char bracket) {
  const bool any = has_values_.back();
  has_values_.pop_back();
  if (any) {
    out_ += '\n';
    out_.append(2 * has_values_.size(), ' ');
  }
  out_ += bracket;
  if (has_values_.empty()) out_ += '\n';
}

void JsonWriter::number(std::string_view key, double value) {
  begin_value(key);
  if (!std::isfinite(value)) {
    out_ += "null";
    return;
  }
  std::ostringstream text;
  text.imbue(std::locale::classic());
  constexpr int kDigits = 9;
  text.precision(kDigits);
  text << value;
  out_ += text.str();
}

void JsonWriter::count(std::string_view key, std::size_t value) {
  begin_value(key);
  out_ += std::to_string(value);
}

void JsonWriter::boolean(std::string_view key, bool value) {
  begin_value(key);
  out_ += value ? "true" : "false";
}

void JsonWriter::text(std::string_view key, std::string_view value) {
  begin_value(key);
  quote(value);
}

void JsonWriter::quote(std::string_view text) {
  constexpr std::string_view kHex = "0123456789abcdef";
  out_ += '"';
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out_ += '\\';
      out_ += c;
    } else if (byte < ' ') {
      out_ += "\\u00";
      out_ += kHex[byte >> 4U];
      out_ += kHex[byte & 15U];
    } else {
      out_ += c;
    }
  }
  out_ += '"';
}

}  // namespace extperfc::offline
