#pragma once

#include <ostream>
#include <string>

#include "extperfc/base/error.hpp"

namespace extperfc::benchmark {

struct TranslateOptions {
  int samples{2000};       ///< of each route and size up to 100 kB; a tenth of it for 6 MB
  double seconds{10.0};    ///< of each measurement under load [s]
  int topics{500};         ///< under load
  double rate_hz{20'000};  ///< messages of all topics together under load
  std::string only;        ///< "latency", "load", "conversion", or empty: all
  std::string json;
  bool help{false};
};

[[nodiscard]] Result<TranslateOptions> parse_translate_options(int argc, char** argv);
void print_translate_help(std::ostream& out);

}  // namespace extperfc::benchmark
