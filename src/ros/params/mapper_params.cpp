#include "ros/params/mapper_params.hpp"

#include <map>
#include <string_view>
#include <variant>
#include <vector>

#include "extperfc/mapping/param_names.hpp"

#include "ros/params/list_reader.hpp"
#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

namespace {

constexpr double kFarM = 1000.0;
constexpr double kLongS = 3600.0;
constexpr double kMaxScore = 1e6;

/// Parameters of GMapping's matcher and of its map of fixed size.
constexpr const char* kWithoutEffect[] = {
    "sigma",         "kernelSize",   "lstep",         "astep",        "iterations",    "lsigma",
    "ogain",         "lskip",        "xmin",          "ymin",         "xmax",          "ymax",
    "llsamplerange", "llsamplestep", "lasamplerange", "lasamplestep", "inverted_laser"};

void read_frames(ParamReader& reader, MapperNodeletParams& params) {
  reader.read_frame("base_frame", params.base_frame);
  reader.read_frame("odom_frame", params.odom_frame);
  reader.read_frame("map_frame", params.map_frame);
  if (params.base_frame == params.map_frame || params.odom_frame == params.map_frame ||
      params.odom_frame == params.base_frame)
    reader.complain("base_frame, odom_frame and map_frame must be three different frames");
}

void read_inputs(ParamReader& reader, const ros::NodeHandle& handle, MapperNodeletParams& params) {
  read_named(reader, handle, "odometry", params.odometry,
             {{"auto", OdometrySource::kAuto}, {"tf", OdometrySource::kTf}, {"none", OdometrySource::kNone}});
  reader.read("use_imu", params.use_imu);
  reader.read("multi_echo", params.multi_echo);
  reader.read("throttle_scans", params.throttle_scans, {1, 1000});
  reader.read("queue_size", params.queue_size, {1, 1000});
  reader.read("transform_timeout_s", params.transform_timeout_s, {0.0, 60.0});
  reader.read("max_tilt_rad", params.max_tilt_rad, {0.0, 0.8});
  reader.read("odometry_max_speed_m_s", params.odometry_max_speed_m_s, {0.1, 100.0});
  reader.read("odometry_max_yaw_rate_rad_s", params.odometry_max_yaw_rate_rad_s, {0.1, 100.0});
  reader.read("timeout_s", params.timeout_s, {0.1, kLongS});
  reader.read("session", params.session);
  reader.read("localization", params.localization);
  if (params.localization && params.session.empty())
    reader.complain("localization needs a session, the file of ~save_map, whose map it localizes in");
}

void read_outputs(ParamReader& reader, MapperNodeletParams& params) {
  reader.read("map_update_interval", params.map_update_interval, {0.0, kLongS});
  reader.read("trajectory_interval_s", params.trajectory_interval_s, {0.05, kLongS});
  reader.read("transform_publish_period", params.transform_publish_period, {0.0, 60.0});
  params.tf_delay = params.transform_publish_period;
  reader.read("tf_delay", params.tf_delay, {0.0, 60.0});
  reader.read("diagnostic_period", params.diagnostic_period, {0.01, 60.0});
}

/// Of the mapper's own parameters; the rest are probabilities. In step with validate(MapperParams).
Range<double> range_of(std::string_view name) {
  static const std::map<std::string_view, Range<double>> kRanges = {{"particles", {1, 1000}},
                                                                    {"delta", {0.01, 1}},
                                                                    {"maxRange", {0, kFarM}},
                                                                    {"maxUrange", {0, kFarM}},
                                                                    {"linearUpdate", {0.05, 5}},
                                                                    {"angularUpdate", {0.02, 3.2}},
                                                                    {"temporalUpdate", {-kLongS, kLongS}},
                                                                    {"srr", {0, 10}},
                                                                    {"srt", {0, 10}},
                                                                    {"str", {0, 10}},
                                                                    {"stt", {0, 10}},
                                                                    {"occ_thresh", {0.01, 0.99}},
                                                                    {"minimumScore", {0, kMaxScore}},
                                                                    {"keptPasses", {0, 100}},
                                                                    {"seed", {0, 2147483647}}};
  const auto found = kRanges.find(name);
  return found == kRanges.end() ? Range<double>{0, 1} : found->second;
}

void read_field(ParamReader& reader, const mapping::ParamName& name, mapping::MapperParams& mapper,
                double mapping::MapperParams::*field) {
  reader.read(std::string(name.name), mapper.*field, range_of(name.name));
}

template <typename Whole>
void read_field(ParamReader& reader, const mapping::ParamName& name, mapping::MapperParams& mapper,
                Whole mapping::MapperParams::*field) {
  const auto range = range_of(name.name);
  int value = static_cast<int>(mapper.*field);
  reader.read(std::string(name.name), value, {static_cast<int>(range.low), static_cast<int>(range.high)});
  mapper.*field = static_cast<Whole>(value);
}

void read_mapper(ParamReader& reader, mapping::MapperParams& mapper) {
  for (const auto& name : mapping::param_names())
    std::visit([&](auto field) { read_field(reader, name, mapper, field); }, name.field);
}

/// GMapping's minimumScore is a sum over the rays, e.g. 50, and cannot be converted to a fraction. Replaces
/// values above 1 by the default and returns false.
bool mend_minimum_score(mapping::MapperParams& mapper) {
  if (mapper.minimum_score <= 1.0) return true;
  mapper.minimum_score = mapping::MapperParams().minimum_score;
  return false;
}

std::string notice_about(const std::vector<std::string>& names, bool score_is_a_fraction,
                         double default_score) {
  std::string notice;
  for (const auto& name : names) notice += (notice.empty() ? "" : ", ") + name;
  if (!notice.empty()) notice = "parameters of GMapping that have no meaning here and no effect: " + notice;
  if (!score_is_a_fraction)
    notice += concatenated(
        {notice.empty() ? "" : "; ",
         "minimumScore is the fraction of a scan that must fit, [0, 1]: the value above 1 is replaced by ",
         std::to_string(default_score).substr(0, 4)});
  return notice;
}

}  // namespace

Result<MapperNodeletParams> load_mapper_params(const ros::NodeHandle& private_handle) {
  MapperNodeletParams params;
  ParamReader reader(private_handle);
  read_frames(reader, params);
  read_inputs(reader, private_handle, params);
  read_outputs(reader, params);
  read_mapper(reader, params.mapper);
  const bool is_fraction = mend_minimum_score(params.mapper);
  std::vector<std::string> idle;
  for (const auto* name : kWithoutEffect) {
    reader.accept(name);
    if (private_handle.hasParam(name)) idle.emplace_back(name);
  }
  params.notice = notice_about(idle, is_fraction, params.mapper.minimum_score);
  if (const auto fits = mapping::validate(params.mapper); !fits) reader.complain(fits.error().message);
  if (auto finished = reader.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

}  // namespace extperfc::ros_params
