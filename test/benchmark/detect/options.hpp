#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc::benchmark {

struct DetectOptions {
  std::vector<std::filesystem::path> models;  ///< besides those in models/ of the package
  std::filesystem::path images;               ///< folder of aligned images; empty = one drawn image
  std::vector<std::string> backends{"openvino", "opencv"};
  std::vector<int> threads;  ///< empty = 1 and all
  int frames{60};            ///< of each kind in each case, >= 1
  double score{-1.0};        ///< score threshold; negative = the model's own
  std::string json;          ///< file for the results; empty = none
  bool help{false};
};

void print_help(std::ostream& out);

/// The error names the argument that is wrong.
[[nodiscard]] Result<DetectOptions> parse_detect_options(int argc, char** argv);

}  // namespace extperfc::benchmark
