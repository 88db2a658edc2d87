#include "test/benchmark/detect/options.hpp"

#include <charconv>
#include <optional>
#include <ostream>

namespace extperfc::benchmark {

namespace {

constexpr char kHelp[] =
    "bench_detect [options]; needs a ROS master, which tools/bench starts\n"
    "  --model FOLDER     measure this model besides those in models/ (repeatable)\n"
    "  --images FOLDER  aligned colour and depth images (rgb/ and depth/); default: one drawn image\n"
    "  --frames N         per case: N through the nodelets, N of inference alone, N of the core alone (60)\n"
    "  --backend NAME     openvino or opencv alone\n"
    "  --threads N        this number of threads alone; default: 1, then all cores\n"
    "  --score S          score threshold, 0 to 1; default: the model's own\n"
    "  --json FILE        write the results\n";

constexpr int kMaxFrames = 1'000'000;
constexpr int kMaxThreads = 256;

template <typename Number>
std::optional<Number> number(const std::string& text, Number low, Number high) {
  Number value{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !(value >= low && value <= high)) return std::nullopt;
  return value;
}

template <typename Number>
Result<void> set_number(const std::string& name, const std::string& text, Number low, Number high,
                        Number& value) {
  const auto given = number(text, low, high);
  if (!given)
    return fail(ErrorCode::kInvalidArgument, name + " needs a number from " + std::to_string(low) + " to " +
                                                 std::to_string(high) + ", not '" + text + "'");
  value = *given;
  return {};
}

Result<void> set_backend(const std::string& name, DetectOptions& options) {
  if (name != "openvino" && name != "opencv")
    return fail(ErrorCode::kInvalidArgument, "--backend must be openvino or opencv, not '" + name + "'");
  options.backends = {name};
  return {};
}

Result<void> set_option(const std::string& name, const std::string& value, DetectOptions& options) {
  if (name == "--model") {
    options.models.emplace_back(value);
  } else if (name == "--images") {
    options.images = value;
  } else if (name == "--json") {
    options.json = value;
  } else if (name == "--frames") {
    return set_number(name, value, 1, kMaxFrames, options.frames);
  } else if (name == "--score") {
    return set_number(name, value, 0.0, 1.0, options.score);
  } else if (name == "--threads") {
    return set_number(name, value, 1, kMaxThreads, options.threads.emplace_back());
  } else if (name == "--backend") {
    return set_backend(value, options);
  } else {
    return fail(ErrorCode::kInvalidArgument, "unknown option '" + name + "'; see --help");
  }
  return {};
}

}  // namespace

void print_help(std::ostream& out) {
  out << kHelp;
}

Result<DetectOptions> parse_detect_options(int argc, char** argv) {
  DetectOptions options;
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i];
    options.help = name == "--help" || name == "-h";
    if (options.help) return options;
    if (i + 1 >= argc)
      return fail(ErrorCode::kInvalidArgument, "unknown option or missing value: '" + name + "'; see --help");
    if (auto set = set_option(name, argv[i + 1], options); !set) return tl::unexpected(set.error());
  }
  return options;
}

}  // namespace extperfc::benchmark
