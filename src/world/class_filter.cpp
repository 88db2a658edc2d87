#include "extperfc/world/class_filter.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <sstream>

#include "extperfc/base/text.hpp"

namespace extperfc {

namespace {

std::string trimmed(const std::string& text) {
  constexpr const char* kBlank = " \t\r\n";
  const auto begin = text.find_first_not_of(kBlank);
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

std::optional<int> index_of(const std::string& entry, const std::vector<std::string>& names) {
  const auto named = std::find(names.begin(), names.end(), entry);
  if (named != names.end()) return static_cast<int>(named - names.begin());
  int index = -1;
  const char* const end = entry.data() + entry.size();
  const auto [rest, error] = std::from_chars(entry.data(), end, index);
  if (error != std::errc() || rest != end || index < 0) return std::nullopt;
  if (!names.empty() && static_cast<std::size_t>(index) >= names.size()) return std::nullopt;
  return index;
}

}  // namespace

Result<ClassFilter> ClassFilter::make(const std::string& list, const std::vector<std::string>& names) {
  ClassFilter filter;
  std::istringstream entries(list);
  for (std::string entry; std::getline(entries, entry, ',');) {
    entry = trimmed(entry);
    if (entry.empty()) continue;
    const auto index = index_of(entry, names);
    if (!index)
      return fail(ErrorCode::kInvalidArgument,
                  "class filter: no class " + in_quotes(entry) +
                      (names.empty() ? ": the names of the classes are not known yet; use their indices"
                                     : hint_or_names(entry, names)));
    filter.indices_.push_back(*index);
  }
  std::sort(filter.indices_.begin(), filter.indices_.end());
  return filter;
}

bool ClassFilter::allows(int class_index) const {
  return indices_.empty() || std::binary_search(indices_.begin(), indices_.end(), class_index);
}

}  // namespace extperfc
