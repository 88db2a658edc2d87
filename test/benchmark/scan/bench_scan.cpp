// Time to flatten a lidar's sweep to a planar scan, against the plain loop. Run with --help.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <functional>
#include <iostream>
#include <limits>
#include <string>
#include <vector>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/base/running_stats.hpp"
#include "extperfc/scan/cloud_to_scan.hpp"

#include "test/benchmark/report.hpp"
#ifdef EXTPERFC_REAL_REVOLUTION
#include "test/unit/scan/real_revolution.hpp"
#endif

namespace extperfc::benchmark {
namespace {

using scan::CloudToScan;
using scan::CloudView;
using scan::GroundMethod;
using scan::NumberType;
using scan::ScanParams;

constexpr char kHelp[] =
    "bench_scan [--json FILE]\n"
    "Everything: deskewed with 5 poses, levelled, 24 volumes of a robot, slope or plane ground, two scans of "
    "900\n"
    "rays; on the sweep below and on a real VLP-16's revolution (22,591 returns of 28,800 beams), where MRPT "
    "and\n"
    "its recordings are installed.\n"
    "A sweep of 30,000 points in a room of 10 x 8 x 2.6 m, sensor 0.8 m above the floor, noise 1 cm.\n"
    "Peer: one loop over the points with hypot and atan2 in double precision, nearest point per ray; no "
    "deskewing,\n"
    "no ground, no robot, one scan. Both sides run in turns.\n";
constexpr double kSensorHeightM = 0.8;
constexpr double kCarRoofM = 2.07;  // of the recording's sensor
constexpr double kGoalMs = 3.0;
constexpr int kRepetitions = 400;

/// As a VLP-16's driver lays it out.
struct Point {
  float x, y, z, intensity;
  std::uint16_t ring, padding;
  float time;
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
      const auto time = static_cast<float>(0.1 * column / kColumns - 0.1);
      points.push_back({p.x(), p.y(), p.z(), 50, ring, 0, time});
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
  cloud.time = scan::TimeField{{offsetof(Point, time), NumberType::kFloat32}, 1.0, 0.0};
  return cloud;
}

/// The loop that one would write first; no floor, no intensity.
template <typename AnyPoint>
void plain_loop(const std::vector<AnyPoint>& points, const ScanParams& params, const Pose& target_T_cloud,
                std::vector<float>& ranges) {
  const double sector = params.angle_max - params.angle_min;
  ranges.assign(static_cast<std::size_t>(std::ceil(sector / params.angle_increment)),
                std::numeric_limits<float>::infinity());
  for (const AnyPoint& raw : points) {
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

/// Of this thread: other programs on the machine do not count.
double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// In turns: a machine whose speed changes meanwhile is as fast or slow for all of them.
std::vector<double> median_ms(const std::vector<std::function<void()>>& works) {
  std::vector<std::vector<double>> times(works.size());
  for (int i = 0; i < kRepetitions; ++i)
    for (std::size_t k = 0; k < works.size(); ++k) {
      const double start = cpu_ms();
      works[k]();
      times[k].push_back(cpu_ms() - start);
    }
  std::vector<double> medians;
  for (auto& of_one : times) medians.push_back(percentile(of_one, 0.5));
  return medians;
}

/// Two arms of twelve capsules each.
scan::SelfFilter robot() {
  std::vector<scan::SelfVolume> volumes;
  std::vector<std::optional<Pose>> poses;
  for (int i = 0; i < 24; ++i) {
    scan::SelfVolume volume;
    volume.frame = "link_" + std::to_string(i);
    volume.capsule = scan::Capsule{{0, 0, 0}, {0, 0, 0.1}, 0.08};
    volumes.push_back(volume);
    poses.emplace_back(make_pose({0.1 * (i % 12), i < 12 ? 0.5 : -0.5, 0.3}));
  }
  auto filter = scan::SelfFilter::make(volumes, 0.03).value();
  filter.place(poses);
  return filter;
}

/// Turns at 0.5 rad/s and drives at 0.5 m/s, on a floor from which it is tilted by 2 degrees.
scan::SensorTrack moving_track(double height_m) {
  scan::SensorTrack track;
  for (int i = 0; i < 5; ++i) {
    const double time_s = -0.1 + 0.025 * i;
    track.push_back({time_s, make_pose({0.5 * time_s, 0, height_m}, {0, 2 * kPi / 180, 0.5 * time_s})});
  }
  return track;
}

template <typename AnyPoint>
void add_everything(const std::string& name, const std::vector<AnyPoint>& points, const CloudView& cloud,
                    double height_m, std::vector<Row>& rows) {
  for (const auto method : {GroundMethod::kPlane, GroundMethod::kSlope}) {
    ScanParams params;
    params.angle_increment = 2 * kPi / 900;
    params.min_height = -1;
    params.max_height = 3;
    params.ground.method = method;
    params.ground.max_slope_rad = 0.2;
    auto converter = CloudToScan::make(params);
    const auto filter = robot();
    const auto track = moving_track(height_m);
    scan::PlanarScans scans;
    std::vector<float> ranges;
    const auto times = median_ms({[&] {
                                    (void)scan::time_span(cloud, scan::AzimuthTimes::kNone, 0.1);
                                    (void)converter->convert(cloud, track, filter, scans);
                                  },
                                  [&] { plain_loop(points, params, track.back().target_T_sensor, ranges); }});
    rows.push_back(at_most({name + ", everything, ground: " + to_string(method), "CPU time per sweep, median",
                            "ms", times[0], times[1], "plain loop"},
                           kGoalMs));
  }
}

std::vector<Row> run_all() {
  const auto points = sweep();
  const auto cloud = view_of(points);
  const Pose target_T_cloud = make_pose({0, 0, kSensorHeightM});
  std::vector<Row> rows;
  for (const auto method :
       {GroundMethod::kNone, GroundMethod::kHeight, GroundMethod::kPlane, GroundMethod::kSlope}) {
    ScanParams params;
    params.min_height = -1;  // every point but the floor's counts
    params.max_height = 3;
    params.ground.method = method;
    std::vector<float> ranges;
    auto converter = CloudToScan::make(params);
    scan::PlanarScans scans;
    const scan::SensorTrack track{{0, target_T_cloud}};
    const auto times = median_ms({[&] { (void)converter->convert(cloud, track, {}, scans); },
                                  [&] { plain_loop(points, params, target_T_cloud, ranges); }});
    Row row{std::string("ground: ") + to_string(method),
            "CPU time per sweep, median",
            "ms",
            times[0],
            times[1],
            "plain loop"};
    rows.push_back(at_most(row, kGoalMs));
  }
  add_everything("full sweep", points, cloud, kSensorHeightM, rows);
#ifdef EXTPERFC_REAL_REVOLUTION
  std::string why;
  const auto real = scan::read_real_revolution(why);
  const auto returns = scan::returns_of(real);
  if (returns.empty())
    std::cerr << "no real revolution: " << why << "\n";
  else
    add_everything("real revolution", returns, scan::view_of(returns), kCarRoofM, rows);
#endif
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
