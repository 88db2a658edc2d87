#include "ros/params/navigator_params.hpp"

#include <ros/package.h>

namespace extperfc::ros_params {

namespace {

using navigate::BaseKind;

/// Parameters of move_base, costmap_2d and its planners without effect here.
constexpr const char* kWithoutMeaning[] = {"clearing_rotation_allowed",
                                           "shutdown_costmaps",
                                           "max_planning_retries",
                                           "recovery_behaviors",
                                           "restore_defaults",
                                           "make_plan_clear_costmap",
                                           "make_plan_add_unreachable_goal",
                                           "NavfnROS",
                                           "GlobalPlanner",
                                           "DWAPlannerROS",
                                           "TrajectoryPlannerROS",
                                           "TebLocalPlannerROS",
                                           "global_costmap",
                                           "local_costmap",
                                           "conservative_reset",
                                           "aggressive_reset"};

void read_frames(ParamReader& reader, NavigatorNodeParams& params) {
  reader.read_frame("global_frame", params.global_frame);
  reader.read_frame("odom_frame", params.odom_frame);
  reader.read_frame("robot_base_frame", params.base_frame);
  if (params.base_frame == params.odom_frame || params.odom_frame == params.global_frame ||
      params.base_frame == params.global_frame)
    reader.complain("global_frame, odom_frame and robot_base_frame must be three different frames, but are " +
                    params.global_frame + ", " + params.odom_frame + ", " + params.base_frame);
}

void read_limits(ParamReader& reader, navigate::VelocityLimits& limits) {
  reader.read("max_vel_x", limits.max_vx_m_s, {0.001, 20.0});
  reader.read("min_vel_x", limits.min_vx_m_s, {-20.0, 0.0});
  reader.read("max_vel_y", limits.max_vy_m_s, {0.0, 20.0});
  reader.read("max_vel_theta", limits.max_wz_rad_s, {0.001, 20.0});
  reader.read("acc_lim_x", limits.acc_x_m_s2, {0.001, 100.0});
  reader.read("acc_lim_y", limits.acc_y_m_s2, {0.001, 100.0});
  reader.read("acc_lim_theta", limits.acc_wz_rad_s2, {0.001, 100.0});
}

void read_behaviour(ParamReader& reader, NavigatorNodeParams& params) {
  auto& navigator = params.navigator;
  reader.read("controller_frequency", params.controller_frequency_hz, {1.0, 200.0});
  reader.read("planner_frequency", navigator.planner_frequency_hz, {0.0, 100.0});
  reader.read("planner_patience", navigator.planner_patience_s, {0.0, 3600.0});
  reader.read("people_patience", navigator.people_patience_s, {0.0, 3600.0});
  reader.read("controller_patience", navigator.controller_patience_s, {0.0, 3600.0});
  reader.read("oscillation_timeout", navigator.oscillation_timeout_s, {0.0, 3600.0});
  reader.read("oscillation_distance", navigator.oscillation_distance_m, {0.001, 100.0});
  reader.read("recovery_behavior_enabled", navigator.recovery_enabled);
  reader.read("data_patience_s", navigator.data_patience_s, {0.0, 3600.0});
  reader.read("blocked_ahead_m", navigator.blocked_ahead_m, {0.0, 100.0});
  reader.read("blocked_margin_m", navigator.blocked_margin_m, {0.0, 1.0});
  reader.read("path_deviation_m", navigator.deviation_m, {0.001, 100.0});
  reader.read("shorter_ratio", navigator.shorter_ratio, {0.001, 1.0});
  reader.read("detour_memory", navigator.detour_memory_s, {0.0, 3600.0});
  reader.read("xy_goal_tolerance", navigator.goal.xy_m, {0.001, 10.0});
  reader.read("yaw_goal_tolerance", navigator.goal.yaw_rad, {0.001, 3.15});
  auto& recovery = navigator.recovery;
  reader.read("wait_s", recovery.wait_s, {0.0, 600.0});
  reader.read("back_off_m", recovery.back_off_m, {0.0, 5.0});
  reader.read("back_off_m_s", recovery.back_off_m_s, {0.001, 1.0});
  reader.read("rotate_rad", recovery.rotate_rad, {0.0, 6.3});
  reader.read("rotate_rad_s", recovery.rotate_rad_s, {0.001, 3.0});
  reader.read("conservative_reset_dist", recovery.clear_beyond_m, {0.0, 100.0});
  reader.read("avoid_ahead_m", recovery.avoid_ahead_m, {0.0, 10.0});
  reader.read("avoid_radius_m", recovery.avoid_radius_m, {0.001, 10.0});
  reader.read("avoid_person_m", recovery.avoid_person_m, {0.001, 10.0});
  reader.read("max_recoveries", recovery.max_attempts, {1, 1000});
}

void read_planners(ParamReader& reader, NavigatorNodeParams& params) {
  reader.read("base_global_planner", params.base_global_planner);
  reader.read("base_local_planner", params.base_local_planner);
  auto& global = params.global;
  reader.read("allow_unknown", global.allow_unknown);
  reader.read("neutral_cost", global.neutral_cost, {1.0, 252.0});
  reader.read("cost_factor", global.cost_factor, {0.0, 100.0});
  reader.read("default_tolerance", global.default_tolerance_m, {0.0, 10.0});
  reader.read("planning_time_s", global.max_time_s, {0.01, 600.0});
  reader.read("heading_weight", global.heading_weight, {0.0, 1.0});
  params.navigator.tolerance_m = global.default_tolerance_m;
  auto& local = params.local;
  reader.read("samples", local.samples, {10, 10000});
  reader.read("sim_time", local.horizon_s, {0.5, 10.0});
  reader.read("sim_step_s", local.step_s, {0.02, 0.5});
  reader.read("temperature", local.temperature, {1e-4, 1000.0});
  reader.read("path_distance_bias", local.path_weight, {0.0, 1e4});
  reader.read("path_heading_bias", local.heading_weight, {0.0, 1e4});
  reader.read("goal_distance_bias", local.progress_weight, {0.0, 1e4});
  reader.read("occdist_scale", local.obstacle_weight, {0.0, 1e4});
  reader.read("people_scale", local.people_weight, {0.0, 1e4});
  reader.read("smooth_scale", local.smooth_weight, {0.0, 1e4});
}

void read_costs(ParamReader& reader, CostMapParams& costs) {
  reader.read("resolution", costs.resolution_m, {0.01, 1.0});
  reader.read("local_size_m", costs.local_size_m, {1.0, 100.0});
  reader.read("inflation_radius", costs.inflation_radius_m, {0.0, 10.0});
  reader.read("cost_scaling_factor", costs.cost_scaling_factor, {0.0, 100.0});
  reader.read("obstacle_range", costs.obstacle_range_m, {0.1, 100.0});
  reader.read("raytrace_range", costs.raytrace_range_m, {0.1, 100.0});
  reader.read("observation_persistence", costs.decay_s, {0.0, 3600.0});
  reader.read("min_obstacle_height", costs.min_obstacle_height_m, {-10.0, 100.0});
  reader.read("max_obstacle_height", costs.max_obstacle_height_m, {-10.0, 100.0});
  reader.read("map_margin_m", costs.map_margin_m, {0.0, 2.0});
  reader.read("lidar_frame", costs.lidar_frame);
  reader.read("lidar_half_fov", costs.lidar_half_fov_rad, {0.0, 1.5});
  reader.read("track_unknown_space", costs.track_unknown);
  reader.read("publish_frequency", costs.publish_hz, {0.0, 50.0});
  reader.read("zones_file", costs.zones_file);
}

void read_data(ParamReader& reader, NavigatorNodeParams& params) {
  reader.read("odom_timeout_s", params.limits.odom_s, {0.02, 60.0});
  reader.read("scan_timeout_s", params.limits.scan_s, {0.05, 60.0});
  reader.read("transform_tolerance", params.limits.transform_s, {0.05, 60.0});
  reader.read("max_position_sigma_m", params.limits.position_sigma_m, {0.01, 1e6});
  reader.read("arm_outline", params.arms.enabled);
  reader.read("arm_max_height_m", params.arms.max_height_m, {0.0, 10.0});
  reader.read("track_people", params.people.enabled);
  reader.read("people_range_m", params.people.max_range_m, {0.5, 100.0});
  reader.read("people_stand_s", params.people.stand_s, {0.0, 3600.0});
  reader.read("guard_time_s", params.guard.min_time_s, {0.01, 2.0});
  reader.read("guard_margin_m", params.guard.margin_m, {0.0, 0.5});
  reader.read("guard_memory_m", params.guard_memory_m, {0.0, 0.5});
  params.guard.max_age_s = params.limits.scan_s + params.limits.odom_s;
  reader.read("timeout_s", params.timeout_s, {0.1, 3600.0});
}

/// Accepts move_base's other parameters, so that its files load; one note names those that are set.
void read_rest(ParamReader& reader, const ros::NodeHandle& handle, std::vector<std::string>& notes) {
  std::string set;
  for (const char* key : kWithoutMeaning) {
    reader.accept(key);
    if (handle.hasParam(key)) set += (set.empty() ? "" : ", ") + std::string(key);
  }
  if (!set.empty()) notes.push_back("parameters of move_base without effect here: " + set);
}

void read_base(ParamReader& reader, NavigatorNodeParams& params) {
  bool holonomic = true;
  reader.read("holonomic_robot", holonomic);
  params.base = holonomic ? BaseKind::kHolonomic : BaseKind::kDifferential;
  read_limits(reader, params.navigator.limits);
  if (!holonomic) params.navigator.limits.max_vy_m_s = 0;
  params.global.base = params.local.base = params.base;
  params.local.limits = params.navigator.limits;
}

}  // namespace

Result<NavigatorNodeParams> load_navigator_params(const ros::NodeHandle& private_handle) {
  NavigatorNodeParams params;
  ParamReader reader(private_handle);
  read_frames(reader, params);
  read_footprint(reader, private_handle, params.footprint);
  read_base(reader, params);
  read_behaviour(reader, params);
  read_planners(reader, params);
  read_costs(reader, params.costs);
  read_data(reader, params);
  read_rest(reader, private_handle, params.notes);
  if (const auto fits = navigate::validate(params.navigator); !fits) reader.complain(fits.error().message);
  params.read = reader.params();
  if (auto finished = reader.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

Result<navigate::Overhang> load_overhang(const ros::NodeHandle& handle, const NavigatorNodeParams& params) {
  std::string key;
  std::string urdf;
  if (!handle.searchParam("robot_description", key) || !handle.getParam(key, urdf))
    return fail(ErrorCode::kNotFound, "the parameter robot_description is not set: arms do not count");
  const auto robot = RobotModel::from_urdf(urdf, ros::package::getPath("extperfc"));
  if (!robot) return tl::unexpected(robot.error());
  return navigate::Overhang::make(*robot, params.base_frame, params.arms.max_height_m);
}

}  // namespace extperfc::ros_params
