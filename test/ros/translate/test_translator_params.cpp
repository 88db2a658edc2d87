// Parameters of the translator: what is shipped loads and has the defaults, everything arrives where it
// belongs, and all errors are reported at once.
#include <algorithm>
#include <cstdlib>
#include <regex>

#include <gtest/gtest.h>
#include <ros/master.h>

#include "ros/params/translator_params.hpp"
#include "test/ros/translate/translator_test.hpp"

namespace extperfc::ros_test {
namespace {

using ros_params::load_translator_params;
using ros_params::TranslatorParams;
using std::chrono::milliseconds;
using translate::Directions;
using translate::Priority;

constexpr const char* kNs = "/translator_under_test";
constexpr const char* kRobotMaster = "http://robot.local:11311";

class TranslatorParamsTest : public testing::Test {
 protected:
  TranslatorParamsTest() {
    (void)ros::param::del(kNs);
    set_yaml(
        "{robot: {master_uri: 'http://robot.local:11311'}, topics: {allow: ['.*']}, services: {allow: "
        "['.*']}}");
  }

  static void set_yaml(const std::string& yaml) { set_merged(kNs, YAML::Load(yaml)); }
  static Result<TranslatorParams> load() {
    return load_translator_params(ros::NodeHandle(kNs), "/translator");
  }
  static TranslatorParams loaded() {
    auto params = load();
    EXPECT_TRUE(params) << params.error().message;
    return params ? *params : TranslatorParams{};
  }
  static void expect_problems(const std::vector<std::string>& texts) {
    const auto params = load();
    ASSERT_FALSE(params);
    for (const auto& text : texts)
      EXPECT_NE(params.error().message.find(text), std::string::npos) << text << "\nis not in\n"
                                                                      << params.error().message;
  }
};

void expect_equal(const translate::SideParams& a, const translate::SideParams& b) {
  EXPECT_EQ(a.definitions, b.definitions);
  EXPECT_EQ(a.peer.name, b.peer.name);
  EXPECT_EQ(a.peer.master_uri, b.peer.master_uri);
  EXPECT_EQ(a.peer.advertised_host, b.peer.advertised_host);
  EXPECT_EQ(a.peer.bind_address, b.peer.bind_address);
  EXPECT_EQ(a.peer.hosts, b.peer.hosts);
  EXPECT_EQ(a.peer.master_period, b.peer.master_period);
  EXPECT_EQ(a.peer.master_timeout, b.peer.master_timeout);
  EXPECT_EQ(a.peer.node_timeout, b.peer.node_timeout);
  EXPECT_EQ(a.peer.tcpros.header_bytes, b.peer.tcpros.header_bytes);
  EXPECT_EQ(a.peer.tcpros.message_bytes, b.peer.tcpros.message_bytes);
  EXPECT_EQ(a.peer.tcpros.links, b.peer.tcpros.links);
  EXPECT_EQ(a.peer.tcpros.handshake, b.peer.tcpros.handshake);
  EXPECT_EQ(a.peer.tcpros.unacknowledged, b.peer.tcpros.unacknowledged);
  EXPECT_EQ(a.peer.tcpros.keep_alive, b.peer.tcpros.keep_alive);
  EXPECT_EQ(a.peer.tcpros.retry_first, b.peer.tcpros.retry_first);
  EXPECT_EQ(a.peer.tcpros.retry_last, b.peer.tcpros.retry_last);
  EXPECT_EQ(a.peer.tcpros.read_at_once, b.peer.tcpros.read_at_once);
  EXPECT_EQ(a.peer.rpc.body_bytes, b.peer.rpc.body_bytes);
  EXPECT_EQ(a.peer.rpc.connections, b.peer.rpc.connections);
  EXPECT_EQ(a.peer.rpc.idle, b.peer.rpc.idle);
  EXPECT_EQ(a.peer.rpc.request, b.peer.rpc.request);
}

TEST_F(TranslatorParamsTest, ShippedConfigurationHasTheDefaults) {
  const auto defaults = loaded();
  set_from_file(kNs, "config/translator.yaml");
  const auto shipped = loaded();
  for (std::size_t i = 0; i < 2; ++i) expect_equal(shipped.bridge.sides[i], defaults.bridge.sides[i]);
  EXPECT_EQ(shipped.bridge.poll_period_s, defaults.bridge.poll_period_s);
  EXPECT_EQ(shipped.bridge.service_timeout_s, defaults.bridge.service_timeout_s);
  EXPECT_EQ(shipped.bridge.schema_patience_s, defaults.bridge.schema_patience_s);
  EXPECT_EQ(shipped.bridge.params_robot_to_workstation, defaults.bridge.params_robot_to_workstation);
  EXPECT_EQ(shipped.bridge.params_workstation_to_robot, defaults.bridge.params_workstation_to_robot);
  EXPECT_EQ(shipped.bridge.clock, defaults.bridge.clock);
  EXPECT_EQ(shipped.bridge.clock_direction, defaults.bridge.clock_direction);
  EXPECT_EQ(shipped.bridge.rosout, defaults.bridge.rosout);
  EXPECT_EQ(shipped.bridge.rosout_min_level, defaults.bridge.rosout_min_level);
  EXPECT_EQ(shipped.bridge.clocks.shift_stamps, defaults.bridge.clocks.shift_stamps);
  EXPECT_EQ(shipped.bridge.clocks.reference_topics, defaults.bridge.clocks.reference_topics);
  EXPECT_EQ(shipped.bridge.clocks.ntp_server, defaults.bridge.clocks.ntp_server);
  EXPECT_EQ(shipped.bridge.clocks.ntp_port, defaults.bridge.clocks.ntp_port);
  EXPECT_EQ(shipped.bridge.clocks.window_s, defaults.bridge.clocks.window_s);
  EXPECT_EQ(shipped.bridge.clocks.report_above_s, defaults.bridge.clocks.report_above_s);
  EXPECT_EQ(shipped.definitions.shipped, defaults.definitions.shipped);
  EXPECT_EQ(shipped.definitions.installed, defaults.definitions.installed);
  EXPECT_TRUE(shipped.definitions.folders.empty());
  EXPECT_EQ(shipped.rules.shipped, defaults.rules.shipped);
  EXPECT_TRUE(shipped.rules.files.empty());
  EXPECT_EQ(shipped.diagnostics.period_s, defaults.diagnostics.period_s);
  EXPECT_EQ(shipped.diagnostics.topic_period_s, defaults.diagnostics.topic_period_s);
  EXPECT_EQ(shipped.diagnostics.max_items, defaults.diagnostics.max_items);
  EXPECT_EQ(shipped.shut_down_patience_s, defaults.shut_down_patience_s);
}

/// The first profile that matches.
const translate::TopicProfile* profile_of(const TranslatorParams& params, const std::string& topic) {
  for (const auto& profile : params.bridge.profiles)
    if (std::regex_match(topic, std::regex(profile.pattern))) return &profile;
  return nullptr;
}

bool any_match(const std::vector<std::string>& expressions, const std::string& name) {
  return std::any_of(expressions.begin(), expressions.end(),
                     [&](const auto& expression) { return std::regex_match(name, std::regex(expression)); });
}

TEST_F(TranslatorParamsTest, ShippedFiltersBridgeUsefulTopics) {
  set_from_file(kNs, "config/translator.yaml");
  const auto bridge = loaded().bridge;
  const auto crosses = [](const translate::NameFilter& filter, const std::string& name) {
    return any_match(filter.allow, name) && !any_match(filter.deny, name);
  };
  for (const char* topic : {"/tf", "/tf_static", "/robot/joint_states", "/diagnostics",
                            "/cameras/head_camera/image", "/arm/follow_joint_trajectory/goal"})
    EXPECT_TRUE(crosses(bridge.topics, topic)) << topic;
  for (const char* topic :
       {"/rosout", "/rosout_agg", "/clock", "/statistics", "/manager/bond", "/diagnostics_agg"})
    EXPECT_FALSE(crosses(bridge.topics, topic)) << topic;
  for (const char* service : {"/cameras/list", "/ExternalTools/left/PositionKinematicsNode/IKService",
                              "/gazebo/get_model_state", "/node/set_parameters"})
    EXPECT_TRUE(crosses(bridge.services, service)) << service;
  for (const char* service : {"/node/get_loggers", "/node/set_logger_level", "/manager/load_nodelet"})
    EXPECT_FALSE(crosses(bridge.services, service)) << service;
}

TEST_F(TranslatorParamsTest, ShippedProfilesCarryCommandsBeforeImages) {
  set_from_file(kNs, "config/translator.yaml");
  const auto params = loaded();
  for (const char* topic :
       {"/robot/limb/left/joint_command", "/mobile_base/cmd_vel", "/robot/limb/right/set_speed_ratio",
        "/robot/limb/left/suppress_collision_avoidance"}) {
    const auto* profile = profile_of(params, topic);
    ASSERT_NE(profile, nullptr) << topic;
    EXPECT_EQ(profile->priority, Priority::kControl) << topic;
    EXPECT_EQ(profile->queue, 1U) << topic;
    EXPECT_EQ(profile->max_age_s, 0.2) << topic;
  }
  for (const char* topic :
       {"/cameras/head_camera/image", "/camera/depth/points", "/camera/color/image_raw/compressed"}) {
    const auto* profile = profile_of(params, topic);
    ASSERT_NE(profile, nullptr) << topic;
    EXPECT_EQ(profile->priority, Priority::kBulk) << topic;
    EXPECT_EQ(profile->queue, 2U) << topic;
  }
  EXPECT_EQ(profile_of(params, "/tf")->priority, Priority::kNormal);
  EXPECT_EQ(profile_of(params, "/arm/goal")->max_age_s, 2.0) << "a goal is not for after an outage";
  EXPECT_EQ(profile_of(params, "/arm/cancel")->max_age_s, 0.0) << "a cancel is right however late";
}

TEST_F(TranslatorParamsTest, BaxtersConfigurationLoads) {
  set_from_file(kNs, "config/translator.yaml");
  set_from_file(kNs, "config/robots/baxter/translator.yaml");
  const auto params = loaded();
  EXPECT_EQ(params.bridge.sides[0].definitions.front(), "baxter_sdk_1.2.0");
  EXPECT_EQ(params.bridge.params_robot_to_workstation.size(), 2U);
  const auto directions = [&](const char* topic) { return profile_of(params, topic)->directions; };
  EXPECT_EQ(directions("/robot/limb/left/joint_command"), Directions::kWorkstationToRobot);
  EXPECT_EQ(directions("/robot/joint_states"), Directions::kRobotToWorkstation);
  EXPECT_EQ(directions("/cameras/left_hand_camera/image"), Directions::kRobotToWorkstation);
  EXPECT_EQ(directions("/robot/xdisplay"), Directions::kWorkstationToRobot);
  EXPECT_EQ(profile_of(params, "/robot/limb/left/set_speed_ratio")->max_age_s, 0.0) << "latched: a state";
  EXPECT_EQ(profile_of(params, "/robot/limb/left/joint_command")->max_age_s, 0.2);
}

TEST_F(TranslatorParamsTest, EverythingArrivesWhereItBelongs) {
  set_yaml(R"(
robot: {name: /ours_there, advertised_host: 10.0.0.1, bind_address: 10.0.0.1, definitions: [a, b],
      hosts: ['10.0.0.2 robot.local robot', 'fe80::1 camera.local'], master_period_s: 2, node_timeout_s: 0.25}
workstation: {master_uri: 'http://home:1234', name: /ours_here, advertised_host: home}
poll_period_s: 0.5
service_timeout_s: 7
schema_patience_s: 1.5
shut_down_patience_s: 0.5
topics: {allow: ['/a.*'], deny: ['/a/b'], never: ['/a/c']}
services: {allow: [], deny: ['/s']}
profiles:
  - {pattern: '/x', directions: robot_to_workstation, queue: 3, max_rate_hz: 5, max_age_s: 0.5, priority: bulk,
     tcp_nodelay: false, lazy: false, frame_slash: strip}
common_profiles: [{pattern: '.*', frame_slash: add}]
parameters: {robot_to_workstation: [/robot_description], workstation_to_robot: [/tuning, /more]}
clock: {bridge: true, direction: workstation_to_robot}
rosout: {bridge: false, min_level: error}
clocks: {shift_stamps: true, reference_topics: [/js], ntp_server: robot.local, ntp_port: 1123, window_s: 3,
         report_above_s: 0.5}
connections: {handshake_s: 1, unacknowledged_s: 2, keep_alive_s: 3, retry_first_s: 0.5, retry_last_s: 4,
              max_links: 10, max_message_bytes: 1000000, max_header_bytes: 2000, read_at_once_bytes: 8192,
              rpc_max_connections: 20, rpc_max_body_bytes: 3000, rpc_idle_s: 5, rpc_request_s: 6}
definitions: {shipped: false, installed: false, folders: [{folder: /f, set: mine, fallback: indigo}]}
rules: {shipped: false, files: [/r.yaml]}
diagnostics: {period_s: 2, topic_period_s: 8, max_items: 5}
)");
  const auto params = loaded();
  const auto& bridge = params.bridge;
  const auto& robot = bridge.sides[0].peer;
  EXPECT_EQ(robot.master_uri, kRobotMaster);
  EXPECT_EQ(robot.name, "/ours_there");
  EXPECT_EQ(robot.advertised_host, "10.0.0.1");
  EXPECT_EQ(robot.bind_address, "10.0.0.1");
  EXPECT_NE(robot.hosts_remedy.find("/robot/hosts"), std::string::npos) << robot.hosts_remedy;
  EXPECT_NE(robot.advertised_host_remedy.find("/robot/advertised_host"), std::string::npos);
  EXPECT_EQ(robot.hosts,
            (std::map<std::string, std::string>{
                {"robot.local", "10.0.0.2"}, {"robot", "10.0.0.2"}, {"camera.local", "fe80::1"}}));
  EXPECT_EQ(robot.master_period, milliseconds(2000));
  EXPECT_EQ(robot.node_timeout, milliseconds(250));
  EXPECT_EQ(bridge.sides[0].definitions, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(bridge.sides[1].peer.master_uri, "http://home:1234");
  EXPECT_EQ(bridge.sides[1].peer.name, "/ours_here");
  EXPECT_EQ(bridge.sides[1].peer.advertised_host, "home");
  for (const auto& side : bridge.sides) {
    EXPECT_EQ(side.peer.tcpros.handshake, milliseconds(1000));
    EXPECT_EQ(side.peer.tcpros.unacknowledged, milliseconds(2000));
    EXPECT_EQ(side.peer.tcpros.keep_alive, milliseconds(3000));
    EXPECT_EQ(side.peer.tcpros.retry_first, milliseconds(500));
    EXPECT_EQ(side.peer.tcpros.retry_last, milliseconds(4000));
    EXPECT_EQ(side.peer.tcpros.links, 10U);
    EXPECT_EQ(side.peer.tcpros.message_bytes, 1000000U);
    EXPECT_EQ(side.peer.tcpros.header_bytes, 2000U);
    EXPECT_EQ(side.peer.tcpros.read_at_once, 8192U);
    EXPECT_EQ(side.peer.rpc.connections, 20U);
    EXPECT_EQ(side.peer.rpc.body_bytes, 3000U);
    EXPECT_EQ(side.peer.rpc.idle, milliseconds(5000));
    EXPECT_EQ(side.peer.rpc.request, milliseconds(6000));
  }
  EXPECT_EQ(bridge.poll_period_s, 0.5);
  EXPECT_EQ(bridge.service_timeout_s, 7.0);
  EXPECT_EQ(bridge.schema_patience_s, 1.5);
  EXPECT_EQ(params.shut_down_patience_s, 0.5);
  EXPECT_EQ(bridge.topics.allow, std::vector<std::string>{"/a.*"});
  EXPECT_EQ(bridge.topics.deny, (std::vector<std::string>{"/a/b", "/a/c"}));
  EXPECT_TRUE(bridge.services.allow.empty());
  EXPECT_EQ(bridge.services.deny, (std::vector<std::string>{"/s", "/translator/.*"})) << "and our own";
  ASSERT_EQ(bridge.profiles.size(), 2U);
  const auto& profile = bridge.profiles[0];
  EXPECT_EQ(profile.pattern, "/x") << "ours before the common ones";
  EXPECT_EQ(profile.directions, Directions::kRobotToWorkstation);
  EXPECT_EQ(profile.queue, 3U);
  EXPECT_EQ(profile.max_rate_hz, 5.0);
  EXPECT_EQ(profile.max_age_s, 0.5);
  EXPECT_EQ(profile.priority, Priority::kBulk);
  EXPECT_FALSE(profile.tcp_nodelay);
  EXPECT_FALSE(profile.lazy);
  EXPECT_EQ(profile.frame_slash, translate::PlanOptions::Slash::kStrip);
  EXPECT_EQ(bridge.profiles[1].frame_slash, translate::PlanOptions::Slash::kAdd);
  EXPECT_EQ(bridge.params_robot_to_workstation, std::vector<std::string>{"/robot_description"});
  EXPECT_EQ(bridge.params_workstation_to_robot, (std::vector<std::string>{"/tuning", "/more"}));
  EXPECT_TRUE(bridge.clock);
  EXPECT_EQ(bridge.clock_direction, Directions::kWorkstationToRobot);
  EXPECT_FALSE(bridge.rosout);
  EXPECT_EQ(bridge.rosout_min_level, 8);
  EXPECT_TRUE(bridge.clocks.shift_stamps);
  EXPECT_EQ(bridge.clocks.reference_topics, std::vector<std::string>{"/js"});
  EXPECT_EQ(bridge.clocks.ntp_server, "robot.local");
  EXPECT_EQ(bridge.clocks.ntp_port, 1123);
  EXPECT_EQ(bridge.clocks.window_s, 3.0);
  EXPECT_EQ(bridge.clocks.report_above_s, 0.5);
  EXPECT_FALSE(params.definitions.shipped);
  EXPECT_FALSE(params.definitions.installed);
  ASSERT_EQ(params.definitions.folders.size(), 1U);
  EXPECT_EQ(params.definitions.folders[0].folder, "/f");
  EXPECT_EQ(params.definitions.folders[0].set, "mine");
  EXPECT_EQ(params.definitions.folders[0].fallback, "indigo");
  EXPECT_FALSE(params.rules.shipped);
  EXPECT_EQ(params.rules.files, std::vector<std::filesystem::path>{"/r.yaml"});
  EXPECT_EQ(params.diagnostics.period_s, 2.0);
  EXPECT_EQ(params.diagnostics.topic_period_s, 8.0);
  EXPECT_EQ(params.diagnostics.max_items, 5);
}

TEST_F(TranslatorParamsTest, HomeIsTheNodesOwnMasterAndAddress) {
  const auto home = loaded().bridge.sides[1].peer;
  EXPECT_EQ(home.master_uri, ros::master::getURI());
  const char* hostname = std::getenv("ROS_HOSTNAME");
  const char* ip = std::getenv("ROS_IP");
  EXPECT_EQ(home.advertised_host, hostname != nullptr ? hostname : ip != nullptr ? ip : "");
  EXPECT_EQ(loaded().bridge.sides[0].peer.advertised_host, "") << "the robot side is another network";
}

TEST_F(TranslatorParamsTest, WhatMustBeSetIsNamedWithTheRemedy) {
  (void)ros::param::del(kNs);
  expect_problems({"/robot/master_uri is not set: the robot's master",
                   "/topics/allow is not set: load config/translator.yaml", "/services/allow is not set"});
}

TEST_F(TranslatorParamsTest, TheBridgeNeedsAnotherNameThanTheNode) {
  set_yaml("{workstation: {name: /translator}, robot: {name: /translator}}");
  const auto params = load();
  ASSERT_FALSE(params);
  EXPECT_NE(params.error().message.find("/workstation/name: '/translator' is the name of this ROS node"),
            std::string::npos);
  EXPECT_EQ(params.error().message.find("/robot/name"), std::string::npos)
      << "at the other master it is free";
}

TEST_F(TranslatorParamsTest, OneMasterIsNotTwo) {
  set_yaml("{robot: {master_uri: '" + ros::master::getURI() + "'}}");
  expect_problems({"robot/master_uri and workstation/master_uri are the same master"});
}

TEST_F(TranslatorParamsTest, EveryProblemIsReportedAtOnce) {
  set_yaml(R"(
colour: red
robot: {master_uri: robot, name: no slash, hosts: ['robot.local 10.0.0.2', '10.0.0.2'], master_period_s: 0, port: 1}
workstation: 5
poll_period_s: soon
topics: {allow: ['(']}
services: {allow: everything}
profiles: [{pattern: '*', queue: 0, directions: up, speed: 3, lazy: 7}, {queue: 2}, 5]
common_profiles: 7
parameters: {robot_to_workstation: [robot_description, /]}
clock: {direction: both}
rosout: {min_level: loud}
clocks: {shift_stamps: true, ntp_port: 70000}
connections: {max_links: 0}
definitions: {folders: [{folder: /f}, {set: a, path: /g}]}
rules: {files: 3}
diagnostics: {max_items: -1}
)");
  expect_problems({"/colour is not a parameter",
                   "/robot/master_uri: ",
                   "/robot/name: 'no slash' is not an absolute node name",
                   "/robot/hosts: 'robot.local 10.0.0.2' must be an address and its names",
                   "/robot/hosts: '10.0.0.2' must be an address",
                   "/robot/master_period_s = 0 is out of its range",
                   "/robot/port is not a parameter",
                   "/workstation must be a group of parameters",
                   "/poll_period_s must be a number, but is 'soon'",
                   "/topics/allow: '('",
                   "/services/allow must be a list of texts",
                   "/profiles: '*'",
                   "/profiles[0]/queue: 0 is out of its range [1, 100000]",
                   "/profiles[0]/directions: 'up' is unknown: use one of both, robot_to_workstation, "
                   "workstation_to_robot",
                   "/profiles[0]/speed: is not a key of a profile",
                   "/profiles[0]/lazy has a value of a wrong type",
                   "/profiles: a profile has no pattern",
                   "/profiles[2] must be a group of keys and values",
                   "/common_profiles must be a list",
                   "'robot_description' is not a prefix",
                   "'/' is not a prefix",
                   "/clock/direction: 'both' is unknown",
                   "/rosout/min_level: 'loud' is unknown: use one of debug",
                   "/clocks/shift_stamps needs a measurement",
                   "/clocks/ntp_port = 70000 is out of its range",
                   "/connections/max_links = 0 is out of its range",
                   "/definitions/folders: an entry needs",
                   "/definitions/folders[1]/path: is not a key of a folder",
                   "/rules/files must be a list of texts",
                   "/diagnostics/max_items = -1 is out of its range"});
}

}  // namespace
}  // namespace extperfc::ros_test
