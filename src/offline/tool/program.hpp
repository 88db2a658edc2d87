#pragma once

#include <string>
#include <vector>

namespace extperfc::offline::tool {

// Exit status, as --help tells it.
constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kUsage = 2;

/// Says on standard error what is wrong, behind the program's name; returns `status`.
int complain(const std::string& program, const std::string& what, int status = kFailed);

/// A program's main(): `run` gets the words behind its name and returns the exit status. What it throws is
/// told as other failures are.
int run_program(const char* program, int argc, char** argv,
                int (*run)(const std::vector<std::string>& words));

}  // namespace extperfc::offline::tool
