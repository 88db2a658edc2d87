#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc {

/// What a program takes on its command line.
struct ArgumentSyntax {
  std::size_t min_operands{0}, max_operands{0};  ///< arguments that are not options
  std::set<std::string> values;  ///< options with a value, which may be given several times: "--set"
  std::set<std::string> flags;   ///< options without: "--json"
};

/// The arguments behind a program's name. `--name=value` and `--name value` are the same; behind `--` nothing
/// is an option, and -h is --help. Errors name the argument that does not fit, with the nearest option that
/// exists.
class Arguments {
 public:
  [[nodiscard]] static Result<Arguments> read(const std::vector<std::string>& tokens,
                                              const ArgumentSyntax& syntax);

  [[nodiscard]] const std::vector<std::string>& operands() const { return operands_; }
  [[nodiscard]] bool has(const std::string& option) const { return values_.count(option) != 0; }
  [[nodiscard]] std::vector<std::string> all(const std::string& option) const;
  /// The last one given.
  [[nodiscard]] std::optional<std::string> last(const std::string& option) const;
  /// The last one as a number in [low, high]; empty when the option is not given.
  [[nodiscard]] Result<std::optional<double>> number(const std::string& option, double low,
                                                     double high) const;
  /// As `count` numbers with commas between, e.g. "0.2,0,3.14".
  [[nodiscard]] Result<std::optional<std::vector<double>>> numbers(const std::string& option,
                                                                   std::size_t count) const;

 private:
  std::vector<std::string> operands_;
  std::map<std::string, std::vector<std::string>> values_;
};

}  // namespace extperfc
