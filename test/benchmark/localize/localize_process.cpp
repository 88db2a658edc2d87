// A process that only localizes: `bench_localize_process MAP.yaml LOG.clf`. Prints its peak memory
// in MiB.

#include <cstdio>
#include <memory>

#include <sys/resource.h>

#include "extperfc/localize/localizer.hpp"
#include "extperfc/sources/scan_log.hpp"
#include "extperfc/world/map_file.hpp"

namespace {

int complain(const extperfc::Error& error) {
  std::fprintf(stderr, "bench_localize_process: %s\n", error.message.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace extperfc;  // NOLINT
  if (argc != 3) return 2;
  auto map = load_map(argv[1]);
  if (!map) return complain(map.error());
  localize::LocalizerParams params;
  params.min_particles = 500;
  params.max_particles = 10000;
  auto localizer = localize::Localizer::make(params, std::make_shared<OccupancyGrid>(std::move(*map)));
  if (!localizer) return complain(localizer.error());
  const auto log = sources::open_carmen_log(argv[2]);
  if (!log) return complain(log.error());
  constexpr int kScans = 3000;
  for (int i = 0; i < kScans; ++i) {
    const auto record = (*log)->next();
    if (!record) return complain(record.error());
    if (!*record) break;
    const auto updated = localizer->update((*record)->scan, (*record)->odom_T_base.value_or(Pose2{}));
    if (!updated) return complain(updated.error());
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("%.1f\n", static_cast<double>(usage.ru_maxrss) / 1024);
  return 0;
}
