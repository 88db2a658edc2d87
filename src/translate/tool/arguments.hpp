#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc::translate::tool {

/// What a subcommand takes.
struct Syntax {
  std::size_t least{0}, most{0};  ///< words that are no options
  std::set<std::string> values;   ///< options with a value, which may be given several times: "--set"
  std::set<std::string> flags;    ///< options without: "--json"
};

/// The words after a subcommand.
class Arguments {
 public:
  /// Errors name the word that does not fit. `--name=value` and `--name value` are the same.
  [[nodiscard]] static Result<Arguments> read(const std::vector<std::string>& words, const Syntax& syntax);

  [[nodiscard]] const std::vector<std::string>& words() const { return words_; }
  [[nodiscard]] bool has(const std::string& flag) const { return values_.count(flag) != 0; }
  [[nodiscard]] std::vector<std::string> all(const std::string& option) const;
  /// The last one given.
  [[nodiscard]] std::optional<std::string> last(const std::string& option) const;

 private:
  std::vector<std::string> words_;
  std::map<std::string, std::vector<std::string>> values_;
};

}  // namespace extperfc::translate::tool
