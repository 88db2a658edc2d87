// Maps a recording of planar scans:  03_map_log LOG [MAP]   (LOG: a CARMEN log, plain or packed)
#include "extperfc/mapping/mapper.hpp"
#include "extperfc/sources/scan_log.hpp"
#include "extperfc/world/map_file.hpp"

#include "examples/example.hpp"

using namespace extperfc;

int main(int argc, char** argv) {
  if (argc < 2) return std::cerr << "usage: 03_map_log LOG [MAP]\n", 2;
  const auto log = examples::value_of(sources::open_carmen_log(argv[1]));
  mapping::MapperParams params;
  params.particles = 30;
  auto mapper = examples::value_of(mapping::Mapper::make(params));

  while (const auto record = examples::value_of(log->next())) {
    const auto update = mapper.add(record->scan, record->odom_T_base);
    if (!update) std::cerr << "scan left out: " << update.error().message << "\n";
  }
  mapper.finish();  // final optimization and full redraw of the map

  const auto statistics = mapper.statistics();
  std::cout << statistics.scans << " scans, " << statistics.key_frames << " key frames, " << statistics.loops
            << " loops closed, " << statistics.path_m << " m\n";
  if (argc > 2) examples::check(save_map(*mapper.map(), argv[2]));  // MAP.pgm and MAP.yaml
}
