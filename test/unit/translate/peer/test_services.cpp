#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "test/unit/translate/peer/raw_socket.hpp"
#include "test/unit/translate/peer/two_peers.hpp"

namespace extperfc::translate {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::frame_of;
using testing::little_endian;
using testing::RawSocket;
using testing::text_of;
using testing::TwoPeers;

constexpr const char* kMd5 = "09fb03525b03e7ea1fd3992bafd87e16";

ByteView bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

class Services : public TwoPeers {
 protected:
  void SetUp() override {
    auto plain = params("/robot");
    plain.marked = false;
    plain.tcpros.handshake = milliseconds(500);
    robot = make(plain);
    translator = make("/translator");
  }
  /// Echoes; "bad" fails, "later" and "never" keep the reply.
  [[nodiscard]] std::unique_ptr<ServiceServer> serve(Peer& peer) {
    ServiceServer::Handlers handlers;
    handlers.on_request = [this](const std::shared_ptr<ServiceRequest>& request) {
      headers.push_back(request->header());
      if (value_of(request->header(), "md5sum") == "wrong") return request->refuse("the md5 is wrong");
      request->accept("std_srvs/SetBool", kMd5, "std_srvs/SetBoolRequest", "std_srvs/SetBoolResponse");
    };
    handlers.on_call = [this](LinkId, const FramePtr& request, const ServiceServer::Reply& reply) {
      const auto text = text_of(request);
      calls.push_back(text);
      if (text == "later") return held.push_back(reply);
      if (text == "forgotten") return;
      reply(text != "bad", bytes_of(text == "bad" ? "it is bad" : "echo " + text));
    };
    handlers.on_down = [this](LinkId) { ++downs; };
    auto server = peer.serve("/set", handlers);
    EXPECT_TRUE(until([&] { return !master.service("/set").empty(); }));
    return server;
  }
  [[nodiscard]] Result<std::shared_ptr<ServiceLink>> open(Peer& peer, const std::string& md5, bool probe) {
    Result<std::shared_ptr<ServiceLink>> opened;
    bool ended = false;
    peer.open_service("/set", md5, probe, [&](Result<std::shared_ptr<ServiceLink>> link) {
      opened = std::move(link);
      ended = true;
    });
    EXPECT_TRUE(until([&] { return ended; }));
    return opened;
  }
  [[nodiscard]] std::string call(ServiceLink& link, const std::string& text,
                                 milliseconds timeout = seconds(5)) {
    std::string answer;
    bool ended = false;
    link.call(frame_of(text), timeout, [&](const Result<FramePtr>& response) {
      answer = response ? text_of(*response) : "error: " + response.error().message;
      ended = true;
    });
    EXPECT_TRUE(until([&] { return ended; }));
    return answer;
  }
  [[nodiscard]] std::uint16_t port() { return parse_uri(master.service("/set"))->port; }

  std::unique_ptr<Peer> robot, translator;
  std::vector<ConnectionHeader> headers;
  std::vector<std::string> calls;
  std::vector<ServiceServer::Reply> held;
  int downs{0};
};

TEST_F(Services, CallsAreAnsweredAndFailuresCarryTheirText) {
  const auto server = serve(*robot);
  const auto link = open(*translator, "*", false);
  ASSERT_TRUE(link) << link.error().message;
  EXPECT_EQ(value_of((*link)->header(), "type"), "std_srvs/SetBool");
  EXPECT_EQ(value_of((*link)->header(), "md5sum"), kMd5);
  EXPECT_EQ(value_of((*link)->header(), "request_type"), "std_srvs/SetBoolRequest");
  EXPECT_EQ(call(**link, "one"), "echo one");
  const auto failure = call(**link, "bad");
  EXPECT_NE(failure.find("error"), std::string::npos);
  EXPECT_NE(failure.find("it is bad"), std::string::npos) << failure;
  EXPECT_EQ(call(**link, ""), "echo ");
  EXPECT_EQ(call(**link, std::string(3'000'000, 'x')), "echo " + std::string(3'000'000, 'x'));
  EXPECT_EQ(headers.size(), 1U);
  EXPECT_EQ(value_of(headers[0], "persistent"), "1");
}

TEST_F(Services, CallsOfOneLinkAreAnsweredInOrder) {
  const auto server = serve(*robot);
  const auto link = open(*translator, "*", false);
  ASSERT_TRUE(link);
  std::vector<std::string> answers;
  for (const auto* text : {"later", "two", "three"}) {
    (*link)->call(frame_of(text), seconds(5), [&](const Result<FramePtr>& response) {
      answers.push_back(response ? text_of(*response) : response.error().message);
    });
  }
  ASSERT_TRUE(until([&] { return held.size() == 1; }));
  for_a_while(milliseconds(50));
  EXPECT_EQ(calls.size(), 1U);
  held[0](true, bytes_of("first"));
  ASSERT_TRUE(until([&] { return answers.size() == 3; }));
  EXPECT_EQ(answers, (std::vector<std::string>{"first", "echo two", "echo three"}));
  held[0](true, bytes_of("twice"));  // counts once
}

TEST_F(Services, AProbeReturnsTheTypeAndNeverCalls) {
  const auto server = serve(*robot);
  const auto link = open(*translator, "*", true);
  ASSERT_TRUE(link);
  EXPECT_EQ(value_of((*link)->header(), "md5sum"), kMd5);
  EXPECT_FALSE((*link)->connected());
  EXPECT_NE(call(**link, "one").find("closed"), std::string::npos);
  EXPECT_TRUE(calls.empty());
  EXPECT_EQ(value_of(headers.at(0), "probe"), "1");
  EXPECT_TRUE(until([&] { return downs == 1; }));
}

TEST_F(Services, RefusalsAndMissingServicesAreErrors) {
  const auto missing = open(*translator, "*", false);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  const auto server = serve(*robot);
  const auto refused = open(*translator, "wrong", false);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("the md5 is wrong"), std::string::npos) << refused.error().message;
}

TEST_F(Services, TranslatorsRefuseEachOther) {
  const auto server = serve(*translator);
  const auto other = make("/other");
  const auto refused = open(*other, "*", false);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("loop"), std::string::npos) << refused.error().message;
  EXPECT_TRUE(open(*robot, "*", false));
}

TEST_F(Services, ADeadProviderIsAnErrorInTime) {
  std::uint16_t deaf_port = 0;
  const auto deaf = RawSocket::listen_on_any(deaf_port);
  master.set_service("/set", "rosrpc://127.0.0.1:" + std::to_string(deaf_port));
  auto with = params("/impatient");
  with.node_timeout = milliseconds(200);
  const auto impatient = make(with);
  EXPECT_FALSE(open(*impatient, "*", true));
  master.set_service("/set", "rosrpc://127.0.0.1:1");
  EXPECT_FALSE(open(*impatient, "*", true));
  master.set_service("/set", "nonsense");
  EXPECT_FALSE(open(*impatient, "*", true));
}

TEST_F(Services, ACallThatTakesTooLongClosesTheLink) {
  const auto server = serve(*robot);
  const auto link = open(*translator, "*", false);
  ASSERT_TRUE(link);
  EXPECT_NE(call(**link, "later", milliseconds(150)).find("in time"), std::string::npos);
  EXPECT_FALSE((*link)->connected());
  EXPECT_NE(call(**link, "more").find("closed"), std::string::npos);
  ASSERT_TRUE(until([&] { return downs == 1; }));
  held.at(0)(true, bytes_of("nobody listens"));
}

TEST_F(Services, AReplyThatIsForgottenIsAFailure) {
  const auto server = serve(*robot);
  const auto link = open(*translator, "*", false);
  ASSERT_TRUE(link);
  EXPECT_NE(call(**link, "forgotten").find("no answer"), std::string::npos);
  EXPECT_EQ(call(**link, "next"), "echo next");
}

TEST_F(Services, AServerThatGoesAwayFailsTheCallsUnderWay) {
  auto server = serve(*robot);
  const auto link = open(*translator, "*", false);
  ASSERT_TRUE(link);
  std::string answer;
  (*link)->call(frame_of("later"), seconds(5), [&](const Result<FramePtr>& response) {
    answer = response ? "answered" : response.error().message;
  });
  ASSERT_TRUE(until([&] { return held.size() == 1; }));
  server.reset();
  ASSERT_TRUE(until([&] { return !answer.empty(); }));
  EXPECT_NE(answer.find("shuts down"), std::string::npos) << answer;
  EXPECT_TRUE(until([&] { return !(*link)->connected(); }));
  EXPECT_TRUE(until([&] { return master.service("/set").empty(); }));
}

TEST_F(Services, AOneShotClientIsClosedAfterItsResponse) {
  const auto server = serve(*robot);
  auto client = RawSocket::connect_to(port());
  client.send(ConnectionHeader{{"service", "/set"}, {"md5sum", kMd5}, {"callerid", "/c"}});
  client.send(little_endian(2) + "hi" + little_endian(5) + "never");
  ASSERT_TRUE(until([&] { return client.drain(); }));
  const auto expected = std::string("\x01", 1) + little_endian(7) + "echo hi";
  ASSERT_GE(client.received.size(), expected.size());
  EXPECT_EQ(client.received.substr(client.received.size() - expected.size()), expected);
  EXPECT_EQ(calls, std::vector<std::string>{"hi"});
}

TEST_F(Services, PipelinedRequestsWaitForTheirTurn) {
  const auto server = serve(*robot);
  auto client = RawSocket::connect_to(port());
  client.send(
      ConnectionHeader{{"service", "/set"}, {"md5sum", kMd5}, {"callerid", "/c"}, {"persistent", "1"}});
  client.send(little_endian(5) + "later" + little_endian(1) + "b");
  ASSERT_TRUE(until([&] { return held.size() == 1; }));
  for_a_while(milliseconds(50));
  EXPECT_EQ(calls.size(), 1U);
  held[0](false, bytes_of("no"));
  const auto expected =
      std::string("\0", 1) + little_endian(2) + "no" + std::string("\x01", 1) + little_endian(6) + "echo b";
  ASSERT_TRUE(until([&] {
    client.drain();
    return client.received.size() > expected.size() &&
           client.received.substr(client.received.size() - expected.size()) == expected;
  }));
}

TEST_F(Services, HostileClientsAreClosedAndOthersServed) {
  const auto server = serve(*robot);
  const ConnectionHeader header{
      {"service", "/set"}, {"md5sum", "*"}, {"callerid", "/c"}, {"persistent", "1"}};
  auto absurd = RawSocket::connect_to(port());
  absurd.send(header);
  absurd.send(little_endian(0xffffffffU) + "x");
  EXPECT_TRUE(until([&] { return absurd.drain(); }));
  auto half = RawSocket::connect_to(port());
  half.send(header);
  half.send(little_endian(100) + "half");
  half.close();
  const auto link = open(*translator, "*", false);
  ASSERT_TRUE(link);
  EXPECT_EQ(call(**link, "one"), "echo one");
  EXPECT_TRUE(until([&] { return downs == 2; }));
}

TEST_F(Services, AHostileServerEndsTheCallWithAnError) {
  std::uint16_t its_port = 0;
  const auto listening = RawSocket::listen_on_any(its_port);
  master.set_service("/set", "rosrpc://127.0.0.1:" + std::to_string(its_port));
  for (const auto& bytes :
       {std::string("\x01", 1) + little_endian(0xffffffffU), std::string("\x01\x05", 2), std::string()}) {
    RawSocket accepted;
    std::string answer;
    std::shared_ptr<ServiceLink> link;
    translator->open_service("/set", "*", false, [&](Result<std::shared_ptr<ServiceLink>> opened) {
      link = std::move(*opened);
      link->call(frame_of("x"), seconds(5), [&](const Result<FramePtr>& response) {
        answer = response ? "answered" : response.error().message;
        link.reset();  // within its own callback
      });
    });
    ASSERT_TRUE(until([&] { return static_cast<bool>(accepted = listening.accept()); }));
    accepted.send(ConnectionHeader{{"type", "a/B"}, {"md5sum", "0"}});
    ASSERT_TRUE(until([&] { return link != nullptr; }));
    accepted.send(bytes);
    ::shutdown(accepted.get(), SHUT_WR);
    ASSERT_TRUE(until([&] { return !answer.empty(); }));
    EXPECT_NE(answer, "answered");
  }
}

TEST_F(Services, TheServerMayBeDestroyedInItsOwnCallbacks) {
  for (const std::string when : {"request", "call", "down"}) {
    std::unique_ptr<ServiceServer> server;
    int ended = 0;
    const auto end = [&] {
      server.reset();
      ++ended;
    };
    ServiceServer::Handlers handlers;
    handlers.on_request = [&](const std::shared_ptr<ServiceRequest>& request) {
      if (when == "request") end();
      request->accept("a/B", kMd5, "a/BRequest", "a/BResponse");
    };
    handlers.on_call = [&](LinkId, const FramePtr&, const ServiceServer::Reply& reply) {
      if (when == "call") end();
      reply(true, {});
    };
    handlers.on_down = [&](LinkId) {
      if (when == "down") end();
    };
    server = robot->serve("/" + when, handlers);
    ASSERT_TRUE(until([&] { return !master.service("/" + when).empty(); }));
    auto client = RawSocket::connect_to(parse_uri(master.service("/" + when))->port);
    client.send(ConnectionHeader{{"service", "/" + when}, {"md5sum", "*"}, {"callerid", "/c"}});
    client.send(little_endian(1) + "x");
    EXPECT_TRUE(until([&] { return client.drain() && ended == 1; })) << when;
  }
}

}  // namespace
}  // namespace extperfc::translate
