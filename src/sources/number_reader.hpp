#pragma once

#include <optional>
#include <string_view>

namespace extperfc::sources {

/// Words of a line, one after the other, parted by blanks.
class WordReader {
 public:
  explicit WordReader(std::string_view line) : rest_(line) {}

  /// The next word; empty at the end.
  [[nodiscard]] std::string_view word();
  /// The next word as a finite decimal number, whatever the program's locale; nothing when it is none.
  [[nodiscard]] std::optional<double> number();

 private:
  std::string_view rest_;
};

/// A finite decimal number such as -12.5e-3, the whole text; nothing when it is none. Exact to the last
/// digit.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);

}  // namespace extperfc::sources
