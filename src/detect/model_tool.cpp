#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <map>
#include <optional>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <unistd.h>

#include "extperfc/base/running_stats.hpp"
#include "extperfc/base/text.hpp"
#include "extperfc/detect/detector.hpp"

namespace fs = std::filesystem;
using namespace extperfc;          // NOLINT: a program, not a header
using namespace extperfc::detect;  // NOLINT

namespace {

constexpr int kFine = 0;
constexpr int kProblem = 1;
constexpr int kUsage = 2;
constexpr int kTimedImages = 10;

constexpr const char* kHelp =
    R"(Looks at detection models: folders with a model.yaml (models/README.md has the format).

  extperfc-model check FOLDER             says what is wrong, or what the model is and how fast it runs here
  extperfc-model list [FOLDER...]         one line per model; FOLDER is a model or a folder of models
  extperfc-model run FOLDER IMAGE       prints class, score and box (x_min y_min x_max y_max, pixels)

Options:
  --out FILE          run: writes the image with the boxes drawn in
  --score NUMBER      run: minimum score, 0 to 1, instead of the model's
  --backend NAME      auto (default), opencv or openvino
  --device NAME       CPU (default), GPU, NPU or AUTO
  --precision NAME    f32 (default), f16 or bf16
  --mode NAME         latency (default) or throughput
  --threads NUMBER    0 (default) = the library chooses
  --cache FOLDER      keeps compiled models there
  --known FOLDER      descriptions of public networks, instead of the package's own
  --help              this text

Exit status: 0 fine, 1 something is wrong with a model or image, 2 wrong arguments.
)";

struct Arguments {
  std::string command;
  std::vector<std::string> operands;
  std::map<std::string, std::string> options;

  [[nodiscard]] std::string option(const std::string& name, const std::string& otherwise) const {
    const auto found = options.find(name);
    return found == options.end() ? otherwise : found->second;
  }
};

int complain(const std::string& message, int status) {
  std::cerr << "extperfc-model: " << message << (status == kUsage ? " (--help lists the arguments)\n" : "\n");
  return status;
}

Result<Arguments> parse(const std::vector<std::string>& tokens) {
  constexpr std::array<const char*, 9> kOptions{"--out",  "--score",   "--backend", "--device", "--precision",
                                                "--mode", "--threads", "--cache",   "--known"};
  Arguments arguments;
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    const std::string& token = tokens[i];
    if (token.rfind("--", 0) != 0) {
      (arguments.command.empty() ? arguments.command : arguments.operands.emplace_back()) = token;
    } else if (std::find(kOptions.begin(), kOptions.end(), token) == kOptions.end()) {
      return fail(ErrorCode::kInvalidArgument, "unknown option " + token);
    } else if (i + 1 == tokens.size()) {
      return fail(ErrorCode::kInvalidArgument, token + " needs a value");
    } else {
      arguments.options[token] = tokens[++i];
    }
  }
  return arguments;
}

template <typename T>
Result<T> number_option(const Arguments& arguments, const std::string& name, T otherwise, T low, T high) {
  const std::string text = arguments.option(name, "");
  if (text.empty()) return otherwise;
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && value >= low && value <= high) return value;
  return fail(ErrorCode::kInvalidArgument, name + " must be a number in [" + std::to_string(low) + ", " +
                                               std::to_string(high) + "], not \"" + text + "\"");
}

Result<InferenceOptions> inference_options(const Arguments& arguments) {
  const auto precision = precision_from_name(arguments.option("--precision", "f32"));
  if (!precision) return tl::unexpected(precision.error());
  const auto mode = mode_from_name(arguments.option("--mode", "latency"));
  if (!mode) return tl::unexpected(mode.error());
  const auto threads = number_option(arguments, "--threads", 0, 0, 1024);
  if (!threads) return tl::unexpected(threads.error());
  return InferenceOptions{
      arguments.option("--backend", "auto"), arguments.option("--device", "CPU"), *threads, *precision, *mode,
      arguments.option("--cache", "")};
}

/// Where the package's data lies: beside an installed program, else in the sources it was built from.
fs::path package_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed = program.parent_path() / "../../share/extperfc";
  return fs::is_directory(installed / "config/models", error) ? installed : fs::path(EXTPERFC_SOURCE_DIR);
}

fs::path known_models(const Arguments& arguments) {
  return arguments.option("--known", (package_folder() / "config/models").string());
}

cv::Mat grey_image(const ModelSpec& spec) {
  return {spec.input.height, spec.input.width, CV_8UC3, cv::Scalar::all(114)};
}

ImageView view_of(const cv::Mat& image) {
  return {image.data, image.cols, image.rows, image.step, PixelFormat::kBgr8};
}

void print_row(const char* key, const std::string& value) {
  std::printf("  %-11s %s\n", key, value.c_str());
}

std::string input_text(const InputSpec& input) {
  return std::to_string(input.width) + " x " + std::to_string(input.height) + (input.bgr ? " bgr" : " rgb") +
         (input.resize == Resize::kLetterbox ? ", letterbox" : ", stretch") +
         (input.interpolation == Interpolation::kArea ? ", area" : ", linear");
}

std::string or_unknown(const std::string& text) {
  return text.empty() ? "not stated" : text;
}

void print_summary(const ModelSpec& spec) {
  std::printf("%s\n", spec.name.c_str());
  print_row("file", spec.file.string());
  print_row("sha256", spec.sha256);
  print_row("input", input_text(spec.input));
  print_row("outputs", (spec.output.names.empty() ? "the only one" : joined(spec.output.names)) +
                           " (layout " + to_string(spec.output.layout) + ")");
  print_row("classes", std::to_string(spec.classes.size()) + ": " + joined(spec.classes));
  print_row("source", or_unknown(spec.source));
  print_row("licence", or_unknown(spec.license));
}

/// Median of the inference's wall time over grey images, and what is found in the last one.
Result<std::string> try_backend(const ModelSpec& spec, const InferenceOptions& options) {
  auto detector = Detector::create(spec, options);
  if (!detector) return tl::unexpected(detector.error());
  const cv::Mat image = grey_image(spec);
  std::vector<double> times;
  std::size_t found = 0;
  for (int i = 0; i < kTimedImages; ++i) {
    const auto output = detector->detect(view_of(image));
    if (!output) return tl::unexpected(output.error());
    times.push_back(output->times.inference_ms);
    found = output->detections.size();
  }
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.2f ms per inference, ", percentile(times, 0.5));
  return text.data() + detector->backend().execution() + "; " + std::to_string(found) +
         " detections on a grey image";
}

int check(const Arguments& arguments, InferenceOptions options) {
  const auto spec = load_model_spec(arguments.operands[0], known_models(arguments));
  if (!spec) return complain(spec.error().message, kProblem);
  print_summary(*spec);
  std::vector<std::string> backends = available_backends();
  if (options.backend != "auto") backends.assign(1, options.backend);
  int working = 0;
  for (const auto& name : backends) {
    options.backend = name;
    const auto result = try_backend(*spec, options);
    print_row(name.c_str(), result ? *result : "FAILS: " + result.error().message);
    working += result ? 1 : 0;
  }
  return working > 0 ? kFine : complain("no back end can run " + spec->name, kProblem);
}

/// The folder itself when it is a model, else the models below it.
std::vector<fs::path> model_folders(const fs::path& folder, const fs::path& known) {
  std::vector<fs::path> folders;
  std::error_code error;
  if (load_model_spec(folder, known)) return {folder};
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.is_directory(error)) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  return folders.empty() ? std::vector<fs::path>{folder} : folders;
}

int list(const Arguments& arguments, const InferenceOptions& /*options*/) {
  const fs::path known = known_models(arguments);
  std::vector<std::string> places = arguments.operands;
  if (places.empty()) places.push_back((package_folder() / "models").string());
  int status = kFine;
  for (const auto& place : places)
    for (const auto& folder : model_folders(place, known)) {
      const auto spec = load_model_spec(folder, known);
      if (!spec) {
        status = complain(spec.error().message, kProblem);
        continue;
      }
      std::printf("%-24s %-12s %4d x %-4d %3zu classes  %s\n", spec->name.c_str(),
                  to_string(spec->output.layout), spec->input.width, spec->input.height, spec->classes.size(),
                  folder.c_str());
    }
  return status;
}

void print_detections(const ModelSpec& spec, const DetectorOutput& output) {
  for (const auto& [index, score, box] : output.detections)
    std::printf("%-16s %.3f  %7.1f %7.1f %7.1f %7.1f\n",
                spec.classes[static_cast<std::size_t>(index)].c_str(), static_cast<double>(score),
                static_cast<double>(box.x_min), static_cast<double>(box.y_min),
                static_cast<double>(box.x_max), static_cast<double>(box.y_max));
}

void draw(const ModelSpec& spec, const Detections& detections, cv::Mat& image) {
  for (const auto& [index, score, box] : detections) {
    // Neighbouring classes get hues far apart (golden angle).
    const cv::Mat hsv(1, 1, CV_8UC3, cv::Scalar((index * 69) % 180, 255, 255));
    cv::Mat bgr;
    cv::cvtColor(hsv, bgr, cv::COLOR_HSV2BGR);
    const cv::Scalar colour(bgr.at<cv::Vec3b>(0, 0));
    const cv::Point corner(cvRound(box.x_min), cvRound(box.y_min));
    cv::rectangle(image, corner, {cvRound(box.x_max), cvRound(box.y_max)}, colour, 2);
    std::array<char, 16> number{};
    std::snprintf(number.data(), number.size(), " %.2f", static_cast<double>(score));
    const cv::Point text_at(corner.x + 3, std::max(12, corner.y - 4));
    cv::putText(image, spec.classes[static_cast<std::size_t>(index)] + number.data(), text_at,
                cv::FONT_HERSHEY_SIMPLEX, 0.5, colour, 1, cv::LINE_AA);
  }
}

int write_image(const std::string& file, const cv::Mat& image) try {
  if (cv::imwrite(file, image)) return kFine;
  return complain("cannot write " + file, kProblem);
} catch (const cv::Exception&) {
  return complain("cannot write " + file + ": end its name with .png or .jpg", kProblem);
}

int run(const Arguments& arguments, const InferenceOptions& options) {
  auto spec = load_model_spec(arguments.operands[0], known_models(arguments));
  if (!spec) return complain(spec.error().message, kProblem);
  const auto score = number_option(arguments, "--score", spec->thresholds.score, 0.0F, 1.0F);
  if (!score) return complain(score.error().message, kUsage);
  spec->thresholds.score = *score;
  cv::Mat image = cv::imread(arguments.operands[1], cv::IMREAD_COLOR);
  if (image.empty()) return complain("cannot read the image " + arguments.operands[1], kProblem);
  auto detector = Detector::create(*spec, options);
  if (!detector) return complain(detector.error().message, kProblem);
  const auto output = detector->detect(view_of(image));
  if (!output) return complain(output.error().message, kProblem);

  print_detections(*spec, *output);
  std::printf("%zu detections; preprocessing %.2f, inference %.2f, decoding %.2f ms; %s\n",
              output->detections.size(), output->times.preprocess_ms, output->times.inference_ms,
              output->times.decode_ms, detector->execution().c_str());
  const std::string out = arguments.option("--out", "");
  if (out.empty()) return kFine;
  draw(*spec, output->detections, image);
  return write_image(out, image);
}

struct Command {
  const char* name;
  std::size_t min_operands;
  std::size_t max_operands;
  const char* usage;
  std::function<int(const Arguments&, const InferenceOptions&)> execute;
};

int dispatch(const Arguments& arguments) {
  const std::array<Command, 3> commands{{{"check", 1, 1, "check FOLDER", check},
                                         {"list", 0, 1000, "list [FOLDER...]", list},
                                         {"run", 2, 2, "run FOLDER IMAGE", run}}};
  if (arguments.command.empty()) return complain("give a command: check, list or run", kUsage);
  for (const Command& command : commands) {
    if (arguments.command != command.name) continue;
    const std::size_t count = arguments.operands.size();
    if (count < command.min_operands || count > command.max_operands)
      return complain("the command is: " + std::string(command.usage), kUsage);
    const auto options = inference_options(arguments);
    return options ? command.execute(arguments, *options) : complain(options.error().message, kUsage);
  }
  return complain("unknown command \"" + arguments.command + "\": use check, list or run", kUsage);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> tokens(argv + 1, argv + argc);
  if (std::find(tokens.begin(), tokens.end(), "--help") != tokens.end()) {
    std::cout << kHelp;
    return kFine;
  }
  const auto arguments = parse(tokens);
  return arguments ? dispatch(*arguments) : complain(arguments.error().message, kUsage);
}
