#include <charconv>
#include <limits>
#include <locale>
#include <sstream>
#include <string>
#include <string_view>

#include "extperfc/translate/rpc.hpp"

#include "translate/peer/base64.hpp"
#include "translate/peer/blanks.hpp"
#include "translate/peer/xml_scanner.hpp"

namespace extperfc::translate {
namespace {

using Token = XmlScanner::Token;

Result<XmlValue> read_int(std::string_view text) {
  if (!text.empty() && text[0] == '+') text.remove_prefix(1);
  std::int32_t value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || problem != std::errc() || end != text.data() + text.size())
    return fail(ErrorCode::kCorrupt, "not an integer of 32 bits: '" + std::string(text.substr(0, 40)) + "'");
  return XmlValue(value);
}

Result<XmlValue> read_bool(std::string_view text) {
  if (text == "1" || text == "true") return XmlValue(true);
  if (text == "0" || text == "false") return XmlValue(false);
  return fail(ErrorCode::kCorrupt, "not a boolean: '" + std::string(text.substr(0, 40)) + "'");
}

/// inf and nan as Python and C write them.
std::optional<double> read_special(std::string_view text) {
  const bool minus = !text.empty() && text[0] == '-';
  if (minus || (!text.empty() && text[0] == '+')) text.remove_prefix(1);
  if (text == "nan" || text == "NaN") return std::numeric_limits<double>::quiet_NaN();
  if (text != "inf" && text != "Infinity") return std::nullopt;
  return minus ? -std::numeric_limits<double>::infinity() : std::numeric_limits<double>::infinity();
}

Result<XmlValue> read_double(std::string_view text) {
  if (const auto special = read_special(text)) return XmlValue(*special);
  std::istringstream in{std::string(text)};
  in.imbue(std::locale::classic());
  double value = 0.0;
  if (!(in >> value) || in.peek() != std::istringstream::traits_type::eof())
    return fail(ErrorCode::kCorrupt, "not a number: '" + std::string(text.substr(0, 40)) + "'");
  return XmlValue(value);
}

Result<XmlValue> read_binary(std::string_view text) {
  auto bytes = decode_base64(text);
  if (!bytes) return fail(ErrorCode::kCorrupt, "base64 is damaged");
  return XmlValue(XmlBinary{std::move(*bytes)});
}

/// Reads the elements of one document in order; the first error ends it.
class Decoder {
 public:
  Decoder(std::string_view xml, const RpcLimits& limits) : scanner_(xml), limits_(limits) { advance(); }

  Result<XmlCall> call() {
    XmlCall call;
    if (!open("methodCall") || !open("methodName")) return error<XmlCall>();
    call.method = std::string(trimmed(text()));
    if (!close("methodName")) return error<XmlCall>();
    if (at_open("params")) {
      advance();
      while (at_open("param")) {
        advance();
        call.arguments.push_back(value(0));
        if (failed() || !close("param")) return error<XmlCall>();
      }
      if (!close("params")) return error<XmlCall>();
    }
    if (!close("methodCall") || !end()) return error<XmlCall>();
    return call;
  }

  Result<XmlValue> response() {
    if (!open("methodResponse")) return error<XmlValue>();
    if (at_open("fault")) return fault();
    if (!open("params") || !open("param")) return error<XmlValue>();
    auto answer = value(0);
    if (failed() || !close("param") || !close("params") || !close("methodResponse") || !end())
      return error<XmlValue>();
    return answer;
  }

 private:
  Result<XmlValue> fault() {
    advance();
    const auto what = value(0);
    if (failed() || !close("fault")) return error<XmlValue>();
    std::string reason = "without a reason";
    if (const auto* members = what.as<XmlStruct>())
      if (const auto found = members->find("faultString"); found != members->end())
        if (const auto* text = found->second.as<std::string>()) reason = *text;
    return fail(ErrorCode::kFailed, "fault: " + reason);
  }

  XmlValue value(std::size_t depth) {
    if (depth >= limits_.depth) return refuse("values are nested too deeply");
    if (++values_ > limits_.values) return refuse("too many values");
    if (!open("value")) return {};
    auto bare = text();
    if (token_ == Token::kClose) {
      close("value");
      return bare;
    }
    if (!trimmed(bare).empty()) return refuse("text beside an element");
    auto typed = typed_value(depth);
    if (!failed()) close("value");
    return typed;
  }

  XmlValue typed_value(std::size_t depth) {
    if (token_ != Token::kOpen) return refuse("a value without an end");
    const auto type = scanner_.name();
    if (type == "array") return array(depth);
    if (type == "struct") return structure(depth);
    advance();
    auto content = text();
    if (failed() || !close(type)) return {};
    return scalar(type, std::move(content));
  }

  XmlValue scalar(std::string_view type, std::string content) {
    if (type == "string") return content;
    const auto bare = trimmed(content);
    if (type == "int" || type == "i4" || type == "i8") return accept(read_int(bare));
    if (type == "boolean") return accept(read_bool(bare));
    if (type == "double") return accept(read_double(bare));
    if (type == "base64") return accept(read_binary(bare));
    if (type == "nil" || type == "ex:nil") return {};
    if (type == "dateTime.iso8601") {
      XmlValue time;
      time.data = XmlDateTime{std::string(bare)};
      return time;
    }
    return refuse("unknown type '" + std::string(type.substr(0, 40)) + "'");
  }

  XmlValue array(std::size_t depth) {
    XmlArray values;
    advance();
    skip_blanks();
    if (at_open("data")) {
      advance();
      while (at_open("value")) {
        values.push_back(value(depth + 1));
        if (failed()) return {};
      }
      close("data");
    }
    if (!failed()) close("array");
    return values;
  }

  XmlValue structure(std::size_t depth) {
    XmlStruct members;
    advance();
    while (at_open("member")) {
      advance();
      if (!open("name")) return {};
      auto name = text();
      if (!close("name")) return {};
      skip_blanks();
      members[std::move(name)] = value(depth + 1);
      if (failed() || !close("member")) return {};
    }
    close("struct");
    return members;
  }

  // Tokens. `token_` is the one that has not been used yet.
  void advance() {
    if (failed()) return;
    token_ = scanner_.next();
    if (token_ == Token::kBroken) refuse("a tag or comment without an end, or a document type");
  }
  /// Joins texts up to the next tag.
  std::string text() {
    std::string joined;
    for (; !failed() && token_ == Token::kText; advance()) {
      if (joined.empty())
        joined = scanner_.take_text();
      else
        joined += scanner_.text();
    }
    return joined;
  }
  void skip_blanks() {
    while (!failed() && token_ == Token::kText) {
      if (!trimmed(scanner_.text()).empty()) refuse("text between elements");
      advance();
    }
  }
  bool at_open(std::string_view name) {
    skip_blanks();
    return !failed() && token_ == Token::kOpen && scanner_.name() == name;
  }
  bool open(std::string_view name) { return tag(Token::kOpen, name); }
  bool close(std::string_view name) { return tag(Token::kClose, name); }
  bool tag(Token kind, std::string_view name) {
    skip_blanks();
    if (!failed() && (token_ != kind || scanner_.name() != name))
      refuse((kind == Token::kOpen ? "<" : "</") + std::string(name.substr(0, 40)) + "> is missing");
    advance();
    return !failed();
  }
  bool end() {
    skip_blanks();
    if (!failed() && token_ != Token::kEnd) refuse("something follows the end");
    return !failed();
  }

  // The first problem counts.
  [[nodiscard]] bool failed() const { return !problem_.empty(); }
  XmlValue refuse(const std::string& problem) {
    if (!failed()) problem_ = problem + " (before byte " + std::to_string(scanner_.offset()) + ")";
    return {};
  }
  XmlValue accept(Result<XmlValue> value) {
    return value ? std::move(*value) : refuse(value.error().message);
  }
  template <typename T>
  [[nodiscard]] Result<T> error() const {
    return fail(ErrorCode::kCorrupt, "not XML-RPC: " + problem_);
  }

  XmlScanner scanner_;
  const RpcLimits& limits_;
  Token token_{Token::kEnd};
  std::size_t values_{0};
  std::string problem_;
};

Result<void> check_size(std::string_view xml, const RpcLimits& limits) {
  if (xml.size() <= limits.body_bytes) return {};
  return fail(ErrorCode::kCorrupt, "not XML-RPC: " + std::to_string(xml.size()) + " bytes are more than " +
                                       std::to_string(limits.body_bytes));
}

}  // namespace

Result<XmlCall> decode_call(std::string_view xml, const RpcLimits& limits) {
  if (auto size = check_size(xml, limits); !size) return tl::unexpected(size.error());
  return Decoder(xml, limits).call();
}

Result<XmlValue> decode_response(std::string_view xml, const RpcLimits& limits) {
  if (auto size = check_size(xml, limits); !size) return tl::unexpected(size.error());
  return Decoder(xml, limits).response();
}

}  // namespace extperfc::translate
