#include "ros/params/cloud_to_scan_params.hpp"

#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

namespace {

constexpr double kFar = 1e6;      // "no limit" in configurations of pointcloud_to_laserscan
constexpr double kTurn = 6.2832;  // a little more than 2 pi: angles come from text

void read_limits(ParamReader& reader, scan::ScanParams& scan) {
  reader.read("min_height", scan.min_height, {-kFar, kFar});
  reader.read("max_height", scan.max_height, {-kFar, kFar});
  reader.read("angle_min", scan.angle_min, {-kTurn, kTurn});
  reader.read("angle_max", scan.angle_max, {-kTurn, kTurn});
  reader.read("angle_increment", scan.angle_increment, {1e-4, 1.0});
  reader.read("range_min", scan.range_min, {0.0, kFar});
  reader.read("range_max", scan.range_max, {0.0, kFar});
  reader.read("use_inf", scan.use_inf);
  reader.read("inf_epsilon", scan.inf_epsilon, {0.0, kFar});
}

void read_ground(ParamReader& reader, scan::GroundParams& ground) {
  std::string method = to_string(ground.method);
  int seed = static_cast<int>(ground.seed);
  reader.read("ground_method", method);
  reader.read("ground_z_m", ground.z_m, {-10.0, 10.0});
  reader.read("ground_clearance_m", ground.clearance_m, {0.0, 1.0});
  reader.read("ground_band_m", ground.band_m, {0.001, 2.0});
  reader.read("ground_max_slope_rad", ground.max_slope_rad, {0.001, 0.7});
  reader.read("ground_inlier_m", ground.inlier_m, {0.001, 0.5});
  reader.read("ground_max_iterations", ground.max_iterations, {1, 10000});
  reader.read("ground_min_points", ground.min_points, {3, 100000});
  reader.read("ground_seed", seed, {0, 2147483647});
  ground.seed = static_cast<std::uint32_t>(seed);
  if (const auto known = scan::ground_method_from_name(method))
    ground.method = *known;
  else
    reader.complain(known.error().message);
}

void read_intensity(ParamReader& reader, scan::ScanParams& scan) {
  std::string intensity = to_string(scan.intensity);
  reader.read("intensity", intensity);
  if (const auto known = scan::intensity_from_name(intensity))
    scan.intensity = *known;
  else
    reader.complain(known.error().message);
}

void read_rings(ParamReader& reader, scan::ScanParams& scan) {
  std::string rings;
  reader.read("rings", rings);
  if (rings.empty()) return;
  if (const auto chosen = scan::parse_rings(rings))
    scan.rings = *chosen;
  else
    reader.complain(chosen.error().message);
}

}  // namespace

Result<CloudToScanNodeletParams> load_cloud_to_scan_params(const ros::NodeHandle& private_handle) {
  CloudToScanNodeletParams params;
  ParamReader reader(private_handle);
  reader.read("target_frame", params.target_frame);
  reader.read("transform_tolerance", params.transform_tolerance, {0.0, 5.0});
  reader.read("scan_time", params.scan_time, {0.0, 60.0});
  reader.read("timeout_s", params.timeout_s, {0.1, 3600.0});
  read_limits(reader, params.scan);
  read_ground(reader, params.scan.ground);
  read_intensity(reader, params.scan);
  read_rings(reader, params.scan);
  if (const auto fits = scan::validate(params.scan); !fits) reader.complain(fits.error().message);
  if (auto finished = reader.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

}  // namespace extperfc::ros_params
