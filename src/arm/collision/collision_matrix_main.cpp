#include <exception>
#include <iostream>
#include <map>
#include <string>

#include "extperfc/arm/collision_matrix.hpp"
#include "extperfc/base/arguments.hpp"
#include "extperfc/base/atomic_file.hpp"

namespace extperfc::arm {
namespace {

constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kUsage = 2;

constexpr const char* kHelp = R"(Lists the links of a robot that need no check against each other, as an SRDF.

  extperfc-collision-matrix URDF [OPTION ...]

Tries random positions of all joints within their limits and writes <disable_collisions> for links that are rigid to
each other (Rigid), joined by one joint (Adjacent), neighbours on a chain whose rough shapes overlap where it bends
(Neighbours), in contact in nearly all samples (Always), or never near each other (Never).

Options:
  --output FILE.srdf     where to write; standard output by default
  --keep FILE.srdf       keeps groups, states and end effectors of this file; may be the output file
  --samples N            random positions, 20000 by default
  --seed N               of the random positions, 1 by default
  --clearance METRES     pairs that come nearer than this stay enabled, 0.02 by default
  --resources FOLDER     folder of package://extperfc/; by default the folder above the URDF's

Example:
  extperfc-collision-matrix urdf/mobile_baxter.urdf --samples 100000 --keep config/robots/baxter/mobile_baxter.srdf
    --output config/robots/baxter/mobile_baxter.srdf

Exit status: 0 done, 1 failed (standard error says why), 2 wrong usage.
)";

int complain(const Error& error, int status) {
  std::cerr << "extperfc-collision-matrix: " << error.message << "\n";
  return status;
}

Result<CollisionMatrixParams> params_of(const Arguments& arguments) {
  CollisionMatrixParams params;
  const auto samples = arguments.number("--samples", 1, 1e7);
  if (!samples) return tl::unexpected(samples.error());
  const auto seed = arguments.number("--seed", 0, 1e15);
  if (!seed) return tl::unexpected(seed.error());
  const auto clearance = arguments.number("--clearance", 0, 1);
  if (!clearance) return tl::unexpected(clearance.error());
  if (*samples) params.samples = static_cast<int>(**samples);
  if (*seed) params.seed = static_cast<std::uint64_t>(**seed);
  params.clearance_m = clearance->value_or(params.clearance_m);
  return params;
}

Result<Srdf> make_srdf(const Arguments& arguments, const CollisionMatrixParams& params) {
  const std::filesystem::path urdf = arguments.operands().front();
  const std::filesystem::path above = std::filesystem::absolute(urdf).parent_path().parent_path();
  const auto robot = RobotModel::from_file(urdf, arguments.last("--resources").value_or(above.string()));
  if (!robot) return tl::unexpected(robot.error());
  Srdf srdf;
  if (const auto kept = arguments.last("--keep")) {
    auto read = read_srdf(*kept);
    if (!read) return read;
    srdf = std::move(*read);
  }
  srdf.robot = robot->name();
  auto disabled = find_disabled_pairs(*robot, params);
  if (!disabled) return tl::unexpected(disabled.error());
  srdf.disabled = std::move(*disabled);
  return srdf;
}

void print_counts(const Srdf& srdf, const CollisionMatrixParams& params) {
  std::map<std::string, int> counts;
  for (const auto& pair : srdf.disabled) ++counts[pair.reason];
  std::cerr << params.samples << " samples, seed " << params.seed << ":";
  for (const auto& [reason, count] : counts) std::cerr << " " << count << " " << reason;
  std::cerr << "\n";
}

int run(const std::vector<std::string>& tokens) {
  const auto arguments = Arguments::read(
      tokens,
      {1, 1, {"--output", "--keep", "--samples", "--seed", "--clearance", "--resources"}, {"--help"}});
  if (!arguments) return complain(arguments.error(), kUsage);
  if (arguments->has("--help")) {
    std::cout << kHelp;
    return kDone;
  }
  const auto params = params_of(*arguments);
  if (!params) return complain(params.error(), kUsage);
  const auto srdf = make_srdf(*arguments, *params);
  if (!srdf) return complain(srdf.error(), kFailed);
  print_counts(*srdf, *params);
  const auto output = arguments->last("--output");
  if (!output) {
    std::cout << to_xml(*srdf);
    return kDone;
  }
  if (const auto written = write_text_atomically(*output, to_xml(*srdf)); !written)
    return complain(written.error(), kFailed);
  return kDone;
}

}  // namespace
}  // namespace extperfc::arm

int main(int argc, char** argv) {
  try {
    return extperfc::arm::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::cerr << "extperfc-collision-matrix: " << error.what() << "\n";
    return 1;
  }
}
