// A bridge's status as diagnostics and as text.
#include <chrono>

#include <gtest/gtest.h>

#include "ros/translate/bridge_diagnostics.hpp"

namespace extperfc::ros_translate {
namespace {

using diagnostic_msgs::DiagnosticStatus;
using translate::BridgeStatus;
using translate::ServiceStatus;
using translate::Side;
using translate::TopicStatus;

std::string value(const DiagnosticStatus& status, const std::string& key) {
  for (const auto& pair : status.values)
    if (pair.key == key) return pair.value;
  return "(none)";
}

TopicStatus joint_states() {
  TopicStatus topic;
  topic.topic = "/robot/joint_states";
  topic.from = Side::kRobot;
  topic.from_type = "sensor_msgs/JointState";
  topic.from_md5 = "3066dcd76a6cfaef579bd0f34173e9fd";
  topic.to = {{"sensor_msgs/JointState", "3066dcd76a6cfaef579bd0f34173e9fd", "pass", 2}};
  topic.publishers = 1;
  topic.messages = 500;
  topic.bytes = 123456;
  topic.dropped = 3;
  topic.rate_hz = 99.96;
  topic.latency_mean_s = 0.0001234;
  topic.latency_max_s = 0.0025;
  return topic;
}

ServiceStatus ik() {
  ServiceStatus service;
  service.service = "/ik";
  service.from = Side::kRobot;
  service.type = "baxter_core_msgs/SolvePositionIK";
  service.md5 = "2711f0a9b3a8b5e2f4f6b7a8c9d0e1f2";
  service.plan = "pass";
  service.calls = 7;
  service.failed = 1;
  service.latency_mean_s = 0.0125;
  return service;
}

BridgeStatus healthy() {
  BridgeStatus status;
  status.sides[0] = {"http://robot:11311", "http://ours:5000", "", true, 2, 1, 1};
  status.sides[1] = {"http://home:11311", "http://ours:5001", "", true, 0, 0, 0};
  status.topics = {joint_states()};
  status.services = {ik()};
  status.params = 4;
  status.clock = {true, 0.0123456, "ntp robot", 3.25, ""};
  return status;
}

ReportParams params() {
  ReportParams params;
  params.node = "translator";
  return params;
}

TEST(LinkStatus, ShowsBothMastersAndTheClock) {
  const auto link = link_status(healthy(), params());
  EXPECT_EQ(link.name, "translator: link");
  EXPECT_EQ(link.hardware_id, "http://robot:11311");
  EXPECT_EQ(link.level, DiagnosticStatus::OK);
  EXPECT_EQ(link.message, "both masters answer");
  EXPECT_EQ(value(link, "robot side master"), "http://robot:11311");
  EXPECT_EQ(value(link, "robot side reachable"), "yes");
  EXPECT_EQ(value(link, "robot side restarts"), "2");
  EXPECT_EQ(value(link, "workstation side our address"), "http://ours:5001");
  EXPECT_EQ(value(link, "clock offset [s]"), "0.012346");
  EXPECT_EQ(value(link, "clock source"), "ntp robot");
  EXPECT_EQ(value(link, "clock age [s]"), "3.2");
  EXPECT_EQ(value(link, "topics and services"), "2");
  EXPECT_EQ(value(link, "with a problem"), "0");
  EXPECT_EQ(value(link, "bridged parameters"), "4");
}

TEST(LinkStatus, AMasterThatIsAwayIsAnError) {
  auto status = healthy();
  status.sides[0].reachable = false;
  status.sides[0].problem = "connection refused";
  status.clock.offset_s = 5.0;
  const auto link = link_status(status, params());
  EXPECT_EQ(link.level, DiagnosticStatus::ERROR);
  EXPECT_EQ(link.message, "robot side master http://robot:11311 is not reachable: connection refused")
      << "a warning does not hide it";
  status.sides[1].reachable = false;
  EXPECT_EQ(link_status(status, params()).message,
            "robot side master http://robot:11311 is not reachable: connection refused; "
            "workstation side master http://home:11311 is not reachable");
}

TEST(LinkStatus, ClocksThatDifferAreAWarningUnlessStampsAreShifted) {
  auto status = healthy();
  for (const double offset_s : {-2.5, 2.5}) {
    status.clock.offset_s = offset_s;
    auto some = params();
    EXPECT_EQ(link_status(status, some).level, DiagnosticStatus::WARN);
    EXPECT_NE(link_status(status, some).message.find(offset_s > 0 ? "2.500 s ahead" : "2.500 s behind"),
              std::string::npos);
    some.shift_stamps = true;
    EXPECT_EQ(link_status(status, some).level, DiagnosticStatus::OK);
    some.shift_stamps = false;
    some.offset_warn_s = 3.0;
    EXPECT_EQ(link_status(status, some).level, DiagnosticStatus::OK);
  }
}

TEST(LinkStatus, AnUnknownClockMattersOnlyWhenStampsAreShifted) {
  auto status = healthy();
  status.clock = {};
  auto some = params();
  EXPECT_EQ(link_status(status, some).level, DiagnosticStatus::OK);
  EXPECT_EQ(value(link_status(status, some), "clock offset [s]"), "not known");
  some.shift_stamps = true;
  EXPECT_EQ(link_status(status, some).level, DiagnosticStatus::WARN);
}

TEST(TopicStatusReport, ShowsWhatAUserAsksFor) {
  auto topic = joint_states();
  topic.to.push_back({"sensor_msgs/JointState", "0123456789abcdef0123456789abcdef", "convert", 1});
  topic.action = "/arm";
  const auto report = topic_status(topic, params());
  EXPECT_EQ(report.name, "translator: topic /robot/joint_states, robot to workstation");
  EXPECT_EQ(report.level, DiagnosticStatus::OK);
  EXPECT_EQ(report.message, "convert, pass");
  EXPECT_EQ(value(report, "from"), "sensor_msgs/JointState 3066dcd7");
  EXPECT_EQ(value(report, "to sensor_msgs/JointState 3066dcd7"), "pass, subscribers: 2");
  EXPECT_EQ(value(report, "to sensor_msgs/JointState 01234567"), "convert, subscribers: 1");
  EXPECT_EQ(value(report, "rate [Hz]"), "100.0");
  EXPECT_EQ(value(report, "latency mean [ms]"), "0.123");
  EXPECT_EQ(value(report, "latency max [ms]"), "2.500");
  EXPECT_EQ(value(report, "messages"), "500");
  EXPECT_EQ(value(report, "dropped"), "3");
  EXPECT_EQ(value(report, "failed"), "0");
  EXPECT_EQ(value(report, "action"), "/arm");
}

TEST(TopicStatusReport, ATopicWithoutAPlanIsAWarning) {
  auto topic = joint_states();
  topic.to.front().plan = "no field effort";
  const auto report = topic_status(topic, params());
  EXPECT_EQ(report.level, DiagnosticStatus::WARN);
  EXPECT_NE(report.message.find("no plan to sensor_msgs/JointState 3066dcd7: no field effort"),
            std::string::npos)
      << report.message;
  topic.publishers = 0;
  EXPECT_EQ(topic_status(topic, params()).level, DiagnosticStatus::OK)
      << "no publisher: there is nothing to plan";
  topic.problem = "a message was damaged";
  EXPECT_EQ(topic_status(topic, params()).message, "a message was damaged");
}

TEST(TopicStatusReport, WithoutSubscribersIsIdle) {
  auto topic = joint_states();
  topic.to.clear();
  topic.from_md5.clear();
  EXPECT_EQ(topic_status(topic, params()).message, "idle");
  EXPECT_EQ(value(topic_status(topic, params()), "from"), "sensor_msgs/JointState ?");
}

TEST(ServiceStatusReport, ShowsServerCallsAndProblem) {
  auto service = ik();
  auto report = service_status(service, params());
  EXPECT_EQ(report.name, "translator: service /ik");
  EXPECT_EQ(report.level, DiagnosticStatus::OK);
  EXPECT_EQ(value(report, "server"), "robot side");
  EXPECT_EQ(value(report, "type"), "baxter_core_msgs/SolvePositionIK 2711f0a9");
  EXPECT_EQ(value(report, "calls"), "7");
  EXPECT_EQ(value(report, "failed"), "1");
  EXPECT_EQ(value(report, "latency mean [ms]"), "12.500");
  service.plan = "request: no definition";
  EXPECT_EQ(service_status(service, params()).level, DiagnosticStatus::WARN);
  service.plan.clear();
  EXPECT_EQ(service_status(service, params()).message, "idle");
}

/// `count` topics, of which every `broken_of`-th has a problem.
BridgeStatus many(std::size_t count, std::size_t broken_of) {
  auto status = healthy();
  status.topics.assign(count, joint_states());
  for (std::size_t i = 0; i < count; ++i) {
    status.topics[i].topic = "/topic_" + std::to_string(i);
    if (i % broken_of == broken_of - 1) status.topics[i].problem = "broken";
  }
  return status;
}

TEST(Report, HasTheLinkAloneOrEverything) {
  const ros::Time stamp(12, 34);
  const auto link = to_diagnostics(healthy(), params(), stamp, false);
  EXPECT_EQ(link.header.stamp, stamp);
  EXPECT_EQ(link.status.size(), 1U);
  EXPECT_EQ(to_diagnostics(healthy(), params(), stamp, true).status.size(), 3U);
}

TEST(Report, IsBoundedWithProblemsFirst) {
  auto some = params();
  some.max_items = 20;
  auto status = many(500, 50);
  status.services[0].problem = "its definition is unknown";
  const auto report = to_diagnostics(status, some, ros::Time(1), true);
  ASSERT_EQ(report.status.size(), 21U);
  EXPECT_EQ(report.status[0].level, DiagnosticStatus::WARN);
  EXPECT_EQ(report.status[0].message, "11 topics or services have a problem");
  EXPECT_EQ(value(report.status[0], "not shown one by one"), "481");
  for (std::size_t i = 1; i <= 11; ++i) EXPECT_EQ(report.status[i].level, DiagnosticStatus::WARN) << i;
  for (std::size_t i = 12; i < 21; ++i) EXPECT_EQ(report.status[i].level, DiagnosticStatus::OK) << i;
  EXPECT_EQ(report.status[1].name, "translator: topic /topic_49, robot to workstation");
  EXPECT_EQ(report.status[12].name, "translator: topic /topic_0, robot to workstation")
      << "otherwise by name";
}

TEST(Report, ManyTopicsCostLittle) {
  const auto status = many(500, 50);
  auto some = params();
  some.max_items = 500;
  const auto begin = std::chrono::steady_clock::now();
  const auto report = to_diagnostics(status, some, ros::Time(1), true);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_EQ(report.status.size(), 501U);
  RecordProperty("took_us", static_cast<int>(1e6 * took.count()));
  std::printf("500 topics: %.2f ms, %u bytes\n", 1e3 * took.count(),
              ros::serialization::serializationLength(report));
}

TEST(Text, HasALineForEverything) {
  auto status = many(3, 2);
  const auto text = to_text(status, params());
  for (const char* part :
       {"link: ", "robot side master: http://robot:11311", "/topic_0 [sensor_msgs/JointState 3066dcd7]",
        "100.0 Hz", "PROBLEM: broken", "/ik [baxter_core_msgs/SolvePositionIK 2711f0a9]"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nis not in\n" << text;
}

TEST(Text, SaysOfStampsWhatIsDoneWithThem) {
  auto status = healthy();
  status.clock.offset_s = 3.0;
  auto some = params();
  auto text = to_text(status, some);
  EXPECT_NE(text.find("stamps are not shifted"), std::string::npos) << text;
  EXPECT_NE(text.find("stamps: not shifted\n"), std::string::npos) << text;
  some.shift_stamps = true;
  text = to_text(status, some);
  EXPECT_EQ(text.find("not shifted"), std::string::npos) << text;
  EXPECT_NE(text.find("stamps: shifted\n"), std::string::npos) << text;
}

TEST(Text, ShowsEverythingOneByOne) {
  auto some = params();
  some.max_items = 1;
  const auto text = to_text(many(30, 100), some);
  EXPECT_NE(text.find("not shown one by one: 0\n"), std::string::npos) << text;
}

TEST(Report, OneIsNoPlural) {
  auto status = healthy();
  status.topics[0].problem = "broken";
  EXPECT_EQ(link_status(status, params()).message, "1 topic or service has a problem");
}

TEST(LinkStatus, AReferenceTopicThatLosesMessagesIsAWarning) {
  auto status = healthy();
  status.clock.problem = "clock: /joint_states: the connection ends again and again";
  EXPECT_EQ(link_status(status, params()).level, DiagnosticStatus::WARN);
  EXPECT_EQ(link_status(status, params()).message, status.clock.problem);
}

}  // namespace
}  // namespace extperfc::ros_translate
