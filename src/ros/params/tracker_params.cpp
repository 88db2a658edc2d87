#include "ros/params/tracker_params.hpp"

#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

Result<TrackerNodeletParams> load_tracker_params(const ros::NodeHandle& private_handle) {
  TrackerNodeletParams params;
  auto& tracker = params.tracker;
  ParamReader reader(private_handle);
  reader.read("fixed_frame", params.fixed_frame);
  reader.read("acceleration_m_s2", tracker.acceleration_m_s2, {0.001, 100.0});
  reader.read("speed_m_s", tracker.speed_m_s, {0.001, 100.0});
  reader.read("min_sigma_m", tracker.min_sigma_m, {0.0001, 1.0});
  reader.read("gate", tracker.gate, {0.1, 1000.0});
  reader.read("class_cost", tracker.class_cost, {0.0, 1000.0});
  reader.read("confirm_hits", tracker.confirm_hits, {1, 1000});
  reader.read("max_missed_s", tracker.max_missed_s, {0.01, 3600.0});
  reader.read("max_missed_new_s", tracker.max_missed_new_s, {0.01, 3600.0});
  reader.read("max_tracks", tracker.max_tracks, {1, 1000});
  reader.read("manoeuvre_m_s", tracker.manoeuvre_m_s, {0.0, 100.0});
  reader.read("publish_tentative", params.publish_tentative);
  reader.read("transform_timeout_s", params.transform_timeout_s, {0.0, 5.0});
  reader.read("timeout_s", params.timeout_s, {0.1, 3600.0});
  if (auto valid = track::validate(tracker); !valid) reader.complain(valid.error().message);
  if (auto finished = reader.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

}  // namespace extperfc::ros_params
