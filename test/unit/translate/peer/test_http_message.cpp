#include <string>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "translate/peer/http_message.hpp"

namespace extperfc::translate {
namespace {

using Kind = HttpReader::Kind;
using Step = HttpReader::Step;

/// Feeds bytes one by one; the step that ended it.
Step feed(HttpReader& reader, const std::string& bytes) {
  std::string waiting;
  for (const char byte : bytes) {
    waiting += byte;
    const auto step = reader.read(waiting);
    if (step != Step::kMore) return step;
  }
  return Step::kMore;
}

TEST(HttpMessage, ReadsARequestByteByByte) {
  HttpReader reader(Kind::kRequest, {});
  ASSERT_EQ(feed(reader, "\r\nPOST /RPC2 HTTP/1.1\r\nHost: a\r\ncontent-LENGTH:  3 \r\n\r\nabc"),
            Step::kDone);
  const auto message = reader.take();
  EXPECT_EQ(message.method, "POST");
  EXPECT_EQ(message.body, "abc");
  EXPECT_TRUE(message.keep_alive);
}

TEST(HttpMessage, LeavesTheNextMessageAlone) {
  HttpReader reader(Kind::kRequest, {});
  std::string bytes = http_request("h", "/", "first") + http_request("h", "/", "second");
  ASSERT_EQ(reader.read(bytes), Step::kDone);
  EXPECT_EQ(reader.take().body, "first");
  ASSERT_EQ(reader.read(bytes), Step::kDone);
  EXPECT_EQ(reader.take().body, "second");
  EXPECT_TRUE(bytes.empty());
}

TEST(HttpMessage, KeepsConnectionsOpenAsTheVersionAndTheFieldSay) {
  const auto kept = [](const std::string& version, const std::string& field) {
    HttpReader reader(Kind::kRequest, {});
    EXPECT_EQ(feed(reader, "POST / " + version + "\r\n" + field + "Content-Length: 0\r\n\r\n"), Step::kDone);
    return reader.take().keep_alive;
  };
  EXPECT_TRUE(kept("HTTP/1.1", ""));
  EXPECT_FALSE(kept("HTTP/1.1", "Connection: Close\r\n"));
  EXPECT_FALSE(kept("HTTP/1.0", ""));
  EXPECT_TRUE(kept("HTTP/1.0", "Connection: Keep-Alive\r\n"));
}

TEST(HttpMessage, ReadsResponsesWithLengthChunksOrNeither) {
  HttpReader reader(Kind::kResponse, {});
  ASSERT_EQ(feed(reader, "HTTP/1.0 200 OK\nContent-length: 2\n\nab"), Step::kDone);
  EXPECT_EQ(reader.take().body, "ab");
  ASSERT_EQ(feed(reader,
                 "HTTP/1.1 100 Continue\r\n\r\nHTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n"
                 "3;x=y\r\nabc\r\nA\r\n0123456789\r\n0\r\nTrailer: 1\r\n\r\n"),
            Step::kDone);
  auto message = reader.take();
  EXPECT_EQ(message.body, "abc0123456789");
  EXPECT_TRUE(message.keep_alive);
  ASSERT_EQ(feed(reader, "HTTP/1.1 500 Broken\r\n\r\nto the end"), Step::kMore);
  ASSERT_EQ(reader.end_of_stream(), Step::kDone);
  message = reader.take();
  EXPECT_EQ(message.status, 500);
  EXPECT_EQ(message.body, "to the end");
  EXPECT_FALSE(message.keep_alive);
}

TEST(HttpMessage, AnEndInTheMiddleIsBroken) {
  for (const char* start : {"HTTP/1.1 2", "HTTP/1.1 200 OK\r\nContent-Length: 9\r\n\r\nabc",
                            "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n3\r\nab"}) {
    HttpReader reader(Kind::kResponse, {});
    ASSERT_EQ(feed(reader, start), Step::kMore);
    EXPECT_EQ(reader.end_of_stream(), Step::kBroken);
  }
}

TEST(HttpMessage, RefusesWithAStatus) {
  RpcLimits limits;
  limits.header_bytes = 200;
  limits.body_bytes = 1'000;
  const auto status = [&](const std::string& bytes) {
    HttpReader reader(Kind::kRequest, limits);
    EXPECT_EQ(feed(reader, bytes), Step::kBroken) << bytes.substr(0, 100);
    return reader.problem_status();
  };
  EXPECT_EQ(status("GET / HTTP/1.1\r\n\r\n"), 405);
  EXPECT_EQ(status("POST / HTTP/1.1\r\n\r\n"), 411);
  EXPECT_EQ(status("POST / HTTP/1.1\r\nContent-Length: 1001\r\n\r\n"), 413);
  EXPECT_EQ(status("POST / HTTP/1.1\r\nContent-Length: 99999999999999999999999\r\n\r\n"), 400);
  EXPECT_EQ(status("POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n"), 400);
  EXPECT_EQ(status("POST / HTTP/1.1\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\n"), 400);
  EXPECT_EQ(status("POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n"), 501);
  EXPECT_EQ(status("POST / HTTP/2.0\r\nContent-Length: 1\r\n\r\n"), 400);
  EXPECT_EQ(status("POST\r\n\r\n"), 400);
  EXPECT_EQ(status("POST / HTTP/1.1\r\nno colon\r\n\r\n"), 400);
  EXPECT_EQ(status("POST / HTTP/1.1\r\nA: " + std::string(300, 'a')), 431);
  EXPECT_EQ(status(std::string("\x16\x03\x01\n\n", 5)), 400) << "TLS";
}

TEST(HttpMessage, ChunksAndEndlessAnswersAreBounded) {
  RpcLimits limits;
  limits.body_bytes = 1'000;
  HttpReader endless(Kind::kResponse, limits);
  EXPECT_EQ(feed(endless, "HTTP/1.0 200 OK\r\n\r\n" + std::string(1'001, 'a')), Step::kBroken);
  const std::string start = "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n";
  for (const std::string& body :
       {std::string("3E9\r\n"), "1F4\r\n" + std::string(500, 'a') + "\r\n1F5\r\n",
        std::string("FFFFFFFFFFFFFFFF\r\n"), std::string("G\r\n"), std::string("1\r\nabc"),
        std::string(400, '0'), "0\r\n" + std::string(20'000, 'a')}) {
    HttpReader reader(Kind::kResponse, limits);
    EXPECT_EQ(feed(reader, start + body), Step::kBroken) << body.substr(0, 30);
  }
}

TEST(HttpMessage, AsksForTheBodyOnce) {
  HttpReader reader(Kind::kRequest, {});
  std::string bytes = "POST / HTTP/1.1\r\nExpect: 100-continue\r\nContent-Length: 3\r\n\r\n";
  ASSERT_EQ(reader.read(bytes), Step::kMore);
  EXPECT_TRUE(reader.wants_continue());
  EXPECT_FALSE(reader.wants_continue());
  bytes = "abc";
  EXPECT_EQ(reader.read(bytes), Step::kDone);
}

TEST(HttpMessage, DamagedMessagesNeverCrash) {
  Rng rng(5);
  const std::string good =
      "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\nConnection: "
      "close\r\n\r\n3\r\nabc\r\n10\r\n0123456789abcdef\r\n0\r\n\r\n";
  for (int i = 0; i < 20'000; ++i) {
    auto text = rng.chance(0.5) ? good : http_response(200, true, "some body");
    for (int changes = rng.integer(1, 3); changes > 0; --changes)
      text[static_cast<std::size_t>(rng.integer(0, static_cast<int>(text.size()) - 1))] =
          static_cast<char>(rng.integer(0, 127));
    HttpReader reader(Kind::kResponse, {});
    if (feed(reader, text) == Step::kMore) {
      const auto end = reader.end_of_stream();
      ASSERT_NE(end, Step::kMore);
    }
  }
}

}  // namespace
}  // namespace extperfc::translate
