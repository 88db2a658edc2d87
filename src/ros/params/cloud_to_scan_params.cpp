#include "ros/params/cloud_to_scan_params.hpp"

#include <sstream>

#include "ros/params/list_reader.hpp"
#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

namespace {

constexpr double kFar = 1e6;           // "no limit" in configurations of pointcloud_to_laserscan
constexpr double kFullAngle = 6.2832;  // a little more than 2 pi: angles come from text

const NamedValues<LevelFrom> kLevels{
    {"none", LevelFrom::kNone}, {"tf", LevelFrom::kTf}, {"imu", LevelFrom::kImu}};

void read_limits(ParamReader& reader, scan::ScanParams& scan) {
  reader.read("min_height", scan.min_height, {-kFar, kFar});
  reader.read("max_height", scan.max_height, {-kFar, kFar});
  reader.read("angle_min", scan.angle_min, {-kFullAngle, kFullAngle});
  reader.read("angle_max", scan.angle_max, {-kFullAngle, kFullAngle});
  reader.read("angle_increment", scan.angle_increment, {1e-4, 1.0});
  reader.read("range_min", scan.range_min, {0.0, kFar});
  reader.read("range_max", scan.range_max, {0.0, kFar});
  reader.read("use_inf", scan.use_inf);
  reader.read("inf_epsilon", scan.inf_epsilon, {0.0, kFar});
  reader.read("no_return_range", scan.no_return_range, {0.0, kFar});
  reader.read("support_m", scan.support_m, {0.001, 2.0});
  reader.read("range_noise_m", scan.range_noise_m, {0.0, 0.1});
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

void read_times(ParamReader& reader, scan::ScanParams& scan) {
  std::string times = to_string(scan.azimuth_times);
  reader.read("azimuth_times", times);
  reader.read("scan_time", scan.scan_time, {0.0, 60.0});
  if (const auto known = scan::azimuth_times_from_name(times))
    scan.azimuth_times = *known;
  else
    reader.complain(known.error().message);
}

/// Three numbers in a text, as in a URDF: "0.1 0 -0.2".
Result<Eigen::Vector3d> vector_in(const std::string& text) {
  std::istringstream stream(text);
  Eigen::Vector3d v;
  std::string rest;
  if (stream >> v.x() >> v.y() >> v.z() && v.allFinite() && !(stream >> rest)) return v;
  return fail(ErrorCode::kInvalidArgument, "'" + text + "' is not three numbers, e.g. \"0.1 0 -0.2\"");
}

Result<void> set_vector(const Entry& entry, Eigen::Vector3d& value) {
  const auto given = vector_in(entry.text());
  if (!given) return tl::unexpected(given.error());
  value = *given;
  return {};
}

scan::Capsule& capsule_of(scan::SelfVolume& volume) {
  if (!volume.capsule) volume.capsule.emplace();
  return *volume.capsule;
}

scan::Cuboid& box_of(scan::SelfVolume& volume) {
  if (!volume.box) volume.box.emplace();
  return *volume.box;
}

Result<void> set_volume(scan::SelfVolume& volume, const std::string& key, const Entry& entry) {
  if (key == "frame") {
    volume.frame = entry.text();
    return {};
  }
  if (key == "from") return set_vector(entry, capsule_of(volume).from);
  if (key == "to") return set_vector(entry, capsule_of(volume).to);
  if (key == "size") return set_vector(entry, box_of(volume).size);
  if (key == "radius") {
    const auto radius = entry.number({0.001, 5.0});
    if (!radius) return tl::unexpected(radius.error());
    capsule_of(volume).radius_m = *radius;
    return {};
  }
  Eigen::Vector3d v;
  if (key != "xyz" && key != "rpy")
    return fail(ErrorCode::kInvalidArgument,
                "unknown key; a capsule has frame, from, to, radius, a box has frame, size, xyz, rpy");
  if (auto set = set_vector(entry, v); !set) return set;
  Pose& pose = box_of(volume).frame_T_box;
  if (key == "xyz")
    pose.translation() = v;
  else
    pose.linear() = make_pose(Eigen::Vector3d::Zero(), v).linear();
  return {};
}

void read_self(ParamReader& reader, const ros::NodeHandle& handle, CloudToScanNodeletParams& params) {
  params.self_volumes = read_list<scan::SelfVolume>(reader, handle, "self_volumes", set_volume);
  reader.read("self_padding", params.self_padding, {0.0, 1.0});
  if (const auto made = scan::SelfFilter::make(params.self_volumes, params.self_padding); !made)
    reader.complain(made.error().message);
}

}  // namespace

const char* to_string(LevelFrom level) {
  for (const auto& [name, meaning] : kLevels)
    if (meaning == level) return name.c_str();
  return "?";
}

Result<CloudToScanNodeletParams> load_cloud_to_scan_params(const ros::NodeHandle& private_handle) {
  CloudToScanNodeletParams params;
  ParamReader reader(private_handle);
  reader.read("target_frame", params.target_frame);
  reader.read("transform_tolerance", params.transform_tolerance, {0.0, 5.0});
  reader.read("fixed_frame", params.fixed_frame);
  reader.read("deskew", params.deskew);
  read_named(reader, private_handle, "level", params.level, kLevels);
  reader.read("timeout_s", params.timeout_s, {0.1, 3600.0});
  read_limits(reader, params.scan);
  read_ground(reader, params.scan.ground);
  read_intensity(reader, params.scan);
  read_rings(reader, params.scan);
  read_times(reader, params.scan);
  read_self(reader, private_handle, params);
  if (const auto fits = scan::validate(params.scan); !fits) reader.complain(fits.error().message);
  if (auto finished = reader.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

}  // namespace extperfc::ros_params
