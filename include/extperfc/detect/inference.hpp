#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/detect/model_spec.hpp"

namespace extperfc::detect {

enum class Precision { kF32, kF16, kBf16 };
enum class Mode {
  kLatency,     ///< one frame at a time, as fast as possible
  kThroughput,  ///< several frames in flight (OpenVINO streams); more frames/s, later each
};

[[nodiscard]] Result<Precision> precision_from_name(const std::string& name);  ///< f32, f16, bf16
[[nodiscard]] Result<Mode> mode_from_name(const std::string& name);            ///< latency, throughput
[[nodiscard]] const char* to_string(Precision precision);
[[nodiscard]] const char* to_string(Mode mode);

struct InferenceOptions {
  std::string backend{"auto"};  ///< opencv, openvino, or auto = the fastest that loads the model
  std::string device{"CPU"};    ///< CPU, GPU, NPU or AUTO; OpenCV DNN offers CPU only
  int threads{0};               ///< 0 = as many as the library chooses
  Precision precision{Precision::kF32};
  Mode mode{Mode::kLatency};
  /// Where OpenVINO keeps compiled models and auto remembers which back end was the fastest; empty = nowhere.
  std::filesystem::path cache_dir;
};

/// A float32 tensor inside a back end's memory: row-major. Valid until the next infer() on the same slot.
struct TensorView {
  std::vector<int> shape;
  const float* data{nullptr};

  [[nodiscard]] std::size_t size() const;
};

/// One network, loaded and ready, behind one interface for all libraries.
///
/// A back end has one or more slots; each has its own input buffer and outputs. Different threads may infer
/// on different slots at the same time; one slot serves one thread at a time.
class InferenceBackend {
 public:
  InferenceBackend() = default;
  InferenceBackend(const InferenceBackend&) = delete;
  InferenceBackend& operator=(const InferenceBackend&) = delete;
  virtual ~InferenceBackend() = default;

  [[nodiscard]] virtual std::string name() const = 0;
  /// What really executes, e.g. "CPU f32, 1 stream, 2 threads": read back from the library, not the request.
  [[nodiscard]] virtual std::string execution() const = 0;
  /// Number of slots, at least 1.
  [[nodiscard]] virtual int slots() const = 0;
  /// Input buffer [3, height, width] of a slot; write the preprocessed image here: no copy follows.
  [[nodiscard]] virtual float* input(int slot) = 0;
  /// Runs the network on the slot's input. Outputs are in the order of ModelSpec::output.names.
  [[nodiscard]] virtual Result<std::vector<TensorView>> infer(int slot) = 0;
};

/// Names of the back ends in this build, fastest first: "openvino" (if built with it), "opencv".
[[nodiscard]] std::vector<std::string> available_backends();

/// Loads the model. OpenCV's number of threads is one setting for the process: `threads` changes it for all
/// who use OpenCV there. For "auto" every available back end that loads it is timed (ten inferences) and the
/// fastest is kept. Runs one inference before it returns, so that a network which loads but cannot run is an
/// error here. Errors name model, back end and device, list the devices that exist, and say what to change.
[[nodiscard]] Result<std::unique_ptr<InferenceBackend>> make_backend(const ModelSpec& spec,
                                                                     const InferenceOptions& options);

}  // namespace extperfc::detect
