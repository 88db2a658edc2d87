#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/translate/rpc.hpp"

#include "test/unit/translate/peer/loop_until.hpp"
#include "test/unit/translate/peer/raw_server.hpp"
#include "translate/peer/http_message.hpp"

namespace extperfc::translate {
namespace {

using namespace std::chrono_literals;

class Rpc : public ::testing::Test {
 protected:
  using Answered = std::vector<Result<XmlValue>>;

  /// A server that returns method and arguments.
  std::string open_echo(RpcServer& server) {
    const auto port =
        server.open("127.0.0.1", 0, [](const XmlCall& call, const std::string& peer) -> XmlValue {
          if (call.method == "throw") throw std::runtime_error("on purpose");
          return XmlArray{call.method, call.arguments, peer};
        });
    EXPECT_TRUE(port);
    port_ = *port;
    return "http://127.0.0.1:" + std::to_string(port_) + "/";
  }

  Result<XmlValue> call(const std::string& uri, const std::string& method, const XmlArray& arguments = {},
                        std::chrono::milliseconds timeout = 10s) {
    Answered answers;
    client_.call(uri, method, arguments, timeout,
                 [&](Result<XmlValue> answer) { answers.push_back(std::move(answer)); });
    EXPECT_TRUE(answers.empty()) << "never inside call()";
    EXPECT_TRUE(loop_until(loop_, [&] { return !answers.empty(); }));
    EXPECT_EQ(answers.size(), 1U);
    return answers.empty() ? fail(ErrorCode::kFailed, "none") : answers.front();
  }

  void expect_error(const Result<XmlValue>& answer, const std::string& part, const std::string& uri) {
    ASSERT_FALSE(answer);
    EXPECT_NE(answer.error().message.find(part), std::string::npos) << answer.error().message;
    EXPECT_NE(answer.error().message.find(uri), std::string::npos) << answer.error().message;
  }

  EventLoop loop_;
  Resolver resolver_{loop_, {{"robot.local", "127.0.0.1"}}};
  RpcClient client_{loop_, resolver_};
  std::uint16_t port_{0};
};

TEST_F(Rpc, AnswersCalls) {
  RpcServer server(loop_);
  const auto uri = open_echo(server);
  const XmlArray arguments{"text", 3, 2.5, true, XmlArray{XmlArray{"TCPROS"}}, XmlStruct{{"a", " b\n"}}};
  const auto answer = call(uri, "method", arguments);
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_EQ(*answer, XmlValue(XmlArray{"method", arguments, "127.0.0.1"}));
  EXPECT_TRUE(call("http://robot.local:" + std::to_string(port_), "by_name"));
}

TEST_F(Rpc, LargeArgumentsAndAnswersPass) {
  RpcServer server(loop_);
  const auto uri = open_echo(server);
  const std::string urdf(3'000'000, '<');  // four bytes each on the wire
  const auto answer = call(uri, "setParam", {urdf});
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_EQ(*answer, XmlValue(XmlArray{"setParam", XmlArray{urdf}, "127.0.0.1"}));
}

TEST_F(Rpc, CallsToOneServerKeepTheirOrderOnOneConnection) {
  int next = 0;
  RpcServer server(loop_);
  const auto port = server.open("127.0.0.1", 0, [&](const XmlCall& call, const std::string&) {
    EXPECT_EQ(call.arguments.at(0), XmlValue(next));
    return XmlValue(next++);
  });
  ASSERT_TRUE(port);
  int answered = 0;
  for (int i = 0; i < 500; ++i)
    client_.call("http://127.0.0.1:" + std::to_string(*port), "m", {i}, 20s,
                 [&, i](const Result<XmlValue>& answer) {
                   ASSERT_TRUE(answer) << answer.error().message;
                   EXPECT_EQ(*answer, XmlValue(i));
                   ++answered;
                 });
  EXPECT_TRUE(loop_until(loop_, [&] { return answered == 500; }));
}

TEST_F(Rpc, ExceptionsAndNonsenseBecomeFaults) {
  RpcServer server(loop_);
  const auto uri = open_echo(server);
  expect_error(call(uri, "throw"), "on purpose", uri);
  RawClient raw(loop_, port_);
  ASSERT_TRUE(raw.send(http_request("h", "/", "this is not XML")));
  ASSERT_TRUE(
      loop_until(loop_, [&] { return raw.received().find("</methodResponse>") != std::string::npos; }));
  EXPECT_NE(raw.received().find("faultString"), std::string::npos);
  EXPECT_TRUE(call(uri, "still alive"));
}

TEST_F(Rpc, ErrorsNameMethodAndUri) {
  Socket closed = std::move(*listen_at("127.0.0.1", 0));
  const auto uri = "http://127.0.0.1:" + std::to_string(port_of(closed.get()));
  closed.reset();
  expect_error(call(uri, "getPid"), "getPid", uri);
  expect_error(call(uri, "getPid"), "refused", uri);
  expect_error(call("nonsense", "getPid"), "getPid", "nonsense");
  const auto unknown = call("http://no-such-host.invalid:1/", "getPid");
  expect_error(unknown, "/etc/hosts", "no-such-host.invalid");
}

TEST_F(Rpc, AServerThatNeverAnswersTimesOutAndTheNextCallGoesOn) {
  bool mute = true;
  RawServer server(loop_, [&](RawServer::Connection& connection) {
    if (!mute) connection.send(http_response(200, true, encode_response(1)));
  });
  const auto before = EventLoop::now();
  expect_error(call(server.uri(), "getPid", {}, 100ms), "100 ms", server.uri());
  EXPECT_GE(EventLoop::now() - before, 100ms);
  mute = false;
  EXPECT_TRUE(call(server.uri(), "getPid"));
  EXPECT_EQ(server.accepted(), 2);
}

TEST_F(Rpc, WaitingCallsExpireBehindOneThatHangs) {
  const RawServer server(loop_, [](RawServer::Connection&) {});
  std::vector<int> expired;
  for (int i = 0; i < 3; ++i)
    client_.call(server.uri(), "m", {}, std::chrono::milliseconds(150 - 50 * i),
                 [&, i](const Result<XmlValue>& answer) {
                   EXPECT_FALSE(answer);
                   expired.push_back(i);
                 });
  ASSERT_TRUE(loop_until(loop_, [&] { return expired.size() == 3; }));
  EXPECT_EQ(expired, (std::vector<int>{2, 1, 0}));
}

TEST_F(Rpc, AKeptConnectionThatTheServerClosedIsOpenedAgain) {
  bool close_next = false;
  RawServer* self = nullptr;
  RawServer server(loop_, [&](RawServer::Connection& connection) {
    if (std::exchange(close_next, false)) return self->close(connection);
    connection.send(http_response(200, true, encode_response(1)));
  });
  self = &server;
  EXPECT_TRUE(call(server.uri(), "first"));
  close_next = true;  // closed after the request came, without a byte
  EXPECT_TRUE(call(server.uri(), "second"));
  EXPECT_EQ(server.accepted(), 2);
  server.close_all();  // closed while idle
  EXPECT_TRUE(call(server.uri(), "third"));
  EXPECT_EQ(server.accepted(), 3);
}

TEST_F(Rpc, ANewConnectionThatIsClosedIsAnErrorWithoutASecondTry) {
  RawServer* self = nullptr;
  RawServer server(loop_, [&](RawServer::Connection& connection) { self->close(connection); });
  self = &server;
  EXPECT_FALSE(call(server.uri(), "m"));
  EXPECT_EQ(server.accepted(), 1);
}

TEST_F(Rpc, GarbageAnswersAreErrors) {
  const std::string whole = http_response(200, true, encode_response(1));
  for (const auto& [bytes, part] : std::vector<std::pair<std::string, std::string>>{
           {"SSH-2.0-OpenSSH\r\n\r\n", "HTTP"},
           {http_response(500, false, ""), "500"},
           {http_response(200, true, "<html>"), "XML-RPC"},
           {whole.substr(0, whole.size() - 10), "middle"},
           {"HTTP/1.1 200 OK\r\nContent-Length: 99999999999\r\n\r\n", "more than"},
           {"HTTP/1.1 200 OK\r\n" + std::string(100'000, 'x'), "header"}}) {
    RawServer* self = nullptr;
    RawServer server(loop_, [&, text = bytes](RawServer::Connection& connection) {
      connection.send(text);
      self->close(connection);
    });
    self = &server;
    expect_error(call(server.uri(), "m"), part, server.uri());
  }
}

TEST_F(Rpc, ReadsAnswersOfHttp10WithoutLength) {
  RawServer* self = nullptr;
  RawServer server(loop_, [&](RawServer::Connection& connection) {
    connection.send("HTTP/1.0 200 OK\r\nContent-type: text/xml\r\n\r\n" + encode_response("x"));
    self->close(connection);
  });
  self = &server;
  const auto answer = call(server.uri(), "m");
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_EQ(*answer, XmlValue("x"));
}

TEST_F(Rpc, TooManyWaitingCallsFailAtOnce) {
  const RawServer server(loop_, [](RawServer::Connection&) {});
  std::size_t failed = 0;
  for (std::size_t i = 0; i < RpcClient::kWaiting + 10; ++i)
    client_.call(server.uri(), "m", {}, 1h,
                 [&](const Result<XmlValue>& answer) { failed += answer ? 0 : 1; });
  ASSERT_TRUE(loop_until(loop_, [&] { return failed != 0; }));
  loop_for(loop_, 20ms);
  EXPECT_EQ(failed, 10U);
}

TEST_F(Rpc, ACallbackMayEndTheClient) {
  RpcServer server(loop_);
  const auto uri = open_echo(server);
  auto client = std::make_unique<RpcClient>(loop_, resolver_);
  int answered = 0;
  for (int i = 0; i < 3; ++i)
    client->call(uri, "m", {}, 10s, [&](const Result<XmlValue>&) {
      ++answered;
      client.reset();
    });
  ASSERT_TRUE(loop_until(loop_, [&] { return answered != 0; }));
  loop_for(loop_, 20ms);
  EXPECT_EQ(answered, 1) << "calls of a client that is gone are forgotten";
}

TEST_F(Rpc, AnAnswerMayCloseTheServer) {
  auto server = std::make_unique<RpcServer>(loop_);
  const auto port = server->open("127.0.0.1", 0, [&](const XmlCall&, const std::string&) {
    server.reset();
    return XmlValue(1);
  });
  ASSERT_TRUE(port);
  EXPECT_FALSE(call("http://127.0.0.1:" + std::to_string(*port), "shutdown"));
}

TEST_F(Rpc, APortInUseIsAnErrorThatNamesIt) {
  RpcServer first(loop_), second(loop_);
  open_echo(first);
  const auto port =
      second.open("127.0.0.1", port_, [](const XmlCall&, const std::string&) { return XmlValue(); });
  ASSERT_FALSE(port);
  EXPECT_NE(port.error().message.find(std::to_string(port_)), std::string::npos);
  EXPECT_FALSE(second.open("not an address", 0, nullptr));
}

TEST_F(Rpc, ServesPipelinedRequestsInOrder) {
  RpcServer server(loop_);
  open_echo(server);
  RawClient raw(loop_, port_);
  std::string requests;
  for (int i = 0; i < 50; ++i) requests += http_request("h", "/", encode_call("m" + std::to_string(i), {}));
  ASSERT_TRUE(raw.send(requests));
  ASSERT_TRUE(loop_until(loop_, [&] { return raw.received().find("m49<") != std::string::npos; }));
  std::size_t at = 0;
  for (int i = 0; i < 50; ++i) {
    at = raw.received().find(">m" + std::to_string(i) + "<", at);
    ASSERT_NE(at, std::string::npos) << i;
  }
}

TEST_F(Rpc, SendsContinueToThoseWhoWait) {
  RpcServer server(loop_);
  open_echo(server);
  RawClient raw(loop_, port_);
  const auto body = encode_call("m", {});
  ASSERT_TRUE(raw.send("POST / HTTP/1.1\r\nExpect: 100-continue\r\nContent-Length: " +
                       std::to_string(body.size()) + "\r\n\r\n"));
  ASSERT_TRUE(loop_until(loop_, [&] { return !raw.received().empty(); }));
  EXPECT_EQ(raw.received(), "HTTP/1.1 100 Continue\r\n\r\n");
  ASSERT_TRUE(raw.send(body));
  EXPECT_TRUE(loop_until(loop_, [&] { return raw.received().find("200 OK") != std::string::npos; }));
}

TEST_F(Rpc, RefusesHugeBodiesBeforeTheyCome) {
  RpcServer server(loop_);
  const auto uri = open_echo(server);
  RawClient raw(loop_, port_);
  ASSERT_TRUE(raw.send("POST / HTTP/1.1\r\nContent-Length: 1000000000\r\n\r\n"));
  ASSERT_TRUE(loop_until(loop_, [&] { return raw.closed(); }));
  EXPECT_EQ(raw.received().rfind("HTTP/1.1 413", 0), 0U);
  EXPECT_TRUE(call(uri, "still alive"));
}

TEST_F(Rpc, ManyLargeBodiesTogetherAreBounded) {
  RpcLimits limits;
  limits.buffered_bytes = 200'000;
  RpcServer server(loop_, limits);
  const auto uri = open_echo(server);
  std::vector<std::unique_ptr<RawClient>> clients;
  const std::string part = "POST / HTTP/1.1\r\nContent-Length: 1000000\r\n\r\n" + std::string(50'000, 'a');
  for (int i = 0; i < 20; ++i) {
    clients.push_back(std::make_unique<RawClient>(loop_, port_));
    loop_for(loop_, 2ms);
    clients.back()->send(part);
  }
  const auto open = [&] {
    std::size_t count = 0;
    for (const auto& raw : clients) count += raw->closed() ? 0U : 1U;
    return count;
  };
  ASSERT_TRUE(loop_until(loop_, [&] { return open() <= 4; }));
  EXPECT_GE(open(), 3U);
  EXPECT_TRUE(call(uri, "still alive"));
}

TEST_F(Rpc, ClosesSlowAndSilentClients) {
  RpcLimits limits;
  limits.request = 200ms;
  limits.idle = 400ms;
  RpcServer server(loop_, limits);
  open_echo(server);
  RawClient slow(loop_, port_), silent(loop_, port_);
  loop_for(loop_, 10ms);
  const auto start = EventLoop::now();
  const std::string request = http_request("h", "/", encode_call("m", {}));
  std::size_t sent = 0;
  std::function<void()> drip = [&] {
    slow.send(request.substr(sent++, 1));
    if (sent < request.size()) loop_.after(10ms, drip);
  };
  drip();
  ASSERT_TRUE(loop_until(loop_, [&] { return slow.closed(); }));
  const auto slow_after = EventLoop::now() - start;
  ASSERT_TRUE(loop_until(loop_, [&] { return silent.closed(); }));
  EXPECT_GE(slow_after, 150ms);
  EXPECT_LT(slow_after, 1500ms) << "dripping does not prolong it";
  EXPECT_GE(EventLoop::now() - start, 300ms);
  EXPECT_TRUE(slow.received().empty());
}

TEST_F(Rpc, ClosesConnectionsBeyondItsLimit) {
  RpcLimits limits;
  limits.connections = 3;
  RpcServer server(loop_, limits);
  const auto uri = open_echo(server);
  std::vector<std::unique_ptr<RawClient>> clients;
  for (int i = 0; i < 5; ++i) {
    clients.push_back(std::make_unique<RawClient>(loop_, port_));
    loop_for(loop_, 5ms);
  }
  ASSERT_TRUE(loop_until(loop_, [&] { return clients[3]->closed() && clients[4]->closed(); }));
  EXPECT_FALSE(clients[0]->closed());
  clients.clear();
  EXPECT_TRUE(loop_until(loop_, [&] { return call(uri, "room again").has_value(); }));
}

TEST_F(Rpc, AClientThatDoesNotReadIsClosedAndHoldsNothingUp) {
  RpcLimits limits;
  limits.request = 300ms;
  RpcServer server(loop_, limits);
  const auto port = server.open("127.0.0.1", 0, [](const XmlCall& call, const std::string&) {
    return call.method == "big" ? XmlValue(std::string(8'000'000, 'a')) : XmlValue(1);
  });
  ASSERT_TRUE(port);
  bool open = false;
  Socket mute = std::move(*start_connection("127.0.0.1", *port));
  loop_.watch(mute.get(), EPOLLOUT, Priority::kNormal, [&](std::uint32_t) {
    const auto request = http_request("h", "/", encode_call("big", {}));
    open = ::send(mute.get(), request.data(), request.size(), MSG_NOSIGNAL) > 0;
    loop_.unwatch(mute.get());
  });
  ASSERT_TRUE(loop_until(loop_, [&] { return open; }));
  EXPECT_TRUE(call("http://127.0.0.1:" + std::to_string(*port), "m"));
  loop_for(loop_, 500ms);
  std::array<char, 65536> bytes{};
  std::size_t total = 0;
  ssize_t count = 0;
  while ((count = ::recv(mute.get(), bytes.data(), bytes.size(), 0)) > 0)
    total += static_cast<std::size_t>(count);
  EXPECT_LT(total, 8'000'000U);
  EXPECT_TRUE(count == 0 || errno != EAGAIN) << "closed, not only waiting";
}

}  // namespace
}  // namespace extperfc::translate
