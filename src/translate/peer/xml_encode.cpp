#include <array>
#include <cmath>
#include <locale>
#include <sstream>
#include <string>
#include <string_view>

#include "extperfc/translate/rpc.hpp"

#include "translate/peer/base64.hpp"

namespace extperfc::translate {
namespace {

constexpr const char* kStart = "<?xml version=\"1.0\"?>\n";

/// Bytes of the well-formed UTF-8 character at the start, 0 when there is none. Source: RFC 3629, section 4.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned>(static_cast<unsigned char>(text[i])) : 0U;
  };
  const auto follows = [&](std::size_t i) { return (byte(i) & 0xc0U) == 0x80U; };
  const auto first = byte(0);
  if (first < 0x80) return 1;
  if (first >= 0xc2 && first < 0xe0) return follows(1) ? 2 : 0;
  if (first >= 0xe0 && first < 0xf0) {
    const bool overlong = first == 0xe0 && byte(1) < 0xa0;
    const bool surrogate = first == 0xed && byte(1) >= 0xa0;
    const bool no_character = first == 0xef && byte(1) == 0xbf && byte(2) >= 0xbe;  // U+FFFE, U+FFFF
    return follows(1) && follows(2) && !overlong && !surrogate && !no_character ? 3 : 0;
  }
  if (first < 0xf0 || first > 0xf4) return 0;
  const bool outside = (first == 0xf0 && byte(1) < 0x90) || (first == 0xf4 && byte(1) >= 0x90);
  return follows(1) && follows(2) && follows(3) && !outside ? 4 : 0;
}

/// What XML cannot hold (control characters, bytes that are not UTF-8) becomes a question mark: a master
/// refuses the whole call otherwise. A carriage return needs its number, or readers turn it into a line feed.
void append_text(std::string& out, std::string_view text) {
  while (!text.empty()) {
    const auto c = static_cast<unsigned char>(text[0]);
    const auto length = utf8_length(text);
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else if (c == '\r')
      out += "&#13;";
    else if (length == 0 || (c < 0x20 && c != '\t' && c != '\n'))
      out += '?';
    else
      out.append(text.substr(0, length));
    text.remove_prefix(length == 0 ? 1 : length);
  }
}

/// The shortest decimals that read back as the same number, with a point in every locale.
std::string decimal(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value < 0 ? "-inf" : "inf";
  std::string text;
  for (const int digits : {15, 16, 17}) {
    std::ostringstream out;
    out.imbue(std::locale::classic());
    out.precision(digits);
    out << value;
    text = out.str();
    std::istringstream in(text);
    in.imbue(std::locale::classic());
    double back = 0.0;
    if (in >> back && back == value) break;
  }
  // Readers that look for a point take a number without one for an integer.
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

void append_value(std::string& out, const XmlValue& value);

struct Appender {
  std::string& out;

  void operator()(std::monostate) const { out += "<string></string>"; }
  void operator()(bool value) const { out += value ? "<boolean>1</boolean>" : "<boolean>0</boolean>"; }
  void operator()(std::int32_t value) const { out += "<int>" + std::to_string(value) + "</int>"; }
  void operator()(double value) const { out += "<double>" + decimal(value) + "</double>"; }
  void operator()(const std::string& value) const {
    out += "<string>";
    append_text(out, value);
    out += "</string>";
  }
  void operator()(const XmlBinary& value) const {
    out += "<base64>" + encode_base64(value.bytes) + "</base64>";
  }
  void operator()(const XmlDateTime& value) const {
    out += "<dateTime.iso8601>";
    append_text(out, value.text);
    out += "</dateTime.iso8601>";
  }
  void operator()(const XmlArray& values) const {
    out += "<array><data>";
    for (const auto& value : values) append_value(out, value);
    out += "</data></array>";
  }
  void operator()(const XmlStruct& members) const {
    out += "<struct>";
    for (const auto& [name, value] : members) {
      out += "<member><name>";
      append_text(out, name);
      out += "</name>";
      append_value(out, value);
      out += "</member>";
    }
    out += "</struct>";
  }
};

void append_value(std::string& out, const XmlValue& value) {
  out += "<value>";
  std::visit(Appender{out}, value.data);
  out += "</value>";
}

}  // namespace

bool operator==(const XmlValue& a, const XmlValue& b) {
  if (a.data.index() != b.data.index()) return false;
  return std::visit(
      [&b](const auto& left) {
        using Kind = std::decay_t<decltype(left)>;
        const auto& right = std::get<Kind>(b.data);
        if constexpr (std::is_same_v<Kind, XmlBinary>)
          return left.bytes == right.bytes;
        else if constexpr (std::is_same_v<Kind, XmlDateTime>)
          return left.text == right.text;
        else
          return left == right;
      },
      a.data);
}

std::string encode_call(const std::string& method, const XmlArray& arguments) {
  std::string out = kStart;
  out += "<methodCall><methodName>";
  append_text(out, method);
  out += "</methodName><params>";
  for (const auto& argument : arguments) {
    out += "<param>";
    append_value(out, argument);
    out += "</param>";
  }
  return out += "</params></methodCall>";
}

std::string encode_response(const XmlValue& value) {
  std::string out = kStart;
  out += "<methodResponse><params><param>";
  append_value(out, value);
  return out += "</param></params></methodResponse>";
}

std::string encode_fault(int code, const std::string& reason) {
  std::string out = kStart;
  out += "<methodResponse><fault>";
  append_value(out, XmlStruct{{"faultCode", std::int32_t{code}}, {"faultString", reason}});
  return out += "</fault></methodResponse>";
}

}  // namespace extperfc::translate
