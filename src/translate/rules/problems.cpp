#include "translate/rules/problems.hpp"

#include <algorithm>

#include "extperfc/base/edit_distance.hpp"

namespace extperfc::translate::rules {

namespace {

constexpr std::size_t kMaxShown = 60;
constexpr std::size_t kMaxNameLength =
    200;  // longer names get no hint: the cost is the product of the lengths

}  // namespace

void Problems::add(int line, const std::string& where, const std::string& what) {
  ++count_;
  if (list_.size() < kMax)
    list_.push_back({line, place(line) + ": " + (where.empty() ? "" : where + ": ") + what});
}

std::string Problems::place(int line) const {
  return line > 0 ? file_ + ":" + std::to_string(line) : file_;
}

std::vector<std::string> Problems::lines() const {
  std::vector<Problem> sorted = list_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Problem& a, const Problem& b) { return a.line < b.line; });
  std::vector<std::string> texts;
  texts.reserve(sorted.size() + 1);
  for (const Problem& problem : sorted) texts.push_back(problem.text);
  if (count_ > list_.size())
    texts.push_back(file_ + ": and " + std::to_string(count_ - list_.size()) + " more problems");
  return texts;
}

std::string hint_for(const std::string& name, const std::vector<std::string>& known) {
  if (name.empty() || name.size() > kMaxNameLength) return "";
  const std::size_t farthest = 2 + name.size() / 8;  // edits
  const std::string* nearest = nullptr;
  std::size_t min_edits = farthest + 1;
  for (const std::string& candidate : known) {
    if (candidate.size() > name.size() + farthest || name.size() > candidate.size() + farthest) continue;
    const std::size_t edits = edit_distance(name, candidate);
    if (edits < min_edits && edits < name.size()) {
      min_edits = edits;
      nearest = &candidate;
    }
  }
  return nearest == nullptr ? "" : ", did you mean \"" + *nearest + "\"?";
}

std::string enumeration(const std::vector<std::string>& names) {
  if (names.empty()) return "none";
  std::string text = names.front();
  for (std::size_t i = 1; i < names.size(); ++i) text += (i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

std::string in_quotes(const std::string& text) {
  std::string shown = text.size() > kMaxShown ? text.substr(0, kMaxShown - 3) + "..." : text;
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; },
      '?');
  return '"' + shown + '"';
}

}  // namespace extperfc::translate::rules
