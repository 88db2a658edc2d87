#include "ros/params/arm_params.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>

#include <ros/package.h>

#include "extperfc/base/math.hpp"

#include "ros/params/group_reader.hpp"
#include "ros/params/list_reader.hpp"

namespace extperfc::ros_params {

namespace {

namespace fs = std::filesystem;

std::string read_all(const fs::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

void read_robot(ParamReader& reader, const ros::NodeHandle& handle, ArmNodeParams& params) {
  std::string file;
  reader.read("urdf", file);
  if (!file.empty()) {
    params.urdf = read_all(file);
    if (params.urdf.empty()) reader.complain(handle.resolveName("urdf") + ": cannot read " + file);
  } else if (std::string key;
             !handle.searchParam("robot_description", key) || !handle.getParam(key, params.urdf)) {
    reader.complain("no robot: set the parameter robot_description, or " + handle.resolveName("urdf") +
                    " to a file");
  }
  params.srdf_file = fs::path(package_folder()) / "config" / "robots" / "baxter" / "mobile_baxter.srdf";
  reader.read("srdf", params.srdf_file);
  reader.read("world_frame", params.world_frame);
  if (params.world_frame.empty()) reader.complain("world_frame must be the name of a frame, not empty");
}

void read_requests(ParamReader& reader, ArmNodeParams& params) {
  reader.read("planning_time_s", params.planning_time_s, {0.01, 600.0});
  reader.read("velocity_scale", params.velocity_scale, {0.01, 1.0});
  reader.read("acceleration_scale", params.acceleration_scale, {0.01, 1.0});
  reader.read("transform_timeout_s", params.transform_timeout_s, {0.0, 10.0});
}

void read_planner(ParamReader& reader, const ros::NodeHandle& handle, arm::MotionPipelineParams& params) {
  NamedValues<std::string> names;
  for (const auto& name : arm::planner_names()) names[name] = name;
  read_named(reader, handle, "planner", params.planner.planner, names);
  reader.read("range_rad", params.planner.range_rad, {0.05, 3.0});
  reader.read("max_states", params.planner.max_states, {2, 10'000'000});
  reader.read("shortcut_rounds", params.planner.shortcut_rounds, {0, 10'000});
  reader.read("limit_repair_rad", params.planner.limit_repair_rad, {0.0, 0.2});
  int seed = static_cast<int>(params.planner.seed);
  reader.read("seed", seed, {1, 2'147'483'647});
  params.planner.seed = static_cast<std::uint64_t>(seed);
  reader.read("padding_m", params.padding_m, {0.0015, 0.05});
  reader.read("corner_deviation_rad", params.corner_deviation_rad, {0.0, 0.5});
  reader.read("goal_samples", params.goal_samples, {1, 100});
  reader.read("goal_time_s", params.goal_time_s, {0.001, 60.0});
  reader.read("threads", params.threads, {1, 8});
}

void read_limits(ParamReader& reader, const ros::NodeHandle& handle, arm::RobotArmsParams& params) {
  reader.read("max_acceleration", params.default_max_acceleration, {0.01, 1000.0});
  reader.accept("joint_acceleration");
  std::map<std::string, double> given;
  if (handle.hasParam("joint_acceleration") && !handle.getParam("joint_acceleration", given))
    reader.complain(handle.resolveName("joint_acceleration") + " must be numbers by the names of joints");
  params.max_acceleration = given;
}

void read_execution(ParamReader& reader, ExecutionParams& params) {
  reader.read("monitor_rate_hz", params.monitor_rate_hz, {1.0, 200.0});
  reader.read("follow_tolerance_rad", params.follow_tolerance_rad, {0.001, 3.0});
  reader.read("follow_delay_s", params.follow_delay_s, {0.0, 5.0});
  reader.read("start_tolerance_rad", params.start_tolerance_rad, {0.001, 1.0});
  reader.read("joint_state_timeout_s", params.joint_state_timeout_s, {0.05, 10.0});
  reader.read("finish_time_s", params.finish_time_s, {0.1, 60.0});
  reader.read("connect_timeout_s", params.connect_timeout_s, {0.0, 60.0});
  reader.read("start_delay_s", params.start_delay_s, {0.01, 2.0});
  reader.read("robot_state", params.robot_state);
}

void read_controllers(ParamReader& reader, const ros::NodeHandle& handle, ArmNodeParams& params) {
  const auto set = [](ControllerParams& controller, const std::string& key,
                      const Entry& entry) -> Result<void> {
    if (key == "action")
      controller.action = entry.text();
    else if (key == "group")
      controller.group = entry.text();
    else
      return fail(ErrorCode::kInvalidArgument, "unknown; action and group are known");
    return {};
  };
  params.controllers = read_list<ControllerParams>(reader, handle, "controllers", set);
  if (params.controllers.empty())
    params.controllers = {{"robot/limb/left/follow_joint_trajectory", "left_arm"},
                          {"robot/limb/right/follow_joint_trajectory", "right_arm"}};
  for (const auto& controller : params.controllers)
    if (controller.action.empty() || controller.group.empty())
      reader.complain(handle.resolveName("controllers") + ": each needs an action and a group");
}

void read_grasp(ParamReader& reader, GraspNodeParams& params) {
  reader.read("lift_m", params.grasp.lift_m, {0.01, 0.5});
  reader.read("approach_m", params.grasp.approach_m, {0.005, 0.5});
  reader.read("retreat_m", params.retreat_m, {0.01, 0.5});
  reader.read("lower_m", params.lower_m, {0.01, 0.5});
  reader.read("friction", params.grasp.friction, {0.05, 3.0});
  reader.read("side_clearance_m", params.grasp.side_clearance_m, {0.0, 0.05});
  reader.read("support_clearance_m", params.grasp.support_clearance_m, {0.0, 0.1});
  reader.read("palm_clearance_m", params.grasp.palm_clearance_m, {0.0, 0.1});
  reader.read("prefer_top", params.grasp.prefer_top, {0.0, 0.99});
  reader.read("max_tilt_rad", params.grasp.max_tilt_rad, {0.0, kPi});
  reader.read("tilt_step_rad", params.grasp.tilt_step_rad, {0.05, 1.6});
  reader.read("effort_percent", params.effort_percent, {0.0, 100.0});
  reader.read("gripper_timeout_s", params.gripper_timeout_s, {0.5, 60.0});
  reader.read("slow", params.slow, {0.01, 1.0});
}

void read_depth(ParamReader& reader, const ros::NodeHandle& handle, DepthObstacleMonitorParams& params) {
  auto& seen = params.obstacles;
  reader.read("enabled", params.enabled);
  reader.read("rate_hz", params.rate_hz, {0.1, 60.0});
  reader.read("timeout_s", params.timeout_s, {0.1, 3600.0});
  const char axes[] = {'x', 'y', 'z'};
  for (int i = 0; i < 3; ++i) {
    reader.read(std::string("low_") + axes[i] + "_m", seen.low_m[i], {-20.0, 20.0});
    reader.read(std::string("high_") + axes[i] + "_m", seen.high_m[i], {-20.0, 20.0});
  }
  reader.read("voxel_m", seen.voxel_m, {0.005, 0.2});
  reader.read("pixel_step", seen.pixel_step, {1, 16});
  reader.read("min_depth_m", seen.min_depth_m, {0.01, 10.0});
  reader.read("max_depth_m", seen.max_depth_m, {0.01, 20.0});
  reader.read("min_points", seen.min_points, {1, 1000});
  reader.read("robot_padding_m", seen.robot_padding_m, {0.0, 0.3});
  reader.read("object_padding_m", seen.object_padding_m, {0.0, 0.3});
  reader.read("clear_margin_m", seen.clear_margin_m, {0.0, 0.5});
  reader.read("max_age_s", seen.max_age_s, {0.05, 3600.0});
  reader.read("max_boxes", seen.max_boxes, {8, 5000});
  if (const auto fits = seen.validate(); !fits)
    reader.complain(handle.getNamespace() + ": " + fits.error().message);
}

void read_objects(ParamReader& reader, const ros::NodeHandle& handle, ObjectMonitorParams& params) {
  reader.read("enabled", params.enabled);
  reader.read("min_score", params.min_score, {0.0, 1.0});
  reader.read("largest_m", params.largest_m, {0.001, 100.0});
  reader.read("timeout_s", params.timeout_s, {0.1, 3600.0});
  read_named_by_label(reader, handle, "shapes", params.shapes,
                      {{"box", arm::UprightKind::kBox},
                       {"sphere", arm::UprightKind::kSphere},
                       {"cylinder", arm::UprightKind::kCylinder},
                       {"cone", arm::UprightKind::kCone}});
  reader.read("confirm", params.list.confirm, {1, 100});
  reader.read("max_age_s", params.list.max_age_s, {0.0, 1e6});
  reader.read("match_m", params.list.match_m, {0.001, 10.0});
  reader.read("max_objects", params.list.max_objects, {1, 500});
  reader.read("min_change_m", params.list.min_change_m, {0.0, 1.0});
  reader.read("min_change_rad", params.list.min_change_rad, {0.0, 3.15});
  reader.read("average", params.list.average, {1, 1000});
  reader.read("new_score", params.list.new_score, {0.0, 1.0});
}

void read_grippers(ParamReader& reader, const ros::NodeHandle& handle, ArmNodeParams& params) {
  const auto set = [](GripperParams& gripper, const std::string& key, const Entry& entry) -> Result<void> {
    const NamedValues<std::string*> fields{{"name", &gripper.name},
                                           {"group", &gripper.group},
                                           {"tip", &gripper.tip},
                                           {"finger_joint", &gripper.finger_joint},
                                           {"action", &gripper.action}};
    const auto field = fields.find(key);
    if (field == fields.end())
      return fail(ErrorCode::kInvalidArgument,
                  "unknown; name, group, tip, finger_joint and action are known");
    *field->second = entry.text();
    return {};
  };
  params.grippers = read_list<GripperParams>(reader, handle, "grippers", set);
  for (const auto& gripper : params.grippers)
    if (gripper.name.empty() || gripper.group.empty() || gripper.tip.empty() ||
        gripper.finger_joint.empty() || gripper.action.empty())
      reader.complain(handle.resolveName("grippers") +
                      ": each needs a name, group, tip, finger_joint and action");
}

}  // namespace

std::string package_folder() {
  return ros::package::getPath("extperfc");
}

Result<ArmNodeParams> load_arm_params(const ros::NodeHandle& private_handle) {
  ArmNodeParams params;
  GroupReader groups(private_handle);
  groups.group("", [&](ParamReader& reader, const ros::NodeHandle& handle) {
    for (const char* group : {"planning", "limits", "execution", "jog", "grasp", "depth", "objects"})
      reader.accept(group);
    read_robot(reader, handle, params);
    read_requests(reader, params);
    read_controllers(reader, handle, params);
    read_grippers(reader, handle, params);
  });
  groups.group("planning", [&](ParamReader& reader, const ros::NodeHandle& handle) {
    read_planner(reader, handle, params.pipeline);
  });
  groups.group("limits", [&](ParamReader& reader, const ros::NodeHandle& handle) {
    read_limits(reader, handle, params.robot);
  });
  groups.group("execution", [&](ParamReader& reader, const ros::NodeHandle&) {
    read_execution(reader, params.execution);
  });
  groups.group("jog", [&](ParamReader& reader, const ros::NodeHandle&) {
    reader.read("rate_hz", params.jog.rate_hz, {10.0, 500.0});
    reader.read("command_timeout_s", params.jog.command_timeout_s, {0.02, 2.0});
    reader.read("velocity_scale", params.jog.velocity_scale, {0.01, 1.0});
  });
  groups.group("grasp",
               [&](ParamReader& reader, const ros::NodeHandle&) { read_grasp(reader, params.grasp); });
  groups.group("depth", [&](ParamReader& reader, const ros::NodeHandle& handle) {
    read_depth(reader, handle, params.depth);
  });
  groups.group("objects", [&](ParamReader& reader, const ros::NodeHandle& handle) {
    read_objects(reader, handle, params.objects);
  });
  if (auto finished = groups.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

}  // namespace extperfc::ros_params
