#include "offline/tool/program.hpp"

#include <exception>
#include <iostream>

namespace extperfc::offline {

int complain(const std::string& program, const std::string& what, int status) {
  std::cerr << program << ": " << what << (status == kUsage ? " (" + program + " --help)" : "") << '\n';
  return status;
}

int run_program(const char* program, int argc, char** argv,
                int (*run)(const std::vector<std::string>& tokens)) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const std::exception& problem) {
    return complain(program, problem.what());
  }
}

}  // namespace extperfc::offline
