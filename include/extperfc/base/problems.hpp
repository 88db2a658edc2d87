#pragma once

#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc {

/// What is wrong with a file, collected so that all of it is reported at once.
class Problems {
 public:
  static constexpr std::size_t kMax = 100;  ///< that are kept; further ones are counted

  /// `code` is that of a problem which names none.
  explicit Problems(std::string source_name, ErrorCode code = ErrorCode::kInvalidArgument)
      : source_name_(std::move(source_name)), code_(code) {}

  /// `line` counts from 1; 0: no line to blame. `key_path` is the place in the file, e.g. "input.width".
  void add(int line, const std::string& key_path, const std::string& what);
  void add(int line, const std::string& key_path, const std::string& what, ErrorCode code);
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] std::size_t size() const { return count_; }
  /// "lab.yaml:12".
  [[nodiscard]] std::string place(int line) const;
  /// "lab.yaml:12: objects[3].cube.size: what: remedy", in the order of the file.
  [[nodiscard]] std::vector<std::string> lines() const;
  /// All lines, with the code of the first problem that was added.
  [[nodiscard]] Error to_error() const;

 private:
  struct Problem {
    int line;
    std::string text;
  };
  std::string source_name_;
  ErrorCode code_;
  std::vector<Problem> list_;
  std::size_t count_{0};
};

}  // namespace extperfc
