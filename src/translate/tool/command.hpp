#pragma once

#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc::translate {

/// The arguments after the subcommand's name.
using Tokens = std::vector<std::string>;

constexpr int kFine = 0;
constexpr int kDiffers = 1;  ///< `check`: something needs a rule or is not known
constexpr int kFailed = 2;

/// One subcommand: returns the exit status; an error's text goes to standard error, with status 2.
using Command = Result<int> (*)(const Tokens& tokens);

[[nodiscard]] Result<int> run_md5(const Tokens& tokens);
[[nodiscard]] Result<int> run_show(const Tokens& tokens);
[[nodiscard]] Result<int> run_check(const Tokens& tokens);
[[nodiscard]] Result<int> run_export(const Tokens& tokens);
[[nodiscard]] Result<int> run_status(const Tokens& tokens);
[[nodiscard]] Result<int> run_store(const Tokens& tokens);

}  // namespace extperfc::translate
