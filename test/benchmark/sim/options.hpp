#pragma once

#include <ostream>
#include <string>

#include "extperfc/base/error.hpp"

namespace extperfc::benchmark {

struct SimOptions {
  std::string world{"lab"};  ///< name in config/worlds, or a file
  double seconds{15};        ///< of every measurement of the whole robot [s]
  int frames{60};            ///< of every sensor alone
  std::string json;
  bool help{false};
};

[[nodiscard]] Result<SimOptions> parse_sim_options(int argc, char** argv);
void print_sim_help(std::ostream& out);

}  // namespace extperfc::benchmark
