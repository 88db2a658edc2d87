// Localizes the robot of a recording in a map:  04_localize MAP.yaml LOG
#include <memory>

#include "extperfc/localize/localizer.hpp"
#include "extperfc/sources/scan_log.hpp"
#include "extperfc/world/map_file.hpp"

#include "examples/example.hpp"

using namespace extperfc;

int main(int argc, char** argv) {
  if (argc < 3) return std::cerr << "usage: 04_localize MAP.yaml LOG\n", 2;
  const auto map = std::make_shared<const OccupancyGrid>(examples::value_of(load_map(argv[1])));
  const auto log = examples::value_of(sources::open_carmen_log(argv[2]));

  localize::LocalizerParams params;  // names and meaning as in amcl
  auto localizer = examples::value_of(localize::Localizer::make(params, map));
  // Without this the localizer searches the whole map.
  examples::check(localizer.set_pose({}, Eigen::Vector3d(0.25, 0.25, 0.07).asDiagonal().toDenseMatrix()));

  int updates = 0;
  while (const auto record = examples::value_of(log->next())) {
    if (!record->odom_T_base) continue;
    const auto estimate = examples::value_of(localizer.update(record->scan, *record->odom_T_base));
    if (estimate) ++updates;  // no value: the robot has not moved enough
  }
  const auto& last = localizer.estimate();
  std::cout << updates << " updates; at the end x " << last.pose.x << " m, y " << last.pose.y << " m, yaw "
            << last.pose.yaw << " rad, " << 100 * last.fit << " % of the scan fit the map\n";
}
