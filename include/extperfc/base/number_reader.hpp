#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace extperfc {

/// Splits a line into tokens separated by blanks.
class TokenReader {
 public:
  explicit TokenReader(std::string_view line) : rest_(line) {}

  /// The next token; empty at the end.
  [[nodiscard]] std::string_view token();
  /// The next token as a finite decimal number, independent of the locale; no value otherwise.
  [[nodiscard]] std::optional<double> number();

 private:
  std::string_view rest_;
};

/// A finite decimal number such as -12.5e-3, the whole text; no value otherwise. Exact to the last
/// digit.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);
/// As short as six digits allow, independent of the locale.
[[nodiscard]] std::string number_text(double value);

}  // namespace extperfc
