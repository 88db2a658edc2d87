#include "translate/peer/xml_scanner.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <utility>

#include "translate/peer/blanks.hpp"

namespace extperfc::translate {
namespace {

struct Entity {
  std::string_view name;
  char character;
};
constexpr std::array<Entity, 5> kEntities{
    {{"lt", '<'}, {"gt", '>'}, {"amp", '&'}, {"apos", '\''}, {"quot", '"'}}};

/// False when there is no such character.
bool append_utf8(std::string& out, std::uint32_t code) {
  if (code == 0 || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return false;
  const auto put = [&out](std::uint32_t byte) { out.push_back(static_cast<char>(byte)); };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xc0U | (code >> 6U));
    put(0x80U | (code & 0x3fU));
  } else if (code < 0x10000) {
    put(0xe0U | (code >> 12U));
    put(0x80U | ((code >> 6U) & 0x3fU));
    put(0x80U | (code & 0x3fU));
  } else {
    put(0xf0U | (code >> 18U));
    put(0x80U | ((code >> 12U) & 0x3fU));
    put(0x80U | ((code >> 6U) & 0x3fU));
    put(0x80U | (code & 0x3fU));
  }
  return true;
}

bool append_numbered(std::string& out, std::string_view digits) {
  const bool hex = !digits.empty() && (digits[0] == 'x' || digits[0] == 'X');
  if (hex) digits.remove_prefix(1);
  std::uint32_t code = 0;
  const auto [end, problem] =
      std::from_chars(digits.data(), digits.data() + digits.size(), code, hex ? 16 : 10);
  return problem == std::errc() && end == digits.data() + digits.size() && append_utf8(out, code);
}

/// `name` stands between & and ;.
bool append_entity(std::string& out, std::string_view name) {
  if (!name.empty() && name[0] == '#') return append_numbered(out, name.substr(1));
  for (const auto& entity : kEntities)
    if (entity.name == name) {
      out.push_back(entity.character);
      return true;
    }
  return false;
}

/// Unknown entities are kept unchanged.
void append_decoded(std::string& out, std::string_view raw) {
  constexpr std::size_t kLongest = 10;
  while (!raw.empty()) {
    const auto ampersand = raw.find('&');
    out.append(raw.substr(0, ampersand));
    if (ampersand == std::string_view::npos) return;
    raw.remove_prefix(ampersand);
    const auto end = raw.substr(0, kLongest + 2).find(';');
    if (end != std::string_view::npos && append_entity(out, raw.substr(1, end - 1))) {
      raw.remove_prefix(end + 1);
    } else {
      out.push_back('&');
      raw.remove_prefix(1);
    }
  }
}

bool starts_with(std::string_view text, std::string_view start) {
  return text.substr(0, start.size()) == start;
}

}  // namespace

XmlScanner::XmlScanner(std::string_view document) : document_(document) {
  if (starts_with(document_, "\xef\xbb\xbf")) at_ = 3;  // byte order mark
}

XmlScanner::Token XmlScanner::next() {
  if (std::exchange(close_next_, false)) return Token::kClose;
  while (at_ < document_.size()) {
    if (document_[at_] != '<') return plain_text();
    const char second = at_ + 1 < document_.size() ? document_[at_ + 1] : '\0';
    if (second != '!' && second != '?') return tag();
    const auto rest = document_.substr(at_);
    if (starts_with(rest, "<![CDATA[")) return literal_text();
    const bool comment = starts_with(rest, "<!--");
    if (second == '!' && !comment) return Token::kBroken;
    if (!skip_past(comment ? "-->" : "?>")) return Token::kBroken;
  }
  return Token::kEnd;
}

XmlScanner::Token XmlScanner::plain_text() {
  const auto end = document_.find('<', at_);
  text_.clear();
  append_decoded(text_, document_.substr(at_, end == std::string_view::npos ? end : end - at_));
  at_ = end == std::string_view::npos ? document_.size() : end;
  return Token::kText;
}

XmlScanner::Token XmlScanner::literal_text() {
  constexpr std::size_t kStart = 9;
  const auto end = document_.find("]]>", at_ + kStart);
  if (end == std::string_view::npos) return Token::kBroken;
  text_ = document_.substr(at_ + kStart, end - at_ - kStart);
  at_ = end + 3;
  return Token::kText;
}

XmlScanner::Token XmlScanner::tag() {
  const auto end = end_of_tag(at_);
  if (end == std::string_view::npos) return Token::kBroken;
  auto inside = document_.substr(at_ + 1, end - at_ - 1);
  at_ = end + 1;
  const bool closes = starts_with(inside, "/");
  if (closes) inside.remove_prefix(1);
  const bool empty = !closes && !inside.empty() && inside.back() == '/';
  if (empty) inside.remove_suffix(1);
  const auto name_end = std::find_if(inside.begin(), inside.end(), is_blank);
  name_ = inside.substr(0, static_cast<std::size_t>(name_end - inside.begin()));
  if (name_.empty()) return Token::kBroken;
  close_next_ = empty;
  return closes ? Token::kClose : Token::kOpen;
}

std::size_t XmlScanner::end_of_tag(std::size_t from) const {
  char quote = 0;
  for (auto i = from; i < document_.size(); ++i) {
    const char c = document_[i];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '>') {
      return i;
    } else if (c == '"' || c == '\'') {
      quote = c;
    }
  }
  return std::string_view::npos;
}

bool XmlScanner::skip_past(std::string_view end) {
  const auto found = document_.find(end, at_ + 2);
  if (found == std::string_view::npos) return false;
  at_ = found + end.size();
  return true;
}

}  // namespace extperfc::translate
