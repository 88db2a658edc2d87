#include "detect/backends.hpp"

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

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

tl::unexpected<Error> no_such_tensor(const std::string& kind, const std::string& name,
                                     const std::vector<std::string>& existing) {
  return fail(ErrorCode::kInvalidArgument, "the network has no " + kind + " \"" + name + "\", only " +
                                               joined(existing) + ": correct " + kind +
                                               (kind == "input" ? ".name" : ".names") + " in model.yaml");
}

}  // namespace extperfc::detect
