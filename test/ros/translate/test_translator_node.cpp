// The translator's node between this test's master (the workstation's) and a second one (the robot's).
#include <algorithm>
#include <csignal>
#include <fstream>
#include <functional>
#include <memory>

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <ros/master.h>
#include <ros/service.h>
#include <std_msgs/String.h>
#include <std_srvs/Trigger.h>
#include <sys/socket.h>
#include <unistd.h>

#include "test/ros/support/child_process.hpp"
#include "test/ros/support/watch.hpp"
#include "test/ros/translate/translator_test.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::ros_test {
namespace {

/// A port that is free now.
std::uint16_t free_port() {
  const int descriptor = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  (void)bind(descriptor, reinterpret_cast<sockaddr*>(&address), size);
  (void)getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size);
  close(descriptor);
  return ntohs(address.sin_port);
}

bool node_is_listed(const std::string& name) {
  ros::V_string nodes;
  return ros::master::getNodes(nodes) && std::find(nodes.begin(), nodes.end(), name) != nodes.end();
}

/// The status of one name.
class StatusWatch {
 public:
  explicit StatusWatch(std::string name) : name_(std::move(name)) {}

  [[nodiscard]] Report latest() const {
    const auto arrays = inbox_.all();
    for (auto array = arrays.rbegin(); array != arrays.rend(); ++array)
      for (const auto& status : (*array)->status)
        if (status.name == name_) return Report(status);
    return {};
  }
  [[nodiscard]] bool wait(const std::function<bool(const Report&)>& condition) const {
    return wait_for([&] { return condition(latest()); });
  }

 private:
  std::string name_;
  Inbox<diagnostic_msgs::DiagnosticArray> inbox_{"/diagnostics"};
};

class TranslatorNodeTest : public testing::Test {
 protected:
  TranslatorNodeTest() {
    (void)ros::param::del("/translator");
    set_from_file("/translator", "config/translator.yaml");
    ros::param::set("/translator/robot/master_uri", robot_uri_);
    ros::param::set("/translator/diagnostics/period_s", 0.1);
    ros::param::set("/translator/diagnostics/topic_period_s", 0.2);
    ros::param::set("/translator/poll_period_s", 0.1);
    ros::param::set("/translator/robot/master_period_s", 0.2);
  }

  void start_robot_master() {
    master_ = std::make_unique<ChildProcess>(std::vector<std::string>{
        "env", "ROS_MASTER_URI=" + robot_uri_, "rosmaster", "--core", "-p", std::to_string(port_)});
  }
  /// The shell becomes the node, so the number it wrote is the node's.
  void start_node() {
    node_ = std::make_unique<ChildProcess>(std::vector<std::string>{
        "sh", "-c",
        "echo $$ >" + pid_file_ +
            "; exec \"$(catkin_find --first-only extperfc translator)\" __name:=translator >" + output_file_ +
            " 2>&1"});
  }
  [[nodiscard]] pid_t node_pid() const {
    pid_t pid = -1;
    std::ifstream(pid_file_) >> pid;
    return pid;
  }
  [[nodiscard]] std::unique_ptr<ChildProcess> at_robot_master(std::vector<std::string> command) const {
    command.insert(command.begin(), {"env", "ROS_MASTER_URI=" + robot_uri_});
    return std::make_unique<ChildProcess>(command);
  }
  [[nodiscard]] bool link_is(int level, const std::string& text) const {
    return diagnostics_.wait([&](const Report& report) {
      return report.level() == level && report.message().find(text) != std::string::npos;
    });
  }
  [[nodiscard]] static std_srvs::Trigger call(const std::string& service) {
    std_srvs::Trigger trigger;
    EXPECT_TRUE(ros::service::waitForService(service, ros::Duration(kPatienceS)));
    EXPECT_TRUE(ros::service::call(service, trigger)) << service;
    return trigger;
  }

  TemporaryFolder folder_;
  const std::string pid_file_ = (folder_.path() / "pid").string();
  const std::string output_file_ = (folder_.path() / "output").string();
  const std::uint16_t port_ = free_port();
  const std::string robot_uri_ = "http://127.0.0.1:" + std::to_string(port_);
  StatusWatch diagnostics_{"translator: link"};
  LogWatch log_;
  std::unique_ptr<ChildProcess> master_, node_;
};

TEST_F(TranslatorNodeTest, JoinsTwoMastersAndSaysSo) {
  start_robot_master();
  start_node();
  ASSERT_TRUE(link_is(diagnostic_msgs::DiagnosticStatus::OK, "both masters answer")) << log_.text();

  const auto publisher =
      at_robot_master({"rostopic", "pub", "-r", "20", "/from_robot", "std_msgs/String", "hello"});
  Inbox<std_msgs::String> inbox("/from_robot");
  ASSERT_TRUE(inbox.wait_for_count(3)) << log_.text();
  EXPECT_EQ(inbox.all().front()->data, "hello");
  const StatusWatch topic("translator: topic /from_robot, robot to workstation");
  EXPECT_TRUE(topic.wait([](const Report& report) {
    return report.level() == 0 && report.message() == "pass" && report.number("messages") > 0;
  })) << topic.latest().message();

  ros::NodeHandle handle;
  auto back = handle.advertise<std_msgs::String>("/from_workstation", 1, true);
  std_msgs::String message;
  message.data = "and back";
  back.publish(message);
  EXPECT_EQ(at_robot_master({"rostopic", "echo", "-n", "1", "/from_workstation"})->wait_for_end(), 0)
      << "it came, latched";

  const auto status = call("/translator/status");
  EXPECT_TRUE(status.response.success);
  EXPECT_NE(status.response.message.find("/from_robot [std_msgs/String 992ce8a1]"), std::string::npos)
      << status.response.message;
}

TEST_F(TranslatorNodeTest, RulesAreReadAgainOrStayWhenTheyDoNotFit) {
  const auto rules = folder_.path() / "rules";
  std::filesystem::create_directory(rules);
  ros::param::set("/translator/rules/files", std::vector<std::string>{rules.string()});
  start_robot_master();
  start_node();
  EXPECT_TRUE(call("/translator/reload_rules").response.success) << log_.text();
  std::ofstream(rules / "bad.yaml")
      << "rules:\n  - type: no_such/Type\n    from: {md5: a}\n    to: {md5: b}\n";
  const auto refused = call("/translator/reload_rules");
  EXPECT_FALSE(refused.response.success);
  EXPECT_NE(refused.response.message.find("keeping the previous rules: " + (rules / "bad.yaml").string()),
            std::string::npos)
      << refused.response.message;
}

TEST_F(TranslatorNodeTest, AnUnreachableMasterIsReportedAndAwaited) {
  start_node();
  ASSERT_TRUE(link_is(diagnostic_msgs::DiagnosticStatus::ERROR, "robot side master " + robot_uri_))
      << log_.text();
  start_robot_master();
  EXPECT_TRUE(link_is(diagnostic_msgs::DiagnosticStatus::OK, "both masters answer"))
      << diagnostics_.latest().message();
  master_.reset();
  EXPECT_TRUE(link_is(diagnostic_msgs::DiagnosticStatus::ERROR, "robot side master " + robot_uri_));
}

TEST_F(TranslatorNodeTest, AnInterruptEndsItInOrder) {
  for (const bool with_robot_master : {true, false}) {
    if (with_robot_master) start_robot_master();
    start_node();
    (void)call("/translator/status");
    ASSERT_TRUE(wait_for([] { return node_is_listed("/translator"); }));
    if (!with_robot_master) master_.reset();
    ASSERT_EQ(kill(node_pid(), SIGINT), 0);
    EXPECT_EQ(node_->wait_for_end(), 0);
    EXPECT_FALSE(node_is_listed("/extperfc_translator"));
    EXPECT_FALSE(node_is_listed("/translator"));
  }
}

TEST_F(TranslatorNodeTest, RefusesToStartWithEveryReason) {
  ros::param::del("/translator/robot/master_uri");
  ros::param::set("/translator/workstation/name", "/translator");
  ros::param::set("/translator/typo", 1);
  start_node();
  EXPECT_EQ(node_->wait_for_end(), 1);
  std::ifstream file(output_file_);
  const std::string output((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  for (const char* text : {"/translator/robot/master_uri is not set", "is the name of this ROS node",
                           "/translator/typo is not a parameter"})
    EXPECT_NE(output.find(text), std::string::npos) << text << "\n" << output;
}

}  // namespace
}  // namespace extperfc::ros_test
