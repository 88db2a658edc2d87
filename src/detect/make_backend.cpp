#include <algorithm>
#include <limits>
#include <utility>

#include "extperfc/base/running_stats.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/base/text.hpp"
#include "extperfc/detect/decode.hpp"

#include "detect/backend_choice.hpp"
#include "detect/backends.hpp"

namespace extperfc::detect {

namespace {

using LoadedBackend = Result<std::unique_ptr<InferenceBackend>>;

constexpr int kWarmUps = 2;
constexpr int kTimedInferences = 10;
constexpr float kPaddingGrey = 114.0F;

struct Library {
  const char* name;
  LoadedBackend (*load)(const ModelSpec&, const InferenceOptions&);
};

constexpr Library kLibraries[] = {
#ifdef EXTPERFC_HAVE_OPENVINO
    {"openvino", &load_openvino},
#endif
    {"opencv", &load_opencv},
};

tl::unexpected<Error> with_context(const ModelSpec& spec, const std::string& backend,
                                   const std::string& device, const Error& error) {
  return fail(error.code, "model " + spec.name + " (" + spec.file.string() + ") with " + backend + " on " +
                              device + ": " + error.message);
}

/// Runs the network on a grey image, so that one which loads but cannot run is found out here.
Result<void> try_out(const ModelSpec& spec, InferenceBackend& backend) {
  const auto plane = static_cast<std::size_t>(spec.input.width) * static_cast<std::size_t>(spec.input.height);
  for (int slot = 0; slot < backend.slots(); ++slot)
    for (std::size_t c = 0; c < 3; ++c)
      std::fill_n(backend.input(slot) + c * plane, plane,
                  (kPaddingGrey - spec.input.mean[c]) * spec.input.scale[c]);
  const auto outputs = backend.infer(0);
  if (!outputs) return tl::unexpected(outputs.error());
  return check_outputs(spec, *outputs);
}

LoadedBackend load(const Library& library, const ModelSpec& spec, const InferenceOptions& options) {
  auto backend = library.load(spec, options);
  if (!backend) return with_context(spec, library.name, options.device, backend.error());
  if (const auto tried = try_out(spec, **backend); !tried)
    return with_context(spec, library.name, options.device, tried.error());
  return backend;
}

/// Median wall time of one inference [ms]; infinite when it fails.
double median_ms(InferenceBackend& backend) {
  std::vector<double> times;
  for (int i = 0; i < kWarmUps + kTimedInferences; ++i) {
    const Stopwatch watch;
    if (!backend.infer(0)) return std::numeric_limits<double>::infinity();
    if (i >= kWarmUps) times.push_back(watch.milliseconds());
  }
  return percentile(times, 0.5);
}

/// Every back end that loads the model, or the reasons why none does.
Result<std::vector<std::unique_ptr<InferenceBackend>>> load_all(const ModelSpec& spec,
                                                                const InferenceOptions& options) {
  std::vector<std::unique_ptr<InferenceBackend>> loaded;
  std::vector<Error> errors;
  for (const Library& library : kLibraries) {
    auto backend = load(library, spec, options);
    if (backend)
      loaded.push_back(std::move(*backend));
    else
      errors.push_back(backend.error());
  }
  if (!loaded.empty()) return loaded;
  std::string message;
  for (const Error& error : errors) message += (message.empty() ? "" : "; ") + error.message;
  return fail(errors.front().code, message);
}

/// Times what loads and keeps the fastest.
LoadedBackend load_fastest(const ModelSpec& spec, const InferenceOptions& options) {
  auto candidates = load_all(spec, options);
  if (!candidates) return tl::unexpected(candidates.error());
  if (candidates->size() == 1) return std::move(candidates->front());
  std::vector<std::pair<double, std::size_t>> ranking;
  for (std::size_t i = 0; i < candidates->size(); ++i) ranking.emplace_back(median_ms(*(*candidates)[i]), i);
  return std::move((*candidates)[std::min_element(ranking.begin(), ranking.end())->second]);
}

const Library* find_library(const std::string& name) {
  const auto* found = std::find_if(std::begin(kLibraries), std::end(kLibraries),
                                   [&name](const Library& library) { return name == library.name; });
  return found == std::end(kLibraries) ? nullptr : found;
}

LoadedBackend load_auto(const ModelSpec& spec, const InferenceOptions& options) {
  const BackendChoice choice(spec, options);
  if (const Library* library = find_library(choice.recall())) {
    auto backend = load(*library, spec, options);
    if (backend) return backend;
  }
  auto backend = load_fastest(spec, options);
  if (backend) choice.remember((*backend)->name());
  return backend;
}

}  // namespace

std::vector<std::string> available_backends() {
  std::vector<std::string> names;
  for (const Library& library : kLibraries) names.emplace_back(library.name);
  return names;
}

Result<std::unique_ptr<InferenceBackend>> make_backend(const ModelSpec& spec,
                                                       const InferenceOptions& options) {
  if (options.threads < 0)
    return fail(ErrorCode::kInvalidArgument,
                "threads must be 0 (the library chooses) or more, not " + std::to_string(options.threads));
  if (options.backend == "auto") return load_auto(spec, options);
  if (const Library* library = find_library(options.backend)) return load(*library, spec, options);
  const bool left_out = options.backend == "openvino";
  return fail(left_out ? ErrorCode::kUnsupported : ErrorCode::kInvalidArgument,
              (left_out ? "this build has no back end openvino: run tools/setup, or use one of auto, "
                        : "unknown back end \"" + options.backend + "\": use one of auto, ") +
                  enumeration(available_backends()));
}

}  // namespace extperfc::detect
