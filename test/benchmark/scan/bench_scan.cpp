// Time to flatten a lidar's sweep to a planar scan, against the plain loop. Run with --help.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <limits>
#include <string>
#include <vector>

#include "extperfc/base/rng.hpp"
#include "extperfc/base/running_stats.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/scan/cloud_to_scan.hpp"

#include "report.hpp"

namespace extperfc::benchmark {
namespace {

using scan::CloudToScan;
using scan::CloudView;
using scan::GroundMethod;
using scan::NumberType;
using scan::ScanParams;

constexpr char kHelp[] =
    "bench_scan [--json FILE]\n"
    "A sweep of 30,000 points in a room of 10 x 8 x 2.6 m, sensor 0.8 m above the floor, noise 1 cm.\n"
    "Peer: one loop over the points with hypot and atan2 in double precision, nearest point per ray.\n";

constexpr double kPi = 3.14159265358979323846;
constexpr double kSensorHeightM = 0.8;
constexpr double kGoalMs = 1.5;  // without a plane
constexpr int kRepetitions = 400;

/// As a VLP-16's driver lays it out.
struct Point {
  float x, y, z, intensity;
  std::uint16_t ring, padding;
};

/// Distance to the walls of the room along a direction from the sensor.
double cast(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d high(5, 4, 2.6 - kSensorHeightM);
  const Eigen::Vector3d low(-5, -4, -kSensorHeightM);
  double nearest = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double limit = direction[axis] > 0 ? high[axis] : low[axis];
    if (direction[axis] != 0) nearest = std::min(nearest, limit / direction[axis]);
  }
  return nearest;
}

std::vector<Point> sweep() {
  constexpr int kColumns = 1875;
  Rng rng(1);
  std::vector<Point> points;
  for (int column = 0; column < kColumns; ++column)
    for (std::uint16_t ring = 0; ring < 16; ++ring) {
      const double azimuth = column * 2 * kPi / kColumns;
      const double elevation = (-15 + 2 * ring) * kPi / 180;
      const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                      std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const Eigen::Vector3f p = ((cast(direction) + rng.normal(0, 0.01)) * direction).cast<float>();
      points.push_back({p.x(), p.y(), p.z(), 50, ring, 0});
    }
  return points;
}

CloudView view_of(const std::vector<Point>& points) {
  CloudView cloud;
  cloud.data = reinterpret_cast<const std::uint8_t*>(points.data());
  cloud.bytes = points.size() * sizeof(Point);
  cloud.width = points.size();
  cloud.height = 1;
  cloud.point_step = sizeof(Point);
  cloud.row_step = cloud.bytes;
  cloud.x = {offsetof(Point, x), NumberType::kFloat32};
  cloud.y = {offsetof(Point, y), NumberType::kFloat32};
  cloud.z = {offsetof(Point, z), NumberType::kFloat32};
  cloud.intensity = scan::CloudField{offsetof(Point, intensity), NumberType::kFloat32};
  cloud.ring = scan::CloudField{offsetof(Point, ring), NumberType::kUint16};
  return cloud;
}

/// The loop that one would write first; no floor, no intensity.
void plain_loop(const std::vector<Point>& points, const ScanParams& params, const Pose& target_T_cloud,
                std::vector<float>& ranges) {
  const double turn = params.angle_max - params.angle_min;
  ranges.assign(static_cast<std::size_t>(std::ceil(turn / params.angle_increment)),
                std::numeric_limits<float>::infinity());
  for (const Point& raw : points) {
    const Eigen::Vector3d p = target_T_cloud * Eigen::Vector3d(raw.x, raw.y, raw.z);
    if (!p.allFinite() || p.z() < params.min_height || p.z() > params.max_height) continue;
    const double range = std::hypot(p.x(), p.y());
    if (range < params.range_min || range > params.range_max) continue;
    const double angle = std::atan2(p.y(), p.x());
    if (angle < params.angle_min || angle >= params.angle_max) continue;
    float& nearest = ranges[static_cast<std::size_t>((angle - params.angle_min) / params.angle_increment)];
    nearest = std::min(nearest, static_cast<float>(range));
  }
}

template <typename Work>
double median_ms(Work work) {
  std::vector<double> times;
  for (int i = 0; i < kRepetitions; ++i) {
    const Stopwatch watch;
    work();
    times.push_back(watch.milliseconds());
  }
  return percentile(times, 0.5);
}

std::vector<Row> run_all() {
  const auto points = sweep();
  const auto cloud = view_of(points);
  const Pose target_T_cloud = make_pose({0, 0, kSensorHeightM});
  std::vector<Row> rows;
  for (const auto method : {GroundMethod::kNone, GroundMethod::kHeight, GroundMethod::kPlane}) {
    ScanParams params;
    params.min_height = -1;  // every point but the floor's counts
    params.max_height = 3;
    params.ground.method = method;
    std::vector<float> ranges;
    const double peer = median_ms([&] { plain_loop(points, params, target_T_cloud, ranges); });
    auto converter = CloudToScan::make(params);
    scan::PlanarScan scan;
    const double ours = median_ms([&] { (void)converter->convert(cloud, target_T_cloud, scan); });
    Row row{std::string("ground: ") + to_string(method),
            "time per sweep, median",
            "ms",
            ours,
            peer,
            "plain loop"};
    rows.push_back(method == GroundMethod::kPlane ? row : at_most(row, kGoalMs));
  }
  return rows;
}

}  // namespace
}  // namespace extperfc::benchmark

int main(int argc, char** argv) {
  using namespace extperfc::benchmark;  // NOLINT
  std::string json;
  if (argc == 3 && std::strcmp(argv[1], "--json") == 0) {
    json = argv[2];
  } else if (argc != 1) {
    std::fputs(kHelp, argc == 2 && std::strcmp(argv[1], "--help") == 0 ? stdout : stderr);
    return argc == 2 && std::strcmp(argv[1], "--help") == 0 ? EXIT_SUCCESS : 2;
  }
  const auto rows = run_all();
  std::cout << machine_description() << "\n\n";
  print_table(std::cout, rows);
  if (!json.empty() && !write_json(json, "scan", rows)) {
    std::cerr << "cannot write " << json << "\n";
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
