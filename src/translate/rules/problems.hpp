#pragma once

#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc::translate::rules {

/// What is wrong with a file of rules, collected so that all of it is reported at once.
class Problems {
 public:
  explicit Problems(std::string file) : file_(std::move(file)) {}

  /// `line` counts from 1; 0: no line to blame. `where` is the place in the entry, e.g. "forward.speed".
  void add(int line, const std::string& where, const std::string& what);
  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] const std::string& file() const { return file_; }
  /// "file:line", as rules remember it.
  [[nodiscard]] std::string place(int line) const;
  /// One line each, in the order of the file; at most `kMax`, then how many more there are.
  [[nodiscard]] std::vector<std::string> lines() const;
  static constexpr std::size_t kMax = 100;

 private:
  struct Problem {
    int line;
    std::string text;
  };
  std::string file_;
  std::vector<Problem> list_;
  std::size_t count_{0};
};

/// ", did you mean ...?" with the known word that is nearest to `word`; nothing when none is near.
[[nodiscard]] std::string hint_for(const std::string& name, const std::vector<std::string>& known);
/// "a, b and c"; "none" for none.
[[nodiscard]] std::string enumeration(const std::vector<std::string>& names);
/// Text of a stranger for a message: in quotes, shortened, without control characters.
[[nodiscard]] std::string in_quotes(const std::string& text);

}  // namespace extperfc::translate::rules
