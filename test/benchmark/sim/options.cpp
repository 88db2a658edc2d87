#include "test/benchmark/sim/options.hpp"

#include <cstdlib>
#include <map>

namespace extperfc::benchmark {
namespace {

Result<double> positive_number(const std::string& option, const char* text) {
  char* end = nullptr;
  const double value = std::strtod(text, &end);
  if (end == text || *end != '\0' || !(value > 0) || value > 1e6)
    return fail(ErrorCode::kInvalidArgument, option + " needs a number above 0, not '" + text + "'");
  return value;
}

Result<void> set_option(SimOptions& options, const std::string& option, const char* text) {
  if (option == "--world") {
    options.world = text;
  } else if (option == "--json") {
    options.json = text;
  } else {
    const auto value = positive_number(option, text);
    if (!value) return tl::unexpected(value.error());
    if (option == "--seconds") options.seconds = *value;
    if (option == "--frames") options.frames = static_cast<int>(*value) + (*value < 1 ? 1 : 0);
  }
  return {};
}

}  // namespace

Result<SimOptions> parse_sim_options(int argc, char** argv) {
  SimOptions options;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option.rfind("__", 0) == 0 || option.find(":=") != std::string::npos) continue;  // ROS's own
    if (option == "--help" || option == "-h") {
      options.help = true;
      return options;
    }
    if (option != "--world" && option != "--json" && option != "--seconds" && option != "--frames")
      return fail(ErrorCode::kInvalidArgument, "unknown option " + option + "; see --help");
    if (i + 1 >= argc) return fail(ErrorCode::kInvalidArgument, option + " needs a value");
    if (auto set = set_option(options, option, argv[++i]); !set) return tl::unexpected(set.error());
  }
  return options;
}

void print_sim_help(std::ostream& out) {
  out << "usage: tools/bench sim [--world NAME|FILE] [--seconds N] [--frames N] [--json FILE]\n\n"
         "The simulated robot: what a step of the physics, a camera frame and a lidar sweep cost, and how "
         "fast the\n"
         "whole simulator runs with every sensor subscribed and with none.\n\n"
         "  --world     a world of config/worlds or a file (default lab)\n"
         "  --seconds   of every measurement of the whole simulator (default 15)\n"
         "  --frames    of every sensor alone (default 60)\n"
         "  --json      write the results too\n";
}

}  // namespace extperfc::benchmark
