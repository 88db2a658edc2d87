#include "arguments.hpp"

namespace extperfc::translate::tool {

Result<Arguments> Arguments::read(const std::vector<std::string>& words, const Syntax& syntax) {
  Arguments arguments;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto& word = words[i];
    if (word.substr(0, 2) != "--") {
      arguments.words_.push_back(word);
      continue;
    }
    const auto equals = word.find('=');
    const auto name = word.substr(0, equals);
    if (syntax.flags.count(name) != 0 && equals == std::string::npos) {
      arguments.values_[name];
    } else if (syntax.values.count(name) == 0) {
      return fail(ErrorCode::kInvalidArgument, "unknown option " + word);
    } else if (equals != std::string::npos) {
      arguments.values_[name].push_back(word.substr(equals + 1));
    } else if (++i == words.size()) {
      return fail(ErrorCode::kInvalidArgument, name + " needs a value");
    } else {
      arguments.values_[name].push_back(words[i]);
    }
  }
  if (arguments.words_.size() < syntax.least) return fail(ErrorCode::kInvalidArgument, "too few arguments");
  if (arguments.words_.size() > syntax.most)
    return fail(ErrorCode::kInvalidArgument, "unexpected argument " + arguments.words_[syntax.most]);
  return arguments;
}

std::vector<std::string> Arguments::all(const std::string& option) const {
  const auto found = values_.find(option);
  return found == values_.end() ? std::vector<std::string>() : found->second;
}

std::optional<std::string> Arguments::last(const std::string& option) const {
  const auto found = all(option);
  if (found.empty()) return std::nullopt;
  return found.back();
}

}  // namespace extperfc::translate::tool
