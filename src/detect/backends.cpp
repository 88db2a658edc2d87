#include "detect/backends.hpp"

#include <algorithm>

#include "extperfc/base/text.hpp"

namespace extperfc::detect {

namespace {

constexpr std::size_t kLongestText = 200;
constexpr std::string_view kBlank = " \t\r\n";

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

}  // namespace

std::string shortened(std::string_view library_text) {
  const std::string_view text = trimmed(library_text);
  const auto last_break = text.find_last_of('\n');
  std::string line(trimmed(last_break == std::string_view::npos ? text : text.substr(last_break)));
  if (line.size() > kLongestText) line = line.substr(0, kLongestText - 3) + "...";
  return line.empty() ? "no reason given" : line;
}

Result<std::vector<std::string>> output_names(const ModelSpec& spec, const std::vector<std::string>& existing,
                                              std::size_t output_count) {
  const auto& wanted = spec.output.names;
  if (wanted.empty() && output_count == 1 && !existing.empty())
    return std::vector<std::string>{existing.front()};
  if (wanted.empty())
    return fail(ErrorCode::kInvalidArgument, "the network has the outputs " + enumeration(existing) +
                                                 ": say with output.names in model.yaml which to use");
  for (const auto& name : wanted)
    if (std::find(existing.begin(), existing.end(), name) == existing.end())
      return fail(ErrorCode::kInvalidArgument, "the network has no output \"" + name + "\", only " +
                                                   enumeration(existing) +
                                                   ": correct output.names in model.yaml");
  return wanted;
}

}  // namespace extperfc::detect
