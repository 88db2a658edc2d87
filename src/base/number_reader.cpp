#include "extperfc/base/number_reader.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <locale>
#include <sstream>
#include <string>

namespace extperfc {

namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

// A quotient of two doubles that hold their numbers exactly is rounded correctly: digits below 2^53 and
// powers of ten up to 10^22.
constexpr std::uint64_t kMaxExactDigits = std::uint64_t{1} << 53U;
constexpr std::array<double, 23> kPowersOfTen = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                 1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

std::optional<double> parse_slowly(std::string_view text) {
  if (text.find_first_not_of("+-.0123456789eE") != std::string_view::npos) return std::nullopt;
  std::istringstream in{std::string(text)};
  in.imbue(std::locale::classic());
  double value = 0;
  if (!(in >> value) || !std::isfinite(value) || in.peek() != std::char_traits<char>::eof())
    return std::nullopt;
  return value;
}

}  // namespace

std::optional<double> parse_number(std::string_view text) {
  const bool negative = !text.empty() && text.front() == '-';
  std::uint64_t digits = 0;
  std::size_t decimals = 0;
  std::size_t count = 0;
  bool fraction = false;
  for (const char c : text.substr(negative ? 1 : 0)) {
    if (c == '.' && !fraction) {
      fraction = true;
      continue;
    }
    if (c < '0' || c > '9' || digits >= kMaxExactDigits / 10) return parse_slowly(text);
    digits = digits * 10 + static_cast<std::uint64_t>(c - '0');
    ++count;
    if (fraction) ++decimals;
  }
  if (count == 0 || decimals >= kPowersOfTen.size()) return parse_slowly(text);
  const double value = static_cast<double>(digits) / kPowersOfTen[decimals];
  return negative ? -value : value;
}

std::string_view TokenReader::token() {
  const auto begin = rest_.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) {
    rest_ = {};
    return {};
  }
  const auto end = std::min(rest_.find_first_of(kBlanks, begin), rest_.size());
  const auto found = rest_.substr(begin, end - begin);
  rest_.remove_prefix(end);
  return found;
}

std::optional<double> TokenReader::number() {
  return parse_number(token());
}

std::string number_text(double value) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << value;
  return out.str();
}

}  // namespace extperfc
