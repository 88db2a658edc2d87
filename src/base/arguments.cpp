#include "extperfc/base/arguments.hpp"

#include <algorithm>
#include <sstream>

#include "extperfc/base/number_reader.hpp"
#include "extperfc/base/text.hpp"

namespace extperfc {

namespace {

tl::unexpected<Error> unknown_option(const std::string& name, const ArgumentSyntax& syntax) {
  std::vector<std::string> known(syntax.values.begin(), syntax.values.end());
  known.insert(known.end(), syntax.flags.begin(), syntax.flags.end());
  return fail(ErrorCode::kInvalidArgument, "unknown option " + name + hint_for(name, known));
}

}  // namespace

Result<Arguments> Arguments::read(const std::vector<std::string>& tokens, const ArgumentSyntax& syntax) {
  Arguments arguments;
  bool options_end = false;
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    const std::string token = tokens[i] == "-h" && !options_end ? "--help" : tokens[i];
    if (options_end || token.substr(0, 2) != "--") {
      arguments.operands_.push_back(token);
      continue;
    }
    if (token == "--") {
      options_end = true;
      continue;
    }
    const auto equals = token.find('=');
    const auto name = token.substr(0, equals);
    if (syntax.flags.count(name) != 0 && equals == std::string::npos) {
      arguments.values_[name];
    } else if (syntax.flags.count(name) != 0) {
      return fail(ErrorCode::kInvalidArgument, name + " takes no value");
    } else if (syntax.values.count(name) == 0) {
      return unknown_option(name, syntax);
    } else if (equals != std::string::npos) {
      arguments.values_[name].push_back(token.substr(equals + 1));
    } else if (++i == tokens.size()) {
      return fail(ErrorCode::kInvalidArgument, name + " needs a value");
    } else {
      arguments.values_[name].push_back(tokens[i]);
    }
  }
  if (arguments.operands_.size() < syntax.min_operands && !arguments.has("--help"))
    return fail(ErrorCode::kInvalidArgument, "too few arguments");
  if (arguments.operands_.size() > syntax.max_operands)
    return fail(ErrorCode::kInvalidArgument,
                "unexpected argument " + arguments.operands_[syntax.max_operands]);
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

Result<std::optional<double>> Arguments::number(const std::string& option, double low, double high) const {
  const auto text = last(option);
  if (!text) return std::optional<double>();
  const auto value = parse_number(*text);
  if (value && *value >= low && *value <= high) return value;
  return fail(ErrorCode::kInvalidArgument, option + " must be a number from " + number_text(low) + " to " +
                                               number_text(high) + ", not '" + *text + "'");
}

Result<std::optional<std::vector<double>>> Arguments::numbers(const std::string& option,
                                                              std::size_t count) const {
  const auto text = last(option);
  if (!text) return std::optional<std::vector<double>>();
  std::vector<double> found;
  std::istringstream parts(*text);
  bool good = true;
  for (std::string part; std::getline(parts, part, ',');) {
    part.erase(0, part.find_first_not_of(' '));
    const auto value = parse_number(part);
    good = good && value;
    found.push_back(value.value_or(0));
  }
  if (good && found.size() == count) return std::optional(std::move(found));
  return fail(ErrorCode::kInvalidArgument, option + " must be " + std::to_string(count) +
                                               " numbers with commas between, not '" + *text + "'");
}

}  // namespace extperfc
