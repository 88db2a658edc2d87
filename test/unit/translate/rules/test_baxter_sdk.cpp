// Every rule of config/translate/baxter_sdk.yaml with concrete values, and the chains across releases.
#include <array>

#include <gtest/gtest.h>

#include "test/unit/translate/rules/shipped.hpp"

namespace extperfc::translate {
namespace {

constexpr const char* k07 = "baxter_sdk_0.7.0";
constexpr const char* k10 = "baxter_sdk_1.0.1";
constexpr const char* k11 = "baxter_sdk_1.1.1";
constexpr const char* k12 = "baxter_sdk_1.2.0";

std::string core(const std::string& name) {
  return "baxter_core_msgs/" + name;
}

class BaxterSdkTest : public ShippedTest {};

TEST_F(BaxterSdkTest, EveryChangeBetweenReleasesHasARuleInEachDirection) {
  const std::array<std::string, 6> releases{k07, "baxter_sdk_1.0.0", k10, "baxter_sdk_1.1.0", k11, k12};
  std::size_t changed = 0, lost = 0;
  for (std::size_t i = 0; i + 1 < releases.size(); ++i) {
    const auto content = definitions->content(releases[i]);
    const auto check = [&](const std::string& type) {
      const auto older = schema(releases[i], type), newer = schema(releases[i + 1], type);
      if (!newer) ++lost;
      if (!newer || older->md5() == newer->md5()) return;
      ++changed;
      EXPECT_NE(rules->find(*older, *newer), nullptr)
          << type << " from " << releases[i] << " has no rule forward";
      EXPECT_NE(rules->find(*newer, *older), nullptr)
          << type << " from " << releases[i] << " has no rule backward";
    };
    for (const auto& type : content.messages)
      if (type.rfind("baxter_", 0) == 0) check(type);
    for (const auto& type : content.services)
      if (type.rfind("baxter_", 0) == 0)
        for (const std::string half : {"Request", "Response"}) check(type + half);
  }
  EXPECT_EQ(changed,
            19U);  // 23 changes: 18 with both sides, of which one is a service that changed in both halves
  EXPECT_EQ(lost, 6U);  // ITBState, ITBStates, and both halves of LSCores and RMCores
}

TEST_F(BaxterSdkTest, EndpointStateGetsABaseFrame) {
  expect_both_directions(core("EndpointState"), k07, "{pose: {position: {x: 1}}, wrench: {force: {z: 2}}}",
                         k10,
                         "{header: {frame_id: base}, pose: {position: {x: 1}}, wrench: {force: {z: 2}}}");
  expect_both_directions(core("EndpointStates"), k07, "{names: [left], states: [{pose: {position: {y: 3}}}]}",
                         k12,
                         "{names: [left], states: [{header: {frame_id: base}, pose: {position: {y: 3}}}]}");
}

TEST_F(BaxterSdkTest, JointCommandPasses) {
  expect_pass(core("JointCommand"), k07, k12);
  expect_becomes(core("JointCommand"), k12, "{mode: RAW_POSITION_MODE, command: [0.5], names: [left_s0]}",
                 k07, "{mode: 4, command: [0.5], names: [left_s0]}");
}

TEST_F(BaxterSdkTest, RobustControllerStatus) {
  expect_both_directions(core("RobustControllerStatus"), k07,
                         "{isEnabled: true, complete: 2, errorCodes: [e1]}", k10,
                         "{isEnabled: true, complete: 2, errorCodes: [e1], labels: []}");
  expect_becomes(core("RobustControllerStatus"), k10, "{controlUid: u, labels: [a, b]}", k07,
                 "{controlUid: u}");
}

TEST_F(BaxterSdkTest, SeaJointStateReportsWhatTheJointsDo) {
  expect_both_directions(
      core("SEAJointState"), k07,
      "{name: [a, b], position: [1, 2], velocity: [3, 4], effort: [5, 6], gravity_model_effort: [7, 8]}", k10,
      "{name: [a, b], actual_position: [1, 2], actual_velocity: [3, 4], actual_effort: [5, 6], "
      "gravity_model_effort: [7, 8]}");
  expect_becomes(core("SEAJointState"), k10, "{commanded_position: [9], actual_position: [1], hystState: 2}",
                 k07, "{position: [1]}");
}

TEST_F(BaxterSdkTest, SeaJointStateGainsGravity) {
  expect_both_directions(core("SEAJointState"), k10,
                         "{commanded_effort: [1], gravity_model_effort: [2], hystState: 3}", k11,
                         "{commanded_effort: [1], gravity_model_effort: [2], hystState: 3}");
  expect_becomes(core("SEAJointState"), k11, "{commanded_acceleration: [1], gravity_only: [2], hystState: 3}",
                 k10, "{hystState: 3}");
}

TEST_F(BaxterSdkTest, SolvePositionIk) {
  expect_both_directions(core("SolvePositionIKRequest"), k07, "{pose_stamp: [{header: {frame_id: base}}]}",
                         k10,
                         "{pose_stamp: [{header: {frame_id: base}}], seed_angles: [], seed_mode: SEED_AUTO}");
  expect_becomes(core("SolvePositionIKRequest"), k12,
                 "{seed_angles: [{name: [left_s0]}], seed_mode: SEED_USER}", k07, "{}");
  expect_becomes(core("SolvePositionIKResponse"), k07, "{joints: [{name: [a]}, {}], isValid: [true, false]}",
                 k12, "{joints: [{name: [a]}, {}], isValid: [true, false], result_type: [2, 0]}");
  expect_becomes(core("SolvePositionIKResponse"), k12, "{isValid: [true, false], result_type: [3, 0]}", k07,
                 "{isValid: [true, false]}");
}

TEST_F(BaxterSdkTest, NavigatorStateBecomesLists) {
  expect_both_directions(
      core("NavigatorState"), k10, "{ok: true, show: true, wheel: 200, outerLight: true}", k11,
      "{names: [ok, cancel, show], buttons: [true, false, true], wheel: 200, lights: [false, true]}");
  expect_becomes(core("NavigatorState"), k11, "{names: [x], buttons: [true], wheel: 7, lights: []}", k10,
                 "{ok: true, wheel: 7}");
}

TEST_F(BaxterSdkTest, NavigatorStateNamesItsLights) {
  expect_both_directions(core("NavigatorState"), k11,
                         "{names: [ok], buttons: [true], wheel: 1, lights: [true, false]}", k12,
                         "{button_names: [ok], buttons: [true], wheel: 1, light_names: [inner, outer], "
                         "lights: [true, false]}");
}

TEST_F(BaxterSdkTest, NavigatorStatesConvertEachState) {
  expect_both_directions(
      core("NavigatorStates"), k10, "{names: [l], states: [{cancel: true}]}", k11,
      "{names: [l], states: [{names: [ok, cancel, show], buttons: [0, 1, 0], lights: [0, 0]}]}");
  expect_both_directions(core("NavigatorStates"), k11, "{names: [l], states: [{names: [b]}, {wheel: 2}]}",
                         k12,
                         "{names: [l], states: [{button_names: [b], light_names: [inner, outer]}, "
                         "{wheel: 2, light_names: [inner, outer]}]}");
}

TEST_F(BaxterSdkTest, ReadyMeansEnabledToAnOldRobot) {
  expect_both_directions(core("AssemblyState"), k11, "{enabled: true, estop_button: 3}", k12,
                         "{ready: true, enabled: true, estop_button: 3}");
  expect_both_directions(core("AssemblyState"), k11, "{stopped: true, error: true}", k12,
                         "{ready: false, stopped: true, error: true}");
  expect_becomes(core("AssemblyState"), k12, "{ready: false, enabled: true}", k11, "{enabled: true}");
  expect_both_directions(core("AssemblyStates"), k11, "{names: [a], states: [{enabled: true}]}", k12,
                         "{names: [a], states: [{ready: true, enabled: true}]}");
}

TEST_F(BaxterSdkTest, OnlyElectricGrippersCalibrate) {
  expect_both_directions(
      core("EndEffectorProperties"), k11,
      "{id: 5, ui_type: ELECTRIC_GRIPPER, manufacturer: m, controls_grip: true, properties: p}", k12,
      "{id: 5, ui_type: ELECTRIC_GRIPPER, manufacturer: m, has_calibration: true, controls_grip: true, "
      "properties: p}");
  expect_both_directions(core("EndEffectorProperties"), k11, "{ui_type: CUSTOM_GRIPPER}", k12,
                         "{ui_type: PASSIVE_GRIPPER, has_calibration: false}");
  expect_becomes(core("EndEffectorProperties"), k11, "{ui_type: 9}", k12,
                 "{ui_type: 9, has_calibration: false}");
}

TEST_F(BaxterSdkTest, HeadPanCommandTurnsPercentIntoARatio) {
  for (const char* old_release : {k07, k10, k11}) {
    expect_both_directions(core("HeadPanCommand"), old_release, "{target: 0.5, speed: 50}", k12,
                           "{target: 0.5, speed_ratio: 0.5, enable_pan_request: REQUEST_PAN_ENABLE}");
    expect_both_directions(core("HeadPanCommand"), old_release, "{target: -1.25, speed: 100}", k12,
                           "{target: -1.25, speed_ratio: 1, enable_pan_request: REQUEST_PAN_ENABLE}");
  }
  expect_becomes(core("HeadPanCommand"), k12, "{speed_ratio: 0.256, enable_pan_request: REQUEST_PAN_DISABLE}",
                 k07, "{speed: 26}");
  expect_becomes(core("HeadPanCommand"), k12, "{speed_ratio: 1e20}", k07, "{speed: 2147483647}");
}

TEST_F(BaxterSdkTest, HeadState) {
  expect_both_directions(core("HeadState"), k11, "{pan: 0.25, isPanning: true}", k12,
                         "{pan: 0.25, isTurning: true, isPanEnabled: true}");
  expect_becomes(core("HeadState"), k12, "{isNodding: true, isPanEnabled: false}", k11, "{isNodding: true}");
}

TEST_F(BaxterSdkTest, Calibration) {
  expect_both_directions("baxter_maintenance_msgs/CalibrateArmData", k11, "{}", k12,
                         "{suppressWriteToFile: false}");
  expect_becomes("baxter_maintenance_msgs/CalibrateArmData", k12, "{suppressWriteToFile: true}", k11, "{}");
  expect_both_directions("baxter_maintenance_msgs/CalibrateArmEnable", k11, "{isEnabled: true, uid: u}", k12,
                         "{isEnabled: true, uid: u, data: {suppressWriteToFile: false}}");
}

// ---- across several releases ----

TEST_F(BaxterSdkTest, NavigatorStateFrom07To12) {
  expect_both_directions(core("NavigatorState"), k07, "{cancel: true, wheel: 3, innerLight: true}", k12,
                         "{button_names: [ok, cancel, show], buttons: [false, true, false], wheel: 3, "
                         "light_names: [inner, outer], lights: [true, false]}");
  expect_both_directions(core("NavigatorStates"), k07, "{names: [l, r], states: [{ok: true}, {wheel: 9}]}",
                         k12,
                         "{names: [l, r], states: [{button_names: [ok, cancel, show], buttons: [1, 0, 0], "
                         "light_names: [inner, outer], lights: [0, 0]}, {button_names: [ok, cancel, show], "
                         "buttons: [0, 0, 0], wheel: 9, light_names: [inner, outer], lights: [0, 0]}]}");
}

TEST_F(BaxterSdkTest, SeaJointStateFrom07To12) {
  expect_both_directions(core("SEAJointState"), k07,
                         "{header: {seq: 4}, name: [j], position: [1], effort: [2]}", k12,
                         "{header: {seq: 4}, name: [j], actual_position: [1], actual_effort: [2]}");
}

TEST_F(BaxterSdkTest, EveryReleaseConvertsToEveryOther) {
  const std::array<std::string, 4> releases{k07, k10, k11, k12};
  for (const auto& from : releases)
    for (const auto& to : releases)
      for (const auto& type : definitions->content(from).messages) {
        const auto source = schema(from, type), target = schema(to, type);
        if (!target) continue;
        const auto plan = Plan::compile(source, target, *rules);
        EXPECT_TRUE(plan) << plan.error().message;
      }
}

}  // namespace
}  // namespace extperfc::translate
