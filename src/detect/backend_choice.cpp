#include "detect/backend_choice.hpp"

#include <fstream>
#include <functional>
#include <sstream>
#include <system_error>
#include <thread>

#include "detect/backends.hpp"

namespace extperfc::detect {

namespace fs = std::filesystem;

namespace {

std::string versions() {
  std::string text = "opencv " + opencv_version();
#ifdef EXTPERFC_HAVE_OPENVINO
  text += ", openvino " + openvino_version();
#endif
  return text;
}

std::string key_of(const ModelSpec& spec, const InferenceOptions& options) {
  std::ostringstream key;
  key << spec.sha256 << ' ' << spec.input.width << 'x' << spec.input.height << ", " << options.device << ", "
      << options.threads << " of " << std::thread::hardware_concurrency() << " threads, "
      << to_string(options.precision) << ", " << to_string(options.mode) << ", " << versions();
  return key.str();
}

}  // namespace

BackendChoice::BackendChoice(const ModelSpec& spec, const InferenceOptions& options)
    : key_(key_of(spec, options)) {
  if (options.cache_dir.empty() || spec.sha256.empty()) return;
  std::ostringstream name;
  name << "fastest_backend_" << std::hex << std::hash<std::string>{}(key_) << ".txt";
  file_ = options.cache_dir / name.str();
}

std::string BackendChoice::recall() const {
  std::ifstream stream(file_);
  std::string key;
  std::string backend;
  if (!std::getline(stream, key) || !std::getline(stream, backend) || key != key_) return "";
  return backend;
}

void BackendChoice::remember(const std::string& backend) const {
  if (file_.empty()) return;
  std::error_code ignored;
  fs::create_directories(file_.parent_path(), ignored);
  // Renamed into place, so that another process never reads half a file.
  const fs::path partial = file_.string() + ".partial";
  std::ofstream(partial) << key_ << '\n' << backend << '\n';
  fs::rename(partial, file_, ignored);
}

}  // namespace extperfc::detect
