// Every rule of config/translate/indigo_noetic.yaml with concrete values.
#include <gtest/gtest.h>

#include "test/unit/translate/rules/shipped.hpp"

namespace extperfc::translate {
namespace {

class IndigoNoeticTest : public ShippedTest {
 protected:
  static void forward(const std::string& type, const std::string& from, const std::string& to) {
    expect_becomes(type, "indigo", from, "noetic", to);
  }
  static void backward(const std::string& type, const std::string& from, const std::string& to) {
    expect_becomes(type, "noetic", from, "indigo", to);
  }
  static void both_directions(const std::string& type, const std::string& indigo, const std::string& noetic) {
    expect_both_directions(type, "indigo", indigo, "noetic", noetic);
  }
};

// Whatever a definition changed in its own text has a rule each way; what it embeds may change without one.
TEST_F(IndigoNoeticTest, EveryChangeOfItsOwnHasARuleInEachDirection) {
  std::size_t changed = 0;
  const auto check = [&](const SchemaPtr& indigo, const SchemaPtr& noetic) {
    if (!indigo || !noetic || indigo->text() == noetic->text()) return;
    ++changed;
    EXPECT_NE(rules->find(*indigo, *noetic), nullptr) << indigo->type() << " has no rule forward";
    EXPECT_NE(rules->find(*noetic, *indigo), nullptr) << indigo->type() << " has no rule backward";
  };
  const auto content = definitions->content("indigo");
  for (const auto& type : content.messages) check(schema("indigo", type), schema("noetic", type));
  for (const auto& type : content.services)
    for (const std::string half : {"Request", "Response"})
      check(schema("indigo", type + half), schema("noetic", type + half));
  // 20 less the actions Pickup and Place, which are covered by their results.
  EXPECT_EQ(changed, 18U);
}

TEST_F(IndigoNoeticTest, EveryTypeOfBothConvertsInBothDirections) {
  for (const auto& type : definitions->content("indigo").messages) {
    const auto indigo = schema("indigo", type), noetic = schema("noetic", type);
    if (!noetic) continue;
    for (const auto& [from, to] : {std::pair(indigo, noetic), std::pair(noetic, indigo)}) {
      const auto plan = Plan::compile(from, to, *rules);
      EXPECT_TRUE(plan) << plan.error().message;
    }
  }
}

TEST_F(IndigoNoeticTest, RenamedPackages) {
  EXPECT_EQ(rules->other_names("multimaster_msgs_fkie/MasterState"),
            std::vector<std::string>{"fkie_multimaster_msgs/MasterState"});
  EXPECT_EQ(rules->other_names("tf2_msgs/TFMessage"), std::vector<std::string>{"tf/tfMessage"});
}

TEST_F(IndigoNoeticTest, BatteryState) {
  both_directions(
      "sensor_msgs/BatteryState",
      "{header: {seq: 7}, voltage: 12.5, current: -1.5, percentage: 0.25, present: true, "
      "cell_voltage: [4.1, 4.2], location: slot, serial_number: a1}",
      "{header: {seq: 7}, voltage: 12.5, temperature: .nan, current: -1.5, percentage: 0.25, present: true, "
      "cell_voltage: [4.1, 4.2], cell_temperature: [], location: slot, serial_number: a1}");
  backward("sensor_msgs/BatteryState",
           "{voltage: 3, temperature: 25, cell_temperature: [20, 21], location: x}",
           "{voltage: 3, location: x}");
}

TEST_F(IndigoNoeticTest, SoundRequestPlaysAtFullVolume) {
  both_directions("sound_play/SoundRequest", "{sound: -3, command: 1, arg: hello}",
                  "{sound: -3, command: 1, volume: 1, arg: hello}");
  both_directions("sound_play/SoundRequestActionGoal",
                  "{goal: {sound_request: {sound: SAY, arg: hi, arg2: v}}}",
                  "{goal: {sound_request: {sound: SAY, volume: 1, arg: hi, arg2: v}}}");
}

TEST_F(IndigoNoeticTest, ConstantsAlonePass) {
  expect_pass("visualization_msgs/Marker", "indigo", "noetic");
  expect_pass("visualization_msgs/MarkerArray", "indigo", "noetic");
  expect_pass("visualization_msgs/InteractiveMarkerUpdate", "indigo", "noetic");
  expect_pass("moveit_msgs/MoveItErrorCodes", "indigo", "noetic");
  expect_pass("moveit_msgs/ExecuteTrajectoryActionResult", "indigo", "noetic");
  backward("visualization_msgs/Marker", "{ns: a, action: DELETEALL}", "{ns: a, action: 3}");
  backward("moveit_msgs/MoveItErrorCodes", "{val: START_STATE_INVALID}", "{val: -26}");
}

TEST_F(IndigoNoeticTest, JointControllerState) {
  both_directions("control_msgs/JointControllerState", "{set_point: 1, command: 2, i_clamp: 3}",
                  "{set_point: 1, command: 2, i_clamp: 3, antiwindup: false}");
  backward("control_msgs/JointControllerState", "{i_clamp: 4, antiwindup: true}", "{i_clamp: 4}");
}

TEST_F(IndigoNoeticTest, ControllerStateOfOneInterface) {
  both_directions("controller_manager_msgs/ControllerState",
                  "{name: arm, state: running, type: t/T, hardware_interface: Effort, resources: [j1, j2]}",
                  "{name: arm, state: running, type: t/T, "
                  "claimed_resources: [{hardware_interface: Effort, resources: [j1, j2]}]}");
}

TEST_F(IndigoNoeticTest, ControllerStateOfNoneAndOfTwoInterfaces) {
  backward("controller_manager_msgs/ControllerState", "{name: arm, claimed_resources: []}", "{name: arm}");
  backward("controller_manager_msgs/ControllerState",
           "{name: arm, claimed_resources: [{hardware_interface: Effort, resources: [j1]}, "
           "{hardware_interface: Position, resources: [j2]}]}",
           "{name: arm, hardware_interface: Effort, resources: [j1]}");
}

TEST_F(IndigoNoeticTest, ListControllersConvertsEachController) {
  both_directions(
      "controller_manager_msgs/ListControllersResponse",
      "{controller: [{name: a, hardware_interface: E, resources: [j]}, {name: b, hardware_interface: P}]}",
      "{controller: [{name: a, claimed_resources: [{hardware_interface: E, resources: [j]}]}, "
      "{name: b, claimed_resources: [{hardware_interface: P}]}]}");
}

TEST_F(IndigoNoeticTest, SwitchController) {
  both_directions("controller_manager_msgs/SwitchControllerRequest",
                  "{start_controllers: [a], stop_controllers: [b, c], strictness: STRICT}",
                  "{start_controllers: [a], stop_controllers: [b, c], strictness: STRICT, start_asap: false, "
                  "timeout: 0}");
  backward("controller_manager_msgs/SwitchControllerRequest",
           "{strictness: 1, start_asap: true, timeout: 2.5}", "{strictness: 1}");
}

TEST_F(IndigoNoeticTest, GetModelState) {
  both_directions("gazebo_msgs/GetModelStateResponse",
                  "{pose: {position: {x: 1}}, success: true, status_message: fine}",
                  "{header: {frame_id: ''}, pose: {position: {x: 1}}, success: true, status_message: fine}");
  backward("gazebo_msgs/GetModelStateResponse",
           "{header: {seq: 3, frame_id: world}, twist: {linear: {y: 2}}}", "{twist: {linear: {y: 2}}}");
}

TEST_F(IndigoNoeticTest, CollisionObjectGetsTheIdentityPose) {
  both_directions("moveit_msgs/CollisionObject",
                  "{id: box, primitives: [{type: 1, dimensions: [1, 2, 3]}], "
                  "primitive_poses: [{position: {x: 0.1}, orientation: {w: 1}}], "
                  "plane_poses: [{position: {z: 4}, orientation: {x: 1}}], operation: APPEND}",
                  "{id: box, pose: {orientation: {w: 1}}, primitives: [{type: 1, dimensions: [1, 2, 3]}], "
                  "primitive_poses: [{position: {x: 0.1}, orientation: {w: 1}}], "
                  "plane_poses: [{position: {z: 4}, orientation: {x: 1}}], operation: APPEND}");
}

// The object stands at (1, 2, 3), turned by half a turn about z: a shape at (0.5, 0.25, 0) of it stands at
// (0.5, 1.75, 3).
TEST_F(IndigoNoeticTest, CollisionObjectsShapesMoveWithItsPose) {
  backward("moveit_msgs/CollisionObject",
           "{id: box, pose: {position: {x: 1, y: 2, z: 3}, orientation: {z: 1}}, "
           "primitive_poses: [{position: {x: 0.5, y: 0.25}, orientation: {w: 1}}], "
           "mesh_poses: [{orientation: {w: 1}}, {position: {z: 1}, orientation: {w: 1}}], "
           "subframe_names: [tip], subframe_poses: [{orientation: {w: 1}}]}",
           "{id: box, primitive_poses: [{position: {x: 0.5, y: 1.75, z: 3}, orientation: {z: 1}}], "
           "mesh_poses: [{position: {x: 1, y: 2, z: 3}, orientation: {z: 1}}, "
           "{position: {x: 1, y: 2, z: 4}, orientation: {z: 1}}]}");
}

// A program of Noetic that does not fill the pose in sends zeros: the shapes stay where they are.
TEST_F(IndigoNoeticTest, CollisionObjectWithoutAPoseKeepsItsShapes) {
  backward("moveit_msgs/CollisionObject", "{primitive_poses: [{position: {x: 0.5}, orientation: {w: 1}}]}",
           "{primitive_poses: [{position: {x: 0.5}, orientation: {w: 1}}]}");
}

TEST_F(IndigoNoeticTest, CollisionObjectsDeepInOtherMessages) {
  both_directions("moveit_msgs/PlanningScene",
                  "{name: s, world: {collision_objects: [{id: a}, {id: b}]}, "
                  "robot_state: {attached_collision_objects: [{link_name: l, object: {id: c}, weight: 2}]}}",
                  "{name: s, world: {collision_objects: [{id: a, pose: {orientation: {w: 1}}}, "
                  "{id: b, pose: {orientation: {w: 1}}}]}, robot_state: {attached_collision_objects: "
                  "[{link_name: l, object: {id: c, pose: {orientation: {w: 1}}}, weight: 2}]}}");
}

TEST_F(IndigoNoeticTest, DisplayRobotState) {
  both_directions("moveit_msgs/DisplayRobotState", "{highlight_links: [{id: l}]}",
                  "{highlight_links: [{id: l}], hide: false}");
  backward("moveit_msgs/DisplayRobotState", "{hide: true}", "{}");
}

TEST_F(IndigoNoeticTest, GetCartesianPath) {
  both_directions("moveit_msgs/GetCartesianPathRequest",
                  "{group_name: g, max_step: 0.01, jump_threshold: 5, avoid_collisions: true, "
                  "path_constraints: {name: c, orientation_constraints: [{link_name: l, weight: 1}]}}",
                  "{group_name: g, max_step: 0.01, jump_threshold: 5, avoid_collisions: true, "
                  "path_constraints: {name: c, orientation_constraints: [{link_name: l, weight: 1}]}}");
  backward("moveit_msgs/GetCartesianPathRequest",
           "{link_name: l, prismatic_jump_threshold: 1, revolute_jump_threshold: 2, "
           "cartesian_speed_limited_link: x, max_cartesian_speed: 3}",
           "{link_name: l}");
  both_directions("moveit_msgs/GetCartesianPathResponse", "{fraction: 0.5, error_code: {val: SUCCESS}}",
                  "{fraction: 0.5, error_code: {val: SUCCESS}}");
}

TEST_F(IndigoNoeticTest, MotionPlanRequest) {
  both_directions("moveit_msgs/MotionPlanRequest",
                  "{planner_id: rrt, group_name: arm, num_planning_attempts: 3, allowed_planning_time: 5, "
                  "max_velocity_scaling_factor: 0.5, max_acceleration_scaling_factor: 0.25, "
                  "goal_constraints: [{name: g, orientation_constraints: [{weight: 2}]}]}",
                  "{planner_id: rrt, group_name: arm, num_planning_attempts: 3, allowed_planning_time: 5, "
                  "max_velocity_scaling_factor: 0.5, max_acceleration_scaling_factor: 0.25, "
                  "goal_constraints: [{name: g, orientation_constraints: [{weight: 2}]}]}");
  backward("moveit_msgs/MotionPlanRequest",
           "{reference_trajectories: [{header: {frame_id: f}}], pipeline_id: ompl, planner_id: rrt, "
           "cartesian_speed_limited_link: l, max_cartesian_speed: 1}",
           "{planner_id: rrt}");
}

TEST_F(IndigoNoeticTest, OrientationConstraint) {
  both_directions(
      "moveit_msgs/OrientationConstraint", "{link_name: l, absolute_z_axis_tolerance: 0.1, weight: 1}",
      "{link_name: l, absolute_z_axis_tolerance: 0.1, parameterization: XYZ_EULER_ANGLES, weight: 1}");
  backward("moveit_msgs/OrientationConstraint", "{parameterization: ROTATION_VECTOR, weight: 2}",
           "{weight: 2}");
}

TEST_F(IndigoNoeticTest, ResultsOfPickupAndPlace) {
  for (const std::string name : {"Pickup", "Place"}) {
    both_directions("moveit_msgs/" + name + "Result", "{error_code: {val: -1}, trajectory_descriptions: [a]}",
                    "{error_code: {val: -1}, trajectory_descriptions: [a], planning_time: 0}");
    backward("moveit_msgs/" + name + "ActionResult",
             "{status: {goal_id: {id: g}, status: 3}, result: {planning_time: 1.5}}",
             "{status: {goal_id: {id: g}, status: 3}}");
  }
}

TEST_F(IndigoNoeticTest, PlaceLocation) {
  both_directions("moveit_msgs/PlaceLocation", "{id: p, allowed_touch_objects: [t]}",
                  "{id: p, quality: 0, allowed_touch_objects: [t]}");
  backward("moveit_msgs/PlaceLocation", "{id: p, quality: 0.75}", "{id: p}");
}

TEST_F(IndigoNoeticTest, PlannerInterfaceDescription) {
  both_directions("moveit_msgs/PlannerInterfaceDescription", "{name: OMPL, planner_ids: [a, b]}",
                  "{name: OMPL, pipeline_id: '', planner_ids: [a, b]}");
  backward("moveit_msgs/PlannerInterfaceDescription", "{name: OMPL, pipeline_id: ompl}", "{name: OMPL}");
}

TEST_F(IndigoNoeticTest, PositionIkRequest) {
  both_directions("moveit_msgs/PositionIKRequest", "{group_name: arm, avoid_collisions: true, attempts: 0}",
                  "{group_name: arm, avoid_collisions: true}");
  forward("moveit_msgs/PositionIKRequest", "{ik_link_name: hand, attempts: 7}", "{ik_link_name: hand}");
}

}  // namespace
}  // namespace extperfc::translate
