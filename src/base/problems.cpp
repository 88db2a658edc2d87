#include "extperfc/base/problems.hpp"

#include <algorithm>

#include "extperfc/base/text.hpp"

namespace extperfc {

void Problems::add(int line, const std::string& key_path, const std::string& what) {
  add(line, key_path, what, code_);
}

void Problems::add(int line, const std::string& key_path, const std::string& what, ErrorCode code) {
  if (count_++ == 0) code_ = code;
  if (list_.size() < kMax)
    list_.push_back({line, place(line) + ": " + (key_path.empty() ? "" : key_path + ": ") + what});
}

std::string Problems::place(int line) const {
  return line > 0 ? source_name_ + ":" + std::to_string(line) : source_name_;
}

std::vector<std::string> Problems::lines() const {
  std::vector<Problem> sorted = list_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Problem& a, const Problem& b) { return a.line < b.line; });
  std::vector<std::string> texts;
  texts.reserve(sorted.size() + 1);
  for (const Problem& problem : sorted) texts.push_back(problem.text);
  if (count_ > list_.size())
    texts.push_back(source_name_ + ": and " + std::to_string(count_ - list_.size()) + " more problems");
  return texts;
}

Error Problems::to_error() const {
  return {code_, joined(lines(), "\n")};
}

}  // namespace extperfc
