#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "test/unit/translate/bridge/bridge_fixture.hpp"
#include "translate/bridge/service_route.hpp"

namespace extperfc::translate::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

struct Answer {
  bool accepted{false}, refused{false};
  std::string type, md5, reason;
};

class FakeServiceRequest final : public ServiceRequest {
 public:
  FakeServiceRequest(ConnectionHeader header, LinkId link, std::shared_ptr<Answer> answer)
      : header_(std::move(header)), link_(link), answer_(std::move(answer)) {}
  [[nodiscard]] const ConnectionHeader& header() const override { return header_; }
  [[nodiscard]] bool probe() const override { return value_of(header_, "probe") == "1"; }
  [[nodiscard]] LinkId link() const override { return link_; }
  void accept(const std::string& type, const std::string& md5, const std::string&,
              const std::string&) override {
    answer_->accepted = true;
    answer_->type = type;
    answer_->md5 = md5;
  }
  void refuse(const std::string& reason) override {
    answer_->refused = true;
    answer_->reason = reason;
  }

 private:
  ConnectionHeader header_;
  LinkId link_;
  std::shared_ptr<Answer> answer_;
};

/// demo/Set lives on the robot side: it takes a number and answers twice that. The workstation side's version
/// has a field more in its request and in its response.
class ServiceRouteTest : public BridgeFixture {
 protected:
  ServiceRouteTest() {
    folder_ = testing::TempDir() + "/extperfc_service_route";
    for (const auto& [set, text] :
         {std::pair{"robot", "int32 value\n---\nint32 twice\n"},
          std::pair{"workstation", "int32 value\nint8 more\n---\nint32 twice\nbool ok\n"}}) {
      const auto place = std::filesystem::path(folder_) / set / "demo" / "srv";
      std::filesystem::create_directories(place);
      std::ofstream(place / "Set.srv") << text;
      const auto read = definitions_.add_tree(std::filesystem::path(folder_) / set, set);
      if (!read) throw std::runtime_error(read.error().message);
    }
    robot_service_ = definitions_.service_of_set("robot", "demo/Set");
    workstation_service_ = definitions_.service_of_set("workstation", "demo/Set");
    robot_.service_header = {{"type", "demo/Set"}, {"md5sum", robot_service_->md5}, {"callerid", "/server"}};
    robot_.answer = [this](const FramePtr& request) -> Result<FramePtr> {
      asked_.push_back(bytes_of(request->payload()));
      if (refuses_) return fail(ErrorCode::kFailed, "out of order");
      return frame_of({static_cast<std::uint8_t>(2 * request->payload().data[0]), 0, 0, 0});
    };
    route_ = std::make_unique<ServiceRoute>(context_, "/set", Side::kRobot);
  }
  ~ServiceRouteTest() override { std::filesystem::remove_all(folder_); }

  std::shared_ptr<Answer> connect(ConnectionHeader header, LinkId link = 1) {
    auto answer = std::make_shared<Answer>();
    workstation_.served->handlers.on_request(
        std::make_shared<FakeServiceRequest>(std::move(header), link, answer));
    return answer;
  }
  static ConnectionHeader client(const std::string& md5) {
    return {{"service", "/set"}, {"md5sum", md5}, {"callerid", "/client"}};
  }
  struct Reply {
    int times{0};
    bool ok{false};
    Bytes bytes;
  };
  Reply call(const Bytes& request, LinkId link = 1) {
    auto reply = std::make_shared<Reply>();
    workstation_.served->handlers.on_call(link, frame_of(request), [reply](bool ok, ByteView response) {
      ++reply->times;
      reply->ok = ok;
      reply->bytes = bytes_of(response);
    });
    return *reply;
  }

  std::string folder_;
  ServicePtr robot_service_, workstation_service_;
  std::vector<Bytes> asked_;
  bool refuses_{false};
  std::unique_ptr<ServiceRoute> route_;
};

TEST_F(ServiceRouteTest, BothHalvesAreConverted) {
  const auto answer = connect(client(workstation_service_->md5));
  ASSERT_TRUE(answer->accepted) << answer->reason;
  EXPECT_EQ(answer->md5, workstation_service_->md5);
  const auto reply = call({5, 0, 0, 0, 77});
  EXPECT_EQ(asked_, (std::vector<Bytes>{{5, 0, 0, 0}}));
  EXPECT_EQ(reply.times, 1);
  EXPECT_TRUE(reply.ok);
  EXPECT_EQ(reply.bytes, (Bytes{10, 0, 0, 0, 0}));
  EXPECT_EQ(route_->status().plan, "convert");
  EXPECT_EQ(route_->status().calls, 1U);
}

TEST_F(ServiceRouteTest, TheSameVersionPasses) {
  ASSERT_TRUE(connect(client(robot_service_->md5))->accepted);
  EXPECT_EQ(call({5, 0, 0, 0}).bytes, (Bytes{10, 0, 0, 0}));
  EXPECT_EQ(route_->status().plan, "pass");
}

TEST_F(ServiceRouteTest, OneConnectionServesManyCalls) {
  connect(client(robot_service_->md5));
  const auto before = robot_.services_opened;
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(call({1, 0, 0, 0}).ok);
  EXPECT_EQ(robot_.services_opened, before + 1);
}

TEST_F(ServiceRouteTest, ProbesGetAnAnswer) {
  const auto answer =
      connect({{"service", "/set"}, {"md5sum", "*"}, {"probe", "1"}, {"callerid", "/rosservice"}});
  ASSERT_TRUE(answer->accepted);
  EXPECT_EQ(answer->type, "demo/Set");
  EXPECT_EQ(answer->md5, robot_service_->md5);
}

TEST_F(ServiceRouteTest, ProbesGetTheVersionOfTheirSide) {
  params_.sides[1].definitions = {"workstation"};
  const auto answer =
      connect({{"service", "/set"}, {"md5sum", "*"}, {"probe", "1"}, {"callerid", "/rosservice"}});
  EXPECT_EQ(answer->md5, workstation_service_->md5) << "tools load their own class of the type";
}

TEST_F(ServiceRouteTest, TheServersRefusalReachesTheCaller) {
  connect(client(workstation_service_->md5));
  refuses_ = true;
  const auto reply = call({5, 0, 0, 0, 77});
  EXPECT_EQ(reply.times, 1);
  EXPECT_FALSE(reply.ok);
  EXPECT_EQ(std::string(reply.bytes.begin(), reply.bytes.end()), "out of order");
}

TEST_F(ServiceRouteTest, ADeadServerIsAnError) {
  robot_.answer = nullptr;
  const auto answer = connect(client(workstation_service_->md5));
  EXPECT_TRUE(answer->refused);
  EXPECT_NE(answer->reason.find("no such service"), std::string::npos);
}

TEST_F(ServiceRouteTest, AServerThatDiesLaterIsAnErrorOfTheCall) {
  connect(client(robot_service_->md5));
  robot_.answer = nullptr;
  const auto reply = call({5, 0, 0, 0});
  EXPECT_EQ(reply.times, 1);
  EXPECT_FALSE(reply.ok);
}

TEST_F(ServiceRouteTest, AnUnknownVersionIsRefusedWithTheRemedy) {
  const auto answer = connect(client("0123456789abcdef0123456789abcdef"));
  EXPECT_TRUE(answer->refused);
  EXPECT_NE(answer->reason.find("0123456789abcdef"), std::string::npos);
  EXPECT_NE(answer->reason.find("add its package"), std::string::npos);
}

TEST_F(ServiceRouteTest, ADamagedRequestDoesNotReachTheServer) {
  connect(client(workstation_service_->md5));
  const auto reply = call({5, 0});
  EXPECT_FALSE(reply.ok);
  EXPECT_TRUE(asked_.empty());
}

}  // namespace
}  // namespace extperfc::translate::test
