#pragma once

#include <filesystem>

#include <yaml-cpp/yaml.h>

#include "extperfc/base/problems.hpp"
#include "extperfc/detect/model_spec.hpp"

namespace extperfc::detect {

/// The description in `root`, with every problem noted in `problems`; files are named relative to `folder`.
/// Looks into `classes_file` but not into the ONNX file.
[[nodiscard]] ModelSpec parse_model_yaml(const YAML::Node& root, const std::filesystem::path& folder,
                                         Problems& problems);

}  // namespace extperfc::detect
