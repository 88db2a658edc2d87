#include "test/benchmark/translate/options.hpp"

#include <cstdlib>
#include <set>

namespace extperfc::benchmark {
namespace {

Result<double> number_from(const std::string& option, const char* text, double lower, double upper) {
  char* end = nullptr;
  const double value = std::strtod(text, &end);
  if (end == text || *end != '\0' || !(value >= lower) || value > upper)
    return fail(ErrorCode::kInvalidArgument, option + " needs a number from " + std::to_string(lower) +
                                                 " to " + std::to_string(upper) + ", not '" + text + "'");
  return value;
}

Result<void> set_text(TranslateOptions& options, const std::string& option, const std::string& text) {
  if (option == "--json") options.json = text;
  if (option != "--only") return {};
  if (text != "latency" && text != "load" && text != "conversion")
    return fail(ErrorCode::kInvalidArgument, "--only needs latency, load or conversion, not '" + text + "'");
  options.only = text;
  return {};
}

Result<void> set_number(TranslateOptions& options, const std::string& option, const char* text) {
  const auto value = option == "--seconds"  ? number_from(option, text, 0.1, 3'600)
                     : option == "--topics" ? number_from(option, text, 1, 2'000)
                     : option == "--rate"   ? number_from(option, text, 1, 1e6)
                                            : number_from(option, text, 20, 1e6);
  if (!value) return tl::unexpected(value.error());
  if (option == "--seconds") options.seconds = *value;
  if (option == "--topics") options.topics = static_cast<int>(*value);
  if (option == "--rate") options.rate_hz = *value;
  if (option == "--samples") options.samples = static_cast<int>(*value);
  return {};
}

Result<void> set_option(TranslateOptions& options, const std::string& option, const char* text) {
  static const std::set<std::string> kTexts{"--json", "--only"};
  static const std::set<std::string> kNumbers{"--samples", "--seconds", "--topics", "--rate"};
  if (kTexts.count(option) != 0) return set_text(options, option, text);
  if (kNumbers.count(option) != 0) return set_number(options, option, text);
  return fail(ErrorCode::kInvalidArgument, "unknown option " + option + "; see --help");
}

}  // namespace

Result<TranslateOptions> parse_translate_options(int argc, char** argv) {
  TranslateOptions options;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--help" || option == "-h") {
      options.help = true;
      return options;
    }
    if (i + 1 >= argc)
      return fail(ErrorCode::kInvalidArgument, option + " is unknown or needs a value; see --help");
    if (auto set = set_option(options, option, argv[++i]); !set) return tl::unexpected(set.error());
  }
  return options;
}

void print_translate_help(std::ostream& out) {
  out << "usage: tools/bench translate [--only PART] [--samples N] [--seconds N] [--topics N] [--rate HZ] "
         "[--json FILE]\n\n"
         "The translator between two masters of this machine, against a direct connection and a raw roscpp "
         "relay\n"
         "in the same run: latency and CPU by size, many topics at once, and the conversion alone.\n\n"
         "  --only      latency, load or conversion (default: all three)\n"
         "  --samples   messages of each route and size; fewer of the large ones (default 2000)\n"
         "  --seconds   of each measurement under load (default 10)\n"
         "  --topics    under load (default 500)\n"
         "  --rate      messages of all topics together under load (default 20000 per second)\n"
         "  --json      write the results too\n";
}

}  // namespace extperfc::benchmark
