#pragma once

#include <filesystem>
#include <string>

#include "extperfc/detect/inference.hpp"
#include "extperfc/detect/model_spec.hpp"

namespace extperfc::detect {

/// Remembers in a small file of InferenceOptions::cache_dir which back end was the fastest for a model, so
/// that the next start need not time them again. Another network, device, number of threads, precision, mode
/// or library version makes another file. Without a cache folder, or when it cannot be written, nothing is
/// remembered.
class BackendChoice {
 public:
  BackendChoice(const ModelSpec& spec, const InferenceOptions& options);

  /// Name of the back end, empty when unknown.
  [[nodiscard]] std::string recall() const;
  void remember(const std::string& backend) const;

 private:
  std::string key_;
  std::filesystem::path file_;  ///< empty: remember nothing
};

}  // namespace extperfc::detect
