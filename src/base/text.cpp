#include "extperfc/base/text.hpp"

#include <algorithm>
#include <numeric>

namespace extperfc {

namespace {

constexpr std::size_t kMaxShown = 60;
constexpr std::size_t kMaxHintLength = 200;  // the cost of a hint is the product of the lengths

}  // namespace

std::size_t edit_distance(std::string_view from, std::string_view to) {
  std::vector<std::size_t> cost(to.size() + 1);  // one row at a time
  std::iota(cost.begin(), cost.end(), std::size_t{0});
  for (std::size_t row = 1; row <= from.size(); ++row) {
    std::size_t upper_left = cost[0];
    cost[0] = row;
    for (std::size_t column = 1; column <= to.size(); ++column) {
      const std::size_t swap = upper_left + (from[row - 1] == to[column - 1] ? 0 : 1);
      upper_left = cost[column];
      cost[column] = std::min({cost[column] + 1, cost[column - 1] + 1, swap});
    }
  }
  return cost.back();
}

std::string hint_for(const std::string& name, const std::vector<std::string>& known) {
  if (name.empty() || name.size() > kMaxHintLength) return "";
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

std::string hint_or_names(const std::string& name, const std::vector<std::string>& known) {
  const std::string hint = hint_for(name, known);
  return hint.empty() ? ": known are " + enumeration(known) : hint;
}

std::string joined(const std::vector<std::string>& names, const std::string& between) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) text += (i == 0 ? "" : between) + names[i];
  return text;
}

std::string enumeration(const std::vector<std::string>& names, const std::string& last) {
  if (names.empty()) return "none";
  if (names.size() == 1) return names.front();
  return joined({names.begin(), names.end() - 1}) + last + names.back();
}

std::string in_quotes(const std::string& text) {
  std::string shown = text.size() > kMaxShown ? text.substr(0, kMaxShown - 3) + "..." : text;
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; },
      '?');
  return '"' + shown + '"';
}

bool ends_with(std::string_view text, std::string_view end) {
  return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
}

}  // namespace extperfc
