#include <array>
#include <exception>
#include <iostream>
#include <string>
#include <string_view>

#include "translate/tool/command.hpp"

namespace {

using extperfc::translate::Command;
using namespace extperfc::translate;  // NOLINT: a program, not a header

constexpr const char* kHelp =
    R"(Compares definitions of ROS 1 messages, services and actions, and shows how they are converted.

  extperfc-translate check   compares two sets, trees or running masters, and lists what needs a rule
  extperfc-translate show    shows how a type is converted from one definition to another
  extperfc-translate md5     prints the MD5 of a type
  extperfc-translate export  writes a set of definitions as a tree of packages
  extperfc-translate status  prints the bridged topics and services of a running translator
  extperfc-translate store   writes a store of definitions from trees of packages

`extperfc-translate SUBCOMMAND --help` lists its options. Exit status: 0 fine, 1 `check` found types that need a rule,
2 an error occurred.
)";

struct Entry {
  std::string_view name;
  Command run;
};
constexpr std::array<Entry, 6> kCommands{{{"check", run_check},
                                          {"export", run_export},
                                          {"md5", run_md5},
                                          {"show", run_show},
                                          {"status", run_status},
                                          {"store", run_store}}};

int run(const std::string& name, const Tokens& tokens) {
  for (const auto& command : kCommands) {
    if (command.name != name) continue;
    const auto status = command.run(tokens);
    if (status) return *status;
    std::cerr << "extperfc-translate " << name << ": " << status.error().message << "\n";
    return kFailed;
  }
  std::cerr << "extperfc-translate: no subcommand '" << name << "'; see extperfc-translate --help\n";
  return kFailed;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Tokens tokens(argv + 1, argv + argc);
    if (tokens.empty() || tokens[0] == "--help" || tokens[0] == "-h") {
      (tokens.empty() ? std::cerr : std::cout) << kHelp;
      return tokens.empty() ? kFailed : kFine;
    }
    return run(tokens[0], {tokens.begin() + 1, tokens.end()});
  } catch (const std::exception& problem) {
    std::cerr << "extperfc-translate: " << problem.what() << "\n";
    return kFailed;
  }
}
