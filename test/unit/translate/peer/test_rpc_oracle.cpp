#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "extperfc/translate/rpc.hpp"

#include "test/support/temporary_folder.hpp"
#include "test/unit/translate/peer/child_process.hpp"
#include "test/unit/translate/peer/loop_until.hpp"
#include "translate/peer/master_link.hpp"
#include "translate/peer/socket.hpp"

/// Against other implementations: Python's xmlrpc, which rosmaster and rospy use, and rosmaster itself.
namespace extperfc::translate {
namespace {

using namespace std::chrono_literals;

constexpr const char* kPython = "/usr/bin/python3";

const char* const kPythonServer = R"(
import sys
from socketserver import ThreadingMixIn
from xmlrpc.server import SimpleXMLRPCServer, SimpleXMLRPCRequestHandler
class Handler(SimpleXMLRPCRequestHandler):
    protocol_version = 'HTTP/' + sys.argv[1]
class Server(ThreadingMixIn, SimpleXMLRPCServer):
    daemon_threads = True
server = Server(('127.0.0.1', 0), Handler, logRequests=False)
server.register_function(lambda *arguments: list(arguments), 'echo')
server.register_function(lambda value: repr(value), 'show')
print(server.server_address[1], flush=True)
server.serve_forever()
)";

const char* const kPythonClient = R"(
import sys, xmlrpc.client
master = xmlrpc.client.ServerProxy(sys.argv[1])
values = ['', ' ', ' a\n\tb ', '<&>"\'', '\u00e4\u20ac\U0001f916', 'line\rend', 0, -2**31, 2**31 - 1, True, False, 0.1, -1e300,
          float('inf'), [], [[]], {}, {'': 1, 'a b': [1, {'c': 'd'}]}, xmlrpc.client.Binary(bytes(range(256))),
          'x' * 2000000, list(range(1000)), xmlrpc.client.DateTime('20061121T09:30:00')]
for value in values:
    back = master.echo(value)
    assert back == [value] and type(back[0]) == type(value), (value, back)
assert master.echo(*values) == values
try:
    master.fault()
    assert False
except xmlrpc.client.Fault as fault:
    assert 'on purpose' in fault.faultString
print('all equal')
)";

class RpcOracle : public ::testing::Test {
 protected:
  void SetUp() override {
    if (::access(kPython, X_OK) != 0) GTEST_SKIP() << kPython << " is not installed";
  }

  Result<XmlValue> call(const std::string& uri, const std::string& method, const XmlArray& arguments) {
    std::vector<Result<XmlValue>> answers;
    client_.call(uri, method, arguments, 20s,
                 [&](Result<XmlValue> answer) { answers.push_back(std::move(answer)); });
    EXPECT_TRUE(loop_until(
        loop_, [&] { return !answers.empty(); }, 30s));
    return answers.empty() ? fail(ErrorCode::kFailed, "none") : answers[0];
  }

  void compare_with_server(const std::string& version) {
    const ChildProcess python(loop_, {kPython, "-c", kPythonServer, version});
    ASSERT_TRUE(loop_until(
        loop_, [&] { return python.output().find('\n') != std::string::npos; }, 30s))
        << python.output();
    const auto uri = "http://127.0.0.1:" + std::to_string(std::stoi(python.output()));
    const XmlArray values{"",
                          " ",
                          " a\n\tb ",
                          "line\r\nend\r",
                          "<&>]]>",
                          "\xc3\xa4\xf0\x9f\xa4\x96",
                          -5,
                          2147483647,
                          true,
                          0.1,
                          -1e-300,
                          XmlArray{},
                          XmlArray{XmlArray{}},
                          XmlStruct{{"", 1}, {"a b", XmlArray{1.0}}},
                          XmlBinary{std::string("\0\xff\x01", 3)},
                          std::string(1'000'000, '&')};
    for (int round = 0; round < 2; ++round) {
      const auto answer = call(uri, "echo", values);
      ASSERT_TRUE(answer) << answer.error().message;
      EXPECT_EQ(*answer, XmlValue(values));
    }
    const auto shown = call(uri, "show", {" \r\n\x01\xff "});
    ASSERT_TRUE(shown) << "what XML cannot hold does not break the call: " << shown.error().message;
    EXPECT_EQ(*shown, XmlValue("' \\r\\n?? '"));
    const auto unknown = call(uri, "unknown", {});
    ASSERT_FALSE(unknown);
    EXPECT_NE(unknown.error().message.find("not supported"), std::string::npos) << unknown.error().message;
  }

  EventLoop loop_;
  Resolver resolver_{loop_, {}};
  RpcClient client_{loop_, resolver_};
};

TEST_F(RpcOracle, OurClientAndPythonsServerOfHttp11Agree) {
  compare_with_server("1.1");
}
TEST_F(RpcOracle, OurClientAndPythonsServerOfHttp10Agree) {
  compare_with_server("1.0");
}

TEST_F(RpcOracle, PythonsClientAndOurServerAgree) {
  RpcServer server(loop_);
  const auto port = server.open("127.0.0.1", 0, [](const XmlCall& call, const std::string&) -> XmlValue {
    if (call.method == "fault") throw std::runtime_error("on purpose");
    return call.arguments;
  });
  ASSERT_TRUE(port);
  ChildProcess python(loop_,
                      {kPython, "-c", kPythonClient, "http://127.0.0.1:" + std::to_string(*port) + "/"});
  ASSERT_TRUE(loop_until(
      loop_, [&] { return python.ended(); }, 30s));
  EXPECT_EQ(python.output(), "all equal\n");
  EXPECT_EQ(python.wait(), 0);
}

/// Where the shell would find it, or nothing.
std::string find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (::access((folder + '/' + name).c_str(), X_OK) == 0) return folder + '/' + name;
  return {};
}

class RosmasterOracle : public ::testing::Test {
 protected:
  void SetUp() override {
    program_ = find_program("rosmaster");
    if (program_.empty()) GTEST_SKIP() << "rosmaster is not on PATH: only the master of this test was asked";
    ::setenv("ROS_HOME", home_.path().c_str(), 1);
    ::setenv("ROS_LOG_DIR", home_.path().c_str(), 1);
    ::setenv("ROS_IP", "127.0.0.1", 1);
    ::unsetenv("ROS_HOSTNAME");
    port_ = port_of(listen_at("127.0.0.1", 0)->get());
    uri_ = "http://127.0.0.1:" + std::to_string(port_) + "/";
    // "/usr/bin/env python3" in the program shall find the system's.
    ::setenv("PATH", (std::string("/usr/bin:") + std::getenv("PATH")).c_str(), 1);
    start();
  }
  void start() {
    master_ = std::make_unique<ChildProcess>(
        loop_, std::vector<std::string>{program_, "--core", "-p", std::to_string(port_)});
  }

  std::unique_ptr<MasterLink> connect() {
    MasterLink::Params params;
    params.master_uri = uri_;
    params.caller_id = "/translator";
    params.caller_api = "http://127.0.0.1:1/";
    params.period = 50ms;
    return std::make_unique<MasterLink>(loop_, client_, params, MasterLink::Handlers{});
  }
  Result<XmlValue> call(MasterLink& link, const std::string& method, XmlArray arguments) {
    std::vector<Result<XmlValue>> answers;
    link.call(method, std::move(arguments),
              [&](Result<XmlValue> answer) { answers.push_back(std::move(answer)); });
    EXPECT_TRUE(loop_until(loop_, [&] { return !answers.empty(); }));
    return answers.empty() ? fail(ErrorCode::kFailed, "none") : answers[0];
  }
  GraphState graph(MasterLink& link) {
    std::vector<Result<GraphState>> graphs;
    link.graph([&](Result<GraphState> found) { graphs.push_back(std::move(found)); });
    EXPECT_TRUE(loop_until(loop_, [&] { return !graphs.empty(); }));
    EXPECT_TRUE(!graphs.empty() && graphs[0]);
    return !graphs.empty() && graphs[0] ? *graphs[0] : GraphState{};
  }

  TemporaryFolder home_;
  std::string program_, uri_;
  std::uint16_t port_{0};
  EventLoop loop_;
  Resolver resolver_{loop_, {}};
  RpcClient client_{loop_, resolver_};
  std::unique_ptr<ChildProcess> master_;
};

TEST_F(RosmasterOracle, RegistrationsFollowARestartAndGo) {
  const auto link = connect();
  int made = 0;
  const auto count = [&](const Result<XmlValue>& value) {
    EXPECT_TRUE(value) << value.error().message;
    ++made;
  };
  constexpr int kTopics = 100;
  for (int i = 0; i < kTopics; ++i)
    link->keep_publisher("/topic" + std::to_string(i), "std_msgs/String", count);
  const auto again = link->keep_subscriber("/topic0", "*", count);
  link->keep_service("/add", "rosrpc://127.0.0.1:9", count);
  link->keep_param_watch("/robot", count);
  ASSERT_TRUE(loop_until(
      loop_, [&] { return made == kTopics + 3; }, 30s))
      << link->status().problem;
  const auto check = [&] {
    const auto state = graph(*link);
    EXPECT_EQ(state.topics.size(), static_cast<std::size_t>(kTopics));
    EXPECT_EQ(state.topics.at("/topic0").type, "std_msgs/String");
    EXPECT_EQ(state.topics.at("/topic0").subscribers, std::vector<std::string>{"/translator"});
    EXPECT_EQ(state.services.at("/add"), std::vector<std::string>{"/translator"});
  };
  check();
  master_.reset();
  ASSERT_TRUE(loop_until(loop_, [&] { return !link->status().reachable; }));
  start();
  ASSERT_TRUE(loop_until(
      loop_, [&] { return made == 2 * (kTopics + 3); }, 30s))
      << link->status().problem;
  EXPECT_EQ(link->status().restarts, 1U);
  check();
  link->again(again);
  ASSERT_TRUE(loop_until(loop_, [&] { return made == 2 * (kTopics + 3) + 1; }));
  bool ended = false;
  link->shut_down(10s, [&] { ended = true; });
  ASSERT_TRUE(loop_until(loop_, [&] { return ended; }));
  const auto empty = graph(*link);
  EXPECT_TRUE(empty.topics.empty());
  EXPECT_TRUE(empty.services.empty());
}

TEST_F(RosmasterOracle, ParametersPassUnchanged) {
  const auto link = connect();
  ASSERT_TRUE(loop_until(
      loop_, [&] { return link->status().reachable; }, 30s));
  const XmlStruct robot{{"text", " a\n<b>\r\n "},
                        {"blank", "   "},
                        {"number", 0.1},
                        {"list", XmlArray{1, 2.5, true}},
                        {"blob", XmlBinary{std::string("\0\1", 2)}}};
  ASSERT_TRUE(call(*link, "setParam", {"/robot", robot}));
  EXPECT_EQ(*call(*link, "getParam", {"/robot"}), XmlValue(robot));
  EXPECT_EQ(*call(*link, "getParam", {"/robot/blank"}), XmlValue("   "));
  const auto missing = call(*link, "getParam", {"/missing"});
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(call(*link, "deleteParam", {"/robot"}));
  EXPECT_FALSE(call(*link, "getParam", {"/robot"}));
  EXPECT_FALSE(call(*link, "lookupService", {"/nobody"}));
}

}  // namespace
}  // namespace extperfc::translate
