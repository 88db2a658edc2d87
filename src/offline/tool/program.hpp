#pragma once

#include <string>
#include <vector>

namespace extperfc::offline {

// Exit status, as described by --help.
constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kUsage = 2;

/// Prints an error behind the program's name on standard error; returns `status`.
int complain(const std::string& program, const std::string& what, int status = kFailed);

/// A program's main(): `run` gets the arguments behind its name and returns the exit status. Exceptions are
/// reported like other failures.
int run_program(const char* program, int argc, char** argv,
                int (*run)(const std::vector<std::string>& tokens));

}  // namespace extperfc::offline
