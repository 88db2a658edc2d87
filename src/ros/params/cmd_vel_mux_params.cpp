#include "ros/params/cmd_vel_mux_params.hpp"

#include "ros/params/list_reader.hpp"

namespace extperfc::ros_params {

namespace {

Result<void> set_source(MuxSourceParams& source, const std::string& key, const Entry& entry) {
  if (key == "name") {
    source.source.name = entry.text();
  } else if (key == "topic") {
    source.topic = entry.text();
  } else if (key == "priority" || key == "timeout_s") {
    const auto number = entry.number(key == "priority" ? Range<double>{-1e6, 1e6} : Range<double>{0.01, 60});
    if (!number) return tl::unexpected(number.error());
    if (key == "priority")
      source.source.priority = static_cast<int>(*number);
    else
      source.source.timeout_s = *number;
  } else {
    return fail(ErrorCode::kInvalidArgument, "unknown; name, topic, priority and timeout_s are known");
  }
  return {};
}

}  // namespace

Result<CmdVelMuxParams> load_cmd_vel_mux_params(const ros::NodeHandle& private_handle) {
  CmdVelMuxParams params;
  ParamReader reader(private_handle);
  params.sources = read_list<MuxSourceParams>(reader, private_handle, "sources", set_source);
  reader.read("max_vel_x", params.limits.max_vx_m_s, {0.001, 20.0});
  reader.read("min_vel_x", params.limits.min_vx_m_s, {-20.0, 0.0});
  reader.read("max_vel_y", params.limits.max_vy_m_s, {0.0, 20.0});
  reader.read("max_vel_theta", params.limits.max_wz_rad_s, {0.001, 20.0});
  reader.read("stop_topic", params.stop_topic);
  reader.read("rate_hz", params.rate_hz, {1.0, 200.0});
  std::vector<navigate::VelocitySource> sources;
  sources.reserve(params.sources.size());
  for (const auto& source : params.sources) {
    sources.push_back(source.source);
    if (source.topic.empty()) reader.complain("sources: '" + source.source.name + "' has no topic");
  }
  if (const auto made = navigate::VelocityMux::make(sources, params.limits); !made)
    reader.complain("sources: " + made.error().message);
  if (auto finished = reader.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

}  // namespace extperfc::ros_params
