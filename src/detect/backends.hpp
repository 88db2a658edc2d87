#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/detect/inference.hpp"
#include "extperfc/detect/model_spec.hpp"

namespace extperfc::detect {

// One loader per library. Errors name the library's complaint; make_backend() adds model, back end and
// device.
[[nodiscard]] Result<std::unique_ptr<InferenceBackend>> load_opencv(const ModelSpec& spec,
                                                                    const InferenceOptions& options);
[[nodiscard]] std::string opencv_version();
[[nodiscard]] Result<std::unique_ptr<InferenceBackend>> load_openvino(const ModelSpec& spec,
                                                                      const InferenceOptions& options);
[[nodiscard]] std::string openvino_version();

/// The essence of a library's message: its last line that says something, at most 200 characters.
[[nodiscard]] std::string shortened(std::string_view library_text);

/// The tensors of OutputSpec::names, or the network's only output when none are named; `existing` are the
/// names of its `output_count` outputs. Errors: a name that does not exist, several outputs and no names.
[[nodiscard]] Result<std::vector<std::string>> output_names(const ModelSpec& spec,
                                                            const std::vector<std::string>& existing,
                                                            std::size_t output_count);

}  // namespace extperfc::detect
