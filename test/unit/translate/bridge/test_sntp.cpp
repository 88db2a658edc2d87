// SNTP: the packet, what is no answer, and a client that asks a server in this process.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "test/unit/translate/bridge/ntp_server.hpp"

namespace extperfc::translate {
namespace {

using std::chrono::milliseconds;

ByteView view(const std::vector<std::uint8_t>& bytes) {
  return {bytes.data(), bytes.size()};
}

/// A right answer to the nonce 42 that says 12:00:00 UTC, 21 November 2026.
std::vector<std::uint8_t> right_answer() {
  std::vector<std::uint8_t> bytes(kSntpBytes);
  bytes[0] = 4U << 3U | 4U;
  bytes[1] = 2;
  bytes[31] = 42;
  const auto noon = unix_s_to_ntp(1795262400.0);
  for (std::size_t i = 0; i < 8; ++i)
    bytes[32 + i] = bytes[40 + i] = static_cast<std::uint8_t>(noon >> (8U * (7 - i)));
  return bytes;
}

TEST(SntpPacket, RequestIsAClientsOfVersion4) {
  const auto packet = sntp_request(0x0102030405060708ULL);
  EXPECT_EQ(packet[0], 0x23);
  for (std::size_t i = 1; i < 40; ++i) EXPECT_EQ(packet[i], 0) << i;
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(packet[40 + i], i + 1);
}

TEST(SntpPacket, TimestampsCrossTheYear2036) {
  EXPECT_EQ(ntp_to_unix_s(0x83AA7E80ULL << 32U), 0.0) << "1970, as a robot with a flat battery says";
  EXPECT_EQ(ntp_to_unix_s(0xFFFFFFFFULL << 32U), 2085978495.0) << "the last second of era 0";
  EXPECT_EQ(ntp_to_unix_s(0), 2085978496.0) << "the first of era 1: 7 February 2036, 06:28:16";
  EXPECT_EQ(ntp_to_unix_s(0x80000000ULL), 2085978496.5);
  for (const double time_s : {0.0, 1.7e9, 2085978495.75, 2085978496.0, 2085978497.25, 4.0e9})
    EXPECT_NEAR(ntp_to_unix_s(unix_s_to_ntp(time_s)), time_s, 1e-6);
}

TEST(SntpPacket, ARightAnswerIsRead) {
  const auto answer = read_sntp_answer(view(right_answer()), 42);
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_NEAR(answer->received_s, 1795262400.0, 1e-6);
  EXPECT_NEAR(answer->transmitted_s, 1795262400.0, 1e-6);
  EXPECT_EQ(answer->stratum, 2U);
  EXPECT_TRUE(answer->synchronised);
}

TEST(SntpPacket, AClockThatIsNotSynchronisedCanBeCompared) {
  auto bytes = right_answer();
  bytes[0] |= 3U << 6U;
  const auto answer = read_sntp_answer(view(bytes), 42);
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_FALSE(answer->synchronised);
}

struct Spoiled {
  const char* name;
  std::size_t at;
  std::uint8_t value;
  ErrorCode code;
  const char* text;
};

TEST(SntpPacket, WhatIsNoAnswerIsNamed) {
  for (const auto& spoiled :
       {Spoiled{"a client's", 0, 4U << 3U | 3U, ErrorCode::kCorrupt, "mode 3"},
        Spoiled{"a broadcast", 0, 4U << 3U | 5U, ErrorCode::kCorrupt, "mode 5"},
        Spoiled{"of another question", 31, 43, ErrorCode::kCorrupt, "does not match the request"},
        Spoiled{"kiss of death", 1, 0, ErrorCode::kUnsupported, "refuses"},
        Spoiled{"no such stratum", 1, 17, ErrorCode::kCorrupt, "no time"}}) {
    auto bytes = right_answer();
    bytes[spoiled.at] = spoiled.value;
    const auto answer = read_sntp_answer(view(bytes), 42);
    ASSERT_FALSE(answer) << spoiled.name;
    EXPECT_EQ(answer.error().code, spoiled.code) << spoiled.name;
    EXPECT_NE(answer.error().message.find(spoiled.text), std::string::npos) << answer.error().message;
  }
  for (const std::size_t at : {32U, 40U}) {
    auto bytes = right_answer();
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), 8, std::uint8_t{0});
    EXPECT_FALSE(read_sntp_answer(view(bytes), 42)) << "no time at " << at;
  }
}

TEST(SntpPacket, TheKissCodeIsReported) {
  auto bytes = right_answer();
  bytes[1] = 0;
  const std::string code = "RATE";
  std::copy(code.begin(), code.end(), bytes.begin() + 12);
  EXPECT_NE(read_sntp_answer(view(bytes), 42).error().message.find("'RATE'"), std::string::npos);
  bytes[12] = '\n';
  bytes[13] = 0xFF;
  EXPECT_NE(read_sntp_answer(view(bytes), 42).error().message.find("'TE'"), std::string::npos)
      << "what is no letter does not reach a log";
}

TEST(SntpPacket, AnyBytesOfAnyLengthAreReadSafely) {
  Rng rng(17);
  for (int i = 0; i < 20000; ++i) {
    auto bytes = right_answer();
    bytes.resize(static_cast<std::size_t>(rng.integer(0, 80)));
    for (auto& byte : bytes)
      if (rng.chance(0.1)) byte = static_cast<std::uint8_t>(rng.integer(0, 255));
    const std::vector<std::uint8_t> exact(bytes);  // so that a read beyond it is seen
    (void)read_sntp_answer(view(exact), 42);
  }
}

class Sntp : public testing::Test {
 protected:
  static constexpr double kOffsetS = 12.5;

  SntpClient::Params params(std::uint16_t port) const {
    SntpClient::Params params;
    params.host = "robot.local";
    params.port = port;
    params.period = milliseconds(60);
    params.first_period = milliseconds(5);
    params.timeout = milliseconds(100);
    params.longest_period = milliseconds(40);
    return params;
  }

  void start(std::uint16_t port) {
    client_ = std::make_unique<SntpClient>(
        loop_, resolver_, params(port),
        SntpClient::Handlers{[this](const auto& sample) { samples_.push_back(sample); },
                             [this](const auto& problem) { problems_.push_back(problem); }});
  }

  template <typename Condition>
  [[nodiscard]] bool wait_for(Condition condition) {
    const auto deadline = EventLoop::now() + std::chrono::seconds(10);
    while (!condition() && EventLoop::now() < deadline) loop_.run_once(milliseconds(20));
    return condition();
  }
  [[nodiscard]] bool wait_for_samples(std::size_t count) {
    return wait_for([&] { return samples_.size() >= count; });
  }
  [[nodiscard]] bool wait_for_problem(const std::string& text) {
    return wait_for([&] { return !problems_.empty() && problems_.back().find(text) != std::string::npos; });
  }

  EventLoop loop_;
  Resolver resolver_{loop_, {{"robot.local", "127.0.0.1"}}};
  std::unique_ptr<SntpClient> client_;
  std::vector<SntpClient::Sample> samples_;
  std::vector<std::string> problems_;
};

TEST_F(Sntp, MeasuresAnotherClock) {
  NtpServer server(loop_, kOffsetS);
  start(server.port());
  ASSERT_TRUE(wait_for_samples(SntpClient::kQuick + 1));
  EXPECT_TRUE(problems_.empty()) << problems_.front();
  EXPECT_EQ(client_->period(), milliseconds(60)) << "after the first quick ones";
  ClockOffset clock;
  for (const auto& sample : samples_) clock.add_ntp_sample(sample.t0, sample.t1, sample.t2, sample.t3);
  const auto estimate = clock.estimate();
  ASSERT_TRUE(estimate);
  EXPECT_LT(estimate->uncertainty_s, 0.1);
  EXPECT_LE(std::abs(estimate->offset_s - kOffsetS), estimate->uncertainty_s + 1e-6);
}

TEST_F(Sntp, ASilentServerIsAProblemOnceAndAskedMoreRarely) {
  NtpServer server(loop_, kOffsetS, [](auto) { return NtpServer::Packet{}; });
  start(server.port());
  ASSERT_TRUE(wait_for_problem("NTP server robot.local:" + std::to_string(server.port()) + ": no answer"));
  ASSERT_TRUE(wait_for([&] { return server.questions() >= 4; }));
  EXPECT_EQ(problems_.size(), 1U);
  EXPECT_EQ(client_->period(), milliseconds(40)) << "the longest";
  server.spoil(nullptr);
  ASSERT_TRUE(wait_for_samples(1));
  EXPECT_TRUE(client_->problem().empty());
  EXPECT_EQ(client_->period(), milliseconds(5)) << "quick again";
}

TEST_F(Sntp, ARefusalIsReported) {
  NtpServer server(loop_, kOffsetS, [](auto answer) {
    answer[1] = 0;
    const std::string code = "DENY";
    std::copy(code.begin(), code.end(), answer.begin() + 12);
    return answer;
  });
  start(server.port());
  ASSERT_TRUE(wait_for_problem("'DENY'"));
  EXPECT_EQ(client_->period(), milliseconds(40)) << "left alone for as long as may be";
  EXPECT_TRUE(samples_.empty());
}

TEST_F(Sntp, StrangersPacketsAreNoSamples) {
  NtpServer server(loop_, kOffsetS, [](auto answer) {
    answer[24] = static_cast<std::uint8_t>(answer[24] + 1);  // another question's
    return answer;
  });
  start(server.port());
  ASSERT_TRUE(wait_for_problem("does not match the request"));
  ASSERT_TRUE(wait_for_problem("no answer"));
  EXPECT_TRUE(samples_.empty());
}

TEST_F(Sntp, AClosedPortIsReportedAtOnce) {
  std::uint16_t port = 0;
  {
    const NtpServer gone(loop_, kOffsetS);
    port = gone.port();
  }
  start(port);
  ASSERT_TRUE(wait_for_problem("refused"));
}

TEST_F(Sntp, AnInvalidNameIsReported) {
  auto wrong = params(123);
  wrong.host = "no-such-robot.invalid";
  client_ = std::make_unique<SntpClient>(
      loop_, resolver_, wrong,
      SntpClient::Handlers{{}, [this](const auto& problem) { problems_.push_back(problem); }});
  ASSERT_TRUE(wait_for_problem("no-such-robot.invalid"));
}

TEST_F(Sntp, MayBeDestroyedInItsOwnHandlers) {
  NtpServer server(loop_, kOffsetS);
  bool done = false;
  client_ = std::make_unique<SntpClient>(loop_, resolver_, params(server.port()),
                                         SntpClient::Handlers{[&](const auto&) {
                                                                client_.reset();
                                                                done = true;
                                                              },
                                                              {}});
  ASSERT_TRUE(wait_for([&] { return done; }));
  EXPECT_EQ(server.questions(), 1);
}

}  // namespace
}  // namespace extperfc::translate
