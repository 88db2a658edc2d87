#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/bytes.hpp"
#include "extperfc/translate/event_loop.hpp"
#include "extperfc/translate/rpc.hpp"

namespace extperfc::translate {

/// The packet of (S)NTP version 4 that client and server exchange. Source: RFC 4330, section 4.
inline constexpr std::size_t kSntpBytes = 48;
using SntpPacket = std::array<std::uint8_t, kSntpBytes>;

/// What a server answered. Times are seconds since 1970 of the server's clock.
struct SntpAnswer {
  double received_s{0};     ///< when our request reached it (T2 of the RFC)
  double transmitted_s{0};  ///< when its answer left (T3)
  unsigned stratum{0};
  bool synchronised{
      true};  ///< false: it does not know the time; its clock can be compared with ours all the same
};

/// A request whose transmit timestamp is `nonce`: servers copy it into their answer, and a third party that
/// cannot see the request cannot guess it. The packet does not contain the local time.
[[nodiscard]] SntpPacket sntp_request(std::uint64_t nonce);
/// Checks that the packet is a server's answer to this request. Errors: too short (kCorrupt), not an answer
/// or of another request (kCorrupt), no time in it (kCorrupt), the server refuses (kUnsupported, with its
/// code).
[[nodiscard]] Result<SntpAnswer> read_sntp_answer(ByteView packet, std::uint64_t nonce);
/// 64-bit NTP timestamp to seconds since 1970. Those without the highest bit lie behind February 2036.
[[nodiscard]] double ntp_to_unix_s(std::uint64_t timestamp);
[[nodiscard]] std::uint64_t unix_s_to_ntp(double time_s);

/// Asks one NTP server for its time, again and again, on an event loop; never blocks. Not a clock discipline:
/// it only measures. Of the loop's thread.
class SntpClient {
 public:
  struct Params {
    std::string host;
    std::uint16_t port{123};
    std::chrono::milliseconds period{16'000};       ///< between requests
    std::chrono::milliseconds first_period{2'000};  ///< between the first kQuick, to catch an idle network
    std::chrono::milliseconds timeout{2'000};       ///< of an answer
    std::chrono::milliseconds longest_period{
        300'000};  ///< the period doubles up to this while the server does not answer
  };
  /// The four times of RFC 5905: t0 and t3 by our clock, t1 and t2 by the server's [s since 1970].
  struct Sample {
    double t0{0}, t1{0}, t2{0}, t3{0};
    unsigned stratum{0};
    bool synchronised{true};
  };
  struct Handlers {
    std::function<void(const Sample&)> on_sample;
    /// No name, no answer, a refusal: once for each new reason.
    std::function<void(const std::string& problem)> on_problem;
  };
  static constexpr unsigned kQuick = 4;

  /// `loop` and `resolver` must outlive the client.
  SntpClient(EventLoop& loop, Resolver& resolver, Params params, Handlers handlers);
  ~SntpClient();
  SntpClient(const SntpClient&) = delete;
  SntpClient& operator=(const SntpClient&) = delete;

  [[nodiscard]] std::chrono::milliseconds period() const;  ///< until the next request
  [[nodiscard]] const std::string& problem() const;        ///< the latest; empty after an answer

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace extperfc::translate
