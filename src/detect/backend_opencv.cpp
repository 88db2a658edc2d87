#include <algorithm>
#include <utility>

#include <opencv2/core/utils/logger.hpp>
#include <opencv2/core/version.hpp>
#include <opencv2/dnn.hpp>

#include "detect/backends.hpp"

namespace extperfc::detect {

namespace {

/// Keeps OpenCV from writing to stderr what its exceptions say as well. Process-wide while it lives.
class QuietOpenCv {
 public:
  QuietOpenCv() : level_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {
    previous_ = cv::redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
  }
  QuietOpenCv(const QuietOpenCv&) = delete;
  QuietOpenCv& operator=(const QuietOpenCv&) = delete;
  ~QuietOpenCv() {
    cv::redirectError(previous_);
    cv::utils::logging::setLogLevel(level_);
  }

 private:
  cv::utils::logging::LogLevel level_;
  cv::ErrorCallback previous_{nullptr};
};

/// OpenCV's own network runner: CPU, float32, one slot.
///
/// OpenCV's number of threads is one setting for the whole process: InferenceOptions::threads also changes it
/// for everything else here that uses OpenCV, and the last model loaded decides.
class OpenCvBackend : public InferenceBackend {
 public:
  OpenCvBackend(const cv::dnn::Net& net, const InputSpec& input, std::vector<std::string> outputs)
      : net_(net), input_name_(input.name), output_names_(std::move(outputs)) {
    const int shape[] = {1, 3, input.height, input.width};
    input_ = cv::Mat(4, shape, CV_32F, cv::Scalar(0));
  }

  std::string name() const override { return "opencv"; }
  std::string execution() const override {
    const int threads = cv::getNumThreads();
    return "CPU f32, " + std::to_string(threads) + (threads == 1 ? " thread" : " threads");
  }
  int slots() const override { return 1; }
  float* input(int /*slot*/) override { return input_.ptr<float>(); }

  Result<std::vector<TensorView>> infer(int /*slot*/) override try {
    net_.setInput(input_, input_name_);
    net_.forward(outputs_, output_names_);
    std::vector<TensorView> views;
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
      const cv::Mat& output = outputs_[i];
      if (output.type() != CV_32F || !output.isContinuous())
        return fail(ErrorCode::kUnsupported, "output \"" + output_names_[i] + "\" is not float32");
      views.push_back({{output.size.p, output.size.p + output.dims}, output.ptr<float>()});
    }
    return views;
  } catch (const cv::Exception& error) {
    return fail(ErrorCode::kFailed, "inference: " + shortened(error.err));
  }

 private:
  cv::dnn::Net net_;
  std::string input_name_;
  std::vector<std::string> output_names_;
  cv::Mat input_;
  std::vector<cv::Mat> outputs_;
};

Result<void> check_options(const InferenceOptions& options) {
  if (options.device != "CPU")
    return fail(ErrorCode::kUnsupported,
                "OpenCV DNN runs on the CPU only: set device to CPU, or backend to openvino");
  if (options.precision != Precision::kF32)
    return fail(ErrorCode::kUnsupported,
                "OpenCV DNN computes in f32 only: set precision to f32, or backend to openvino");
  return {};
}

Result<void> check_input_name(cv::dnn::Net& net, const InputSpec& input) {
  constexpr int kInputLayer = 0;
  if (input.name.empty() || net.getLayer(kInputLayer)->outputNameToIndex(input.name) >= 0) return {};
  return fail(ErrorCode::kInvalidArgument, "the network has no input \"" + input.name +
                                               "\": correct input.name in model.yaml, or leave it out");
}

}  // namespace

Result<std::unique_ptr<InferenceBackend>> load_opencv(const ModelSpec& spec,
                                                      const InferenceOptions& options) {
  if (const auto checked = check_options(options); !checked) return tl::unexpected(checked.error());
  const QuietOpenCv quiet;
  try {
    cv::dnn::Net net = cv::dnn::readNetFromONNX(spec.file.string());
    net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    if (const auto checked = check_input_name(net, spec.input); !checked)
      return tl::unexpected(checked.error());
    const auto existing = net.getUnconnectedOutLayersNames();
    const auto outputs = output_names(spec, existing, existing.size());
    if (!outputs) return tl::unexpected(outputs.error());
    if (options.threads > 0) cv::setNumThreads(options.threads);
    auto backend = std::make_unique<OpenCvBackend>(std::move(net), spec.input, *outputs);
    // Shapes that do not fit show only now; here, while OpenCV is quiet.
    if (const auto tried = backend->infer(0); !tried) return tl::unexpected(tried.error());
    return backend;
  } catch (const cv::Exception& error) {
    return fail(ErrorCode::kCorrupt, "not an ONNX network that OpenCV can read: " + shortened(error.err));
  }
}

std::string opencv_version() {
  return CV_VERSION;
}

}  // namespace extperfc::detect
