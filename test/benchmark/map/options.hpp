#pragma once

#include <cstddef>
#include <ostream>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc::benchmark {

constexpr std::size_t kWholeLog = 1'000'000'000;
// These run only when they are asked for.
constexpr char kVariedPart[] = "varied";
constexpr char kWorldsPart[] = "worlds";
constexpr char kLongPart[] = "long";

struct MapOptions {
  int seeds{3};                       ///< of every log, with 30 particles; with other numbers at most three
  std::size_t scans{kWholeLog};       ///< of every log
  std::size_t peer_scans{kWholeLog};  ///< of every log, for the comparison with peers
  double drive_s{400};                ///< length of the drives in generated buildings [s], at most
  bool quick{false};                  ///< parts of everything
  int worlds{2};                      ///< generated buildings of every kind
  std::string only;  ///< "log", "peer", "rates", "hall", or empty: all of these; kVariedPart, kWorldsPart
  std::string log;   ///< one of log_names(), or empty: all that are there
  std::string json;
  bool help{false};
};

/// The options of `tokens`, which do not hold the program's name.
[[nodiscard]] Result<MapOptions> parse_map_options(const std::vector<std::string>& tokens);
void print_map_help(std::ostream& out);

}  // namespace extperfc::benchmark
