#pragma once

#include <filesystem>

#include <yaml-cpp/yaml.h>

#include "extperfc/base/error.hpp"
#include "extperfc/detect/model_spec.hpp"

#include "detect/yaml_section.hpp"

namespace extperfc::detect {

/// Reads a YAML file. Errors: kNotFound, kCorrupt (not YAML, with line and column).
[[nodiscard]] Result<YAML::Node> read_yaml(const std::filesystem::path& file);

/// The description in `root`, with every problem noted in `problems`; files are named relative to `folder`.
/// Looks into `classes_file` but not into the ONNX file.
[[nodiscard]] ModelSpec parse_model_yaml(const YAML::Node& root, const std::filesystem::path& folder,
                                         Problems& problems);

}  // namespace extperfc::detect
