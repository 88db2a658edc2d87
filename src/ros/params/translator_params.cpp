#include "ros/params/translator_params.hpp"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <map>
#include <regex>
#include <sstream>
#include <utility>

#include <arpa/inet.h>
#include <ros/master.h>

#include "ros/params/group_reader.hpp"
#include "ros/params/list_reader.hpp"

namespace extperfc::ros_params {

namespace {

using std::chrono::milliseconds;
using translate::BridgeParams;
using translate::Directions;
using translate::PlanOptions;
using translate::Priority;
using translate::Side;
using translate::SideParams;
using translate::TopicProfile;
using Strings = std::vector<std::string>;

constexpr double kMaxBytes = 2147483647.0;  // of a 32-bit parameter

const NamedValues<Directions>& directions() {
  static const NamedValues<Directions> values{{"both", Directions::kBoth},
                                              {"robot_to_workstation", Directions::kRobotToWorkstation},
                                              {"workstation_to_robot", Directions::kWorkstationToRobot}};
  return values;
}
const NamedValues<Priority>& priorities() {
  static const NamedValues<Priority> values{
      {"control", Priority::kControl}, {"normal", Priority::kNormal}, {"bulk", Priority::kBulk}};
  return values;
}
const NamedValues<PlanOptions::Slash>& slashes() {
  static const NamedValues<PlanOptions::Slash> values{{"keep", PlanOptions::Slash::kKeep},
                                                      {"strip", PlanOptions::Slash::kStrip},
                                                      {"add", PlanOptions::Slash::kAdd}};
  return values;
}
/// rosgraph_msgs/Log's levels.
const NamedValues<std::uint8_t>& levels() {
  static const NamedValues<std::uint8_t> values{
      {"debug", 1}, {"info", 2}, {"warn", 4}, {"error", 8}, {"fatal", 16}};
  return values;
}

void read_seconds(ParamReader& reader, const std::string& key, milliseconds& value, Range<double> range_s) {
  double seconds = 1e-3 * static_cast<double>(value.count());
  reader.read(key, seconds, range_s);
  value = milliseconds(std::llround(1e3 * seconds));
}

void read_size(ParamReader& reader, const std::string& key, std::size_t& value, Range<int> range) {
  int number = static_cast<int>(value);
  reader.read(key, number, range);
  value = static_cast<std::size_t>(number);
}

template <typename T>
Result<void> store(T& target, Result<T> value) {
  if (!value) return tl::unexpected(value.error());
  target = *value;
  return {};
}

/// Sets one key of a profile; throws XmlRpc's exception when the value is of a wrong type.
Result<void> set_profile(TopicProfile& profile, const std::string& key, const Entry& entry) {
  if (key == "pattern") return store(profile.pattern, Result<std::string>(entry.text()));
  if (key == "directions") return store(profile.directions, meaning(entry.text(), directions()));
  if (key == "priority") return store(profile.priority, meaning(entry.text(), priorities()));
  if (key == "frame_slash") return store(profile.frame_slash, meaning(entry.text(), slashes()));
  if (key == "tcp_nodelay") return store(profile.tcp_nodelay, Result<bool>(entry.flag()));
  if (key == "lazy") return store(profile.lazy, Result<bool>(entry.flag()));
  if (key == "max_rate_hz") return store(profile.max_rate_hz, entry.number({0.0, 1e5}));
  if (key == "max_age_s") return store(profile.max_age_s, entry.number({0.0, 3600.0}));
  if (key != "queue") return fail(ErrorCode::kInvalidArgument, "is not a key of a profile");
  const auto queue = entry.number({1.0, 100000.0});
  if (!queue) return tl::unexpected(queue.error());
  profile.queue = static_cast<std::size_t>(*queue);
  return {};
}

/// Sets one key of an entry of definitions/folders.
Result<void> set_folder(TranslatorDefinitions::Folder& folder, const std::string& key, const Entry& entry) {
  if (key == "folder")
    folder.folder = entry.text();
  else if (key == "set")
    folder.set = entry.text();
  else if (key == "fallback")
    folder.fallback = entry.text();
  else
    return fail(ErrorCode::kInvalidArgument, "is not a key of a folder");
  return {};
}

void read_profiles(ParamReader& reader, const ros::NodeHandle& handle, const std::string& key,
                   std::vector<TopicProfile>& profiles) {
  for (auto& profile : read_list<TopicProfile>(reader, handle, key, set_profile)) {
    if (profile.pattern.empty())
      reader.complain(handle.resolveName(key) + ": a profile has no pattern: use '.*' for all topics");
    check_expressions(reader, handle.resolveName(key), {profile.pattern});
    profiles.push_back(std::move(profile));
  }
}

void read_filter(ParamReader& reader, const ros::NodeHandle& handle, translate::NameFilter& filter) {
  Strings never;
  read_strings(reader, handle, "allow", filter.allow);
  read_strings(reader, handle, "deny", filter.deny);
  read_strings(reader, handle, "never", never);
  if (!handle.hasParam("allow"))
    reader.complain(handle.resolveName("allow") +
                    " is not set: load config/translator.yaml, or list the names to bridge");
  filter.deny.insert(filter.deny.end(), never.begin(), never.end());
  check_expressions(reader, handle.resolveName("allow"), filter.allow);
  check_expressions(reader, handle.resolveName("deny"), filter.deny);
}

void read_prefixes(ParamReader& reader, const ros::NodeHandle& handle, const std::string& key,
                   Strings& prefixes) {
  read_strings(reader, handle, key, prefixes);
  for (const auto& prefix : prefixes)
    if (prefix.size() < 2 || prefix.front() != '/')
      reader.complain(handle.resolveName(key) + ": '" + prefix +
                      "' is not a prefix: start with a slash and name a namespace or a parameter");
}

bool is_address(const std::string& text) {
  in6_addr ignored{};
  return inet_pton(AF_INET, text.c_str(), &ignored) == 1 || inet_pton(AF_INET6, text.c_str(), &ignored) == 1;
}

/// Lines as in /etc/hosts: an address and its names.
void read_hosts(ParamReader& reader, const ros::NodeHandle& handle,
                std::map<std::string, std::string>& hosts) {
  Strings lines;
  read_strings(reader, handle, "hosts", lines);
  for (const auto& line : lines) {
    std::istringstream tokens(line);
    std::string address;
    std::string name;
    tokens >> address;
    std::size_t names = 0;
    for (; tokens >> name; ++names) hosts[name] = address;
    if (names == 0 || !is_address(address))
      reader.complain(handle.resolveName("hosts") + ": '" + line +
                      "' must be an address and its names, as in /etc/hosts");
  }
}

void check_name(ParamReader& reader, const ros::NodeHandle& handle, const std::string& name) {
  static const std::regex valid("(/[A-Za-z][A-Za-z0-9_]*)+");
  if (!std::regex_match(name, valid))
    reader.complain(handle.resolveName("name") + ": '" + name +
                    "' is not an absolute node name such as /extperfc_translator");
}

void check_uri(ParamReader& reader, const ros::NodeHandle& handle, const std::string& uri) {
  if (uri.empty()) return;
  if (const auto parsed = translate::parse_uri(uri); !parsed)
    reader.complain(handle.resolveName("master_uri") + ": " + parsed.error().message);
}

/// The home side's own address, as roscpp takes it from the environment.
std::string host_of_environment() {
  for (const char* name : {"ROS_HOSTNAME", "ROS_IP"})
    if (const char* value = std::getenv(name); value != nullptr && *value != '\0') return value;
  return {};
}

void read_side(ParamReader& reader, const ros::NodeHandle& handle, SideParams& side) {
  reader.read("name", side.peer.name);
  reader.read("advertised_host", side.peer.advertised_host);
  reader.read("bind_address", side.peer.bind_address);
  read_hosts(reader, handle, side.peer.hosts);
  read_strings(reader, handle, "definitions", side.definitions);
  read_seconds(reader, "master_period_s", side.peer.master_period, {0.1, 60.0});
  read_seconds(reader, "master_timeout_s", side.peer.master_timeout, {0.1, 60.0});
  read_seconds(reader, "node_timeout_s", side.peer.node_timeout, {0.1, 60.0});
  check_name(reader, handle, side.peer.name);
  side.peer.hosts_remedy = "add it to the parameter " + handle.resolveName("hosts");
  side.peer.advertised_host_remedy = "set the parameter " + handle.resolveName("advertised_host");
}

void read_robot(ParamReader& reader, const ros::NodeHandle& handle, SideParams& side) {
  reader.require("master_uri", side.peer.master_uri,
                 "the robot's master, e.g. http://<serial>.local:11311 (launch argument robot_master_uri)");
  check_uri(reader, handle, side.peer.master_uri);
  read_side(reader, handle, side);
}

void read_workstation(ParamReader& reader, const ros::NodeHandle& handle, SideParams& side,
                      const std::string& node_name) {
  reader.read("master_uri", side.peer.master_uri);
  if (side.peer.master_uri.empty()) side.peer.master_uri = ros::master::getURI();
  check_uri(reader, handle, side.peer.master_uri);
  read_side(reader, handle, side);
  if (side.peer.advertised_host.empty()) side.peer.advertised_host = host_of_environment();
  if (side.peer.name == node_name)
    reader.complain(
        handle.resolveName("name") + ": '" + node_name +
        "' is the name of this ROS node: the master would shut one of the two down; use another name");
}

void read_connections(ParamReader& reader, std::array<SideParams, 2>& sides) {
  auto tcpros = sides[0].peer.tcpros;
  auto rpc = sides[0].peer.rpc;
  constexpr int kMax = static_cast<int>(kMaxBytes);
  read_seconds(reader, "handshake_s", tcpros.handshake, {0.1, 60.0});
  read_seconds(reader, "unacknowledged_s", tcpros.unacknowledged, {0.1, 600.0});
  read_seconds(reader, "keep_alive_s", tcpros.keep_alive, {1.0, 7200.0});
  read_seconds(reader, "retry_first_s", tcpros.retry_first, {0.01, 60.0});
  read_seconds(reader, "retry_last_s", tcpros.retry_last, {0.01, 600.0});
  read_size(reader, "max_links", tcpros.links, {1, 100000});
  read_size(reader, "max_message_bytes", tcpros.message_bytes, {1000, kMax});
  read_size(reader, "max_header_bytes", tcpros.header_bytes, {1000, kMax});
  read_size(reader, "read_at_once_bytes", tcpros.read_at_once, {4096, 1 << 30});
  read_size(reader, "rpc_max_connections", rpc.connections, {4, 100000});
  read_size(reader, "rpc_max_body_bytes", rpc.body_bytes, {1000, kMax});
  read_seconds(reader, "rpc_idle_s", rpc.idle, {1.0, 7200.0});
  read_seconds(reader, "rpc_request_s", rpc.request, {0.1, 600.0});
  for (auto& side : sides) {
    side.peer.tcpros = tcpros;
    side.peer.rpc = rpc;
  }
}

void read_clocks(ParamReader& reader, const ros::NodeHandle& handle, translate::ClockParams& clocks) {
  int port = clocks.ntp_port;
  reader.read("shift_stamps", clocks.shift_stamps);
  read_strings(reader, handle, "reference_topics", clocks.reference_topics);
  reader.read("ntp_server", clocks.ntp_server);
  reader.read("ntp_port", port, {1, 65535});
  reader.read("window_s", clocks.window_s, {0.1, 3600.0});
  reader.read("report_above_s", clocks.report_above_s, {0.0, 1e6});
  clocks.ntp_port = static_cast<std::uint16_t>(port);
  if (clocks.shift_stamps && clocks.reference_topics.empty() && clocks.ntp_server.empty())
    reader.complain(handle.resolveName("shift_stamps") +
                    " needs a measurement: set reference_topics or ntp_server");
}

void read_definitions(ParamReader& reader, const ros::NodeHandle& handle, TranslatorDefinitions& params) {
  reader.read("shipped", params.shipped);
  reader.read("installed", params.installed);
  params.folders = read_list<TranslatorDefinitions::Folder>(reader, handle, "folders", set_folder);
  for (const auto& folder : params.folders)
    if (folder.folder.empty() || folder.set.empty())
      reader.complain(handle.resolveName("folders") +
                      ": an entry needs 'folder' (with packages) and 'set' (a name for them)");
}

void read_rules(ParamReader& reader, const ros::NodeHandle& handle, TranslatorRules& params) {
  Strings files;
  reader.read("shipped", params.shipped);
  read_strings(reader, handle, "files", files);
  params.files.assign(files.begin(), files.end());
}

void read_diagnostics(ParamReader& reader, TranslatorDiagnostics& params) {
  reader.read("period_s", params.period_s, {0.1, 3600.0});
  reader.read("topic_period_s", params.topic_period_s, {0.1, 3600.0});
  reader.read("max_items", params.max_items, {0, 10000});
}

constexpr std::array<const char*, 12> kGroups{"robot",       "workstation", "topics", "services",
                                              "parameters",  "clock",       "clocks", "rosout",
                                              "connections", "definitions", "rules",  "diagnostics"};

void read_top(ParamReader& reader, const ros::NodeHandle& handle, TranslatorParams& params) {
  for (const char* group : kGroups) reader.accept(group);
  reader.read("poll_period_s", params.bridge.poll_period_s, {0.05, 60.0});
  reader.read("service_timeout_s", params.bridge.service_timeout_s, {0.1, 86400.0});
  reader.read("schema_patience_s", params.bridge.schema_patience_s, {0.0, 60.0});
  reader.read("shut_down_patience_s", params.shut_down_patience_s, {0.0, 60.0});
  read_profiles(reader, handle, "profiles", params.bridge.profiles);
  read_profiles(reader, handle, "common_profiles", params.bridge.profiles);
}

/// The groups of BridgeParams but the two sides.
void read_bridging(GroupReader& groups, BridgeParams& bridge) {
  using Handle = const ros::NodeHandle&;
  groups.group("topics",
               [&](ParamReader& reader, Handle handle) { read_filter(reader, handle, bridge.topics); });
  groups.group("services",
               [&](ParamReader& reader, Handle handle) { read_filter(reader, handle, bridge.services); });
  groups.group("parameters", [&](ParamReader& reader, Handle handle) {
    read_prefixes(reader, handle, "robot_to_workstation", bridge.params_robot_to_workstation);
    read_prefixes(reader, handle, "workstation_to_robot", bridge.params_workstation_to_robot);
  });
  groups.group("clock", [&](ParamReader& reader, Handle handle) {
    static const NamedValues<Directions> one_direction{
        {"robot_to_workstation", Directions::kRobotToWorkstation},
        {"workstation_to_robot", Directions::kWorkstationToRobot}};
    reader.read("bridge", bridge.clock);
    read_named(reader, handle, "direction", bridge.clock_direction, one_direction);
  });
  groups.group("rosout", [&](ParamReader& reader, Handle handle) {
    reader.read("bridge", bridge.rosout);
    read_named(reader, handle, "min_level", bridge.rosout_min_level, levels());
  });
  groups.group("clocks",
               [&](ParamReader& reader, Handle handle) { read_clocks(reader, handle, bridge.clocks); });
}

void check_masters(GroupReader& groups, const std::array<SideParams, 2>& sides) {
  const auto robot_master = translate::parse_uri(sides[0].peer.master_uri);
  const auto workstation_master = translate::parse_uri(sides[1].peer.master_uri);
  if (robot_master && workstation_master && robot_master->host == workstation_master->host &&
      robot_master->port == workstation_master->port)
    groups.complain("robot/master_uri and workstation/master_uri are the same master, " +
                    sides[0].peer.master_uri + ": the translator needs two masters");
}

}  // namespace

Result<TranslatorParams> load_translator_params(const ros::NodeHandle& private_handle,
                                                const std::string& node_name) {
  using Handle = const ros::NodeHandle&;
  TranslatorParams params;
  auto& bridge = params.bridge;
  for (auto& side : bridge.sides) side.peer.name = "/extperfc_translator";
  auto& robot = bridge.sides[static_cast<std::size_t>(Side::kRobot)];
  auto& workstation = bridge.sides[static_cast<std::size_t>(Side::kWorkstation)];
  robot.definitions = {"indigo"};
  workstation.definitions = {"installed", "noetic"};
  GroupReader groups(private_handle);
  groups.group("", [&](ParamReader& reader, Handle handle) { read_top(reader, handle, params); });
  groups.group("connections", [&](ParamReader& reader, Handle) { read_connections(reader, bridge.sides); });
  groups.group("robot", [&](ParamReader& reader, Handle handle) { read_robot(reader, handle, robot); });
  groups.group("workstation", [&](ParamReader& reader, Handle handle) {
    read_workstation(reader, handle, workstation, node_name);
  });
  check_masters(groups, bridge.sides);
  read_bridging(groups, bridge);
  bridge.services.deny.push_back(node_name + "/.*");  // our own are of this side
  groups.group("definitions", [&](ParamReader& reader, Handle handle) {
    read_definitions(reader, handle, params.definitions);
  });
  groups.group("rules",
               [&](ParamReader& reader, Handle handle) { read_rules(reader, handle, params.rules); });
  groups.group("diagnostics",
               [&](ParamReader& reader, Handle) { read_diagnostics(reader, params.diagnostics); });
  if (auto finished = groups.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

}  // namespace extperfc::ros_params
