#include "extperfc/translate/sntp_client.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>
#include <optional>
#include <random>
#include <utility>

#include <netdb.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "extperfc/translate/clock_offset.hpp"

namespace extperfc::translate {

namespace {

using std::chrono::milliseconds;

// Offsets in the packet [bytes].
constexpr std::size_t kStratumAt = 1;
constexpr std::size_t kReferenceIdAt = 12;
constexpr std::size_t kOriginateAt = 24;
constexpr std::size_t kReceiveAt = 32;
constexpr std::size_t kTransmitAt = 40;

constexpr unsigned kVersion = 4;
constexpr unsigned kClientMode = 3;
constexpr unsigned kServerMode = 4;
constexpr unsigned kNotSynchronised = 3;       ///< leap indicator
constexpr unsigned kLastStratum = 16;          ///< 16 is "not synchronised"
constexpr double kUnixOfEra0 = -2208988800.0;  ///< 1900-01-01
constexpr double kEraS = 4294967296.0;         ///< 2^32 s
constexpr std::uint64_t kHighestBit = 1ULL << 63U;

std::uint64_t read_timestamp(ByteView packet, std::size_t at) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof value; ++i) value = value << 8U | packet.data[at + i];
  return value;
}

void write_timestamp(SntpPacket& packet, std::size_t at, std::uint64_t value) {
  for (std::size_t i = 0; i < sizeof value; ++i)
    packet[at + i] = static_cast<std::uint8_t>(value >> (8U * (sizeof value - 1 - i)));
}

/// The four letters that a server with stratum 0 gives as its reason.
std::string kiss_code(ByteView packet) {
  std::string code;
  for (std::size_t i = 0; i < 4; ++i) {
    const char letter = static_cast<char>(packet.data[kReferenceIdAt + i]);
    if (letter >= 'A' && letter <= 'Z') code += letter;
  }
  return code;
}

/// A UDP socket that only hears `address`; -1 and errno on failure.
int open_socket(const std::string& address, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(address.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) {
    errno = EADDRNOTAVAIL;
    return -1;
  }
  const int descriptor = ::socket(found->ai_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const bool connected = descriptor >= 0 && ::connect(descriptor, found->ai_addr, found->ai_addrlen) == 0;
  const int reason = errno;
  ::freeaddrinfo(found);
  if (connected) {
    const int on = 1;  // the kernel notes when an answer comes: the loop may be busy then
    (void)::setsockopt(descriptor, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
    return descriptor;
  }
  if (descriptor >= 0) ::close(descriptor);
  errno = reason;
  return -1;
}

/// One datagram and when the kernel received it, by our wall clock.
struct Datagram {
  std::array<std::uint8_t, 512> bytes{};
  ssize_t size{-1};
  double received_s{0};
};

Datagram receive(int descriptor) {
  Datagram datagram;
  iovec part{datagram.bytes.data(), datagram.bytes.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(timespec))> control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  datagram.size = ::recvmsg(descriptor, &message, 0);
  datagram.received_s = wall_clock_s();
  if (datagram.size < 0) return datagram;
  for (auto* note = CMSG_FIRSTHDR(&message); note != nullptr; note = CMSG_NXTHDR(&message, note)) {
    if (note->cmsg_level != SOL_SOCKET || note->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec at{};
    std::memcpy(&at, CMSG_DATA(note), sizeof at);
    datagram.received_s = static_cast<double>(at.tv_sec) + 1e-9 * static_cast<double>(at.tv_nsec);
  }
  return datagram;
}

}  // namespace

double ntp_to_unix_s(std::uint64_t timestamp) {
  const double era_s = (timestamp & kHighestBit) != 0 ? 0.0 : kEraS;  // RFC 4330, section 3
  return static_cast<double>(timestamp >> 32U) + kUnixOfEra0 + era_s +
         static_cast<double>(timestamp & 0xFFFFFFFFU) / kEraS;
}

std::uint64_t unix_s_to_ntp(double time_s) {
  const double whole_s = std::floor(time_s);
  const auto seconds = static_cast<std::uint64_t>(static_cast<std::int64_t>(whole_s - kUnixOfEra0));
  const auto fraction = static_cast<std::uint64_t>((time_s - whole_s) * kEraS);
  return seconds << 32U | fraction;
}

SntpPacket sntp_request(std::uint64_t nonce) {
  SntpPacket packet{};
  packet[0] = kVersion << 3U | kClientMode;
  write_timestamp(packet, kTransmitAt, nonce);
  return packet;
}

Result<SntpAnswer> read_sntp_answer(ByteView packet, std::uint64_t nonce) {
  if (packet.size < kSntpBytes)
    return fail(ErrorCode::kCorrupt, "an answer of " + std::to_string(packet.size) + " bytes is too short");
  const unsigned mode = packet.data[0] & 7U;
  if (mode != kServerMode)
    return fail(ErrorCode::kCorrupt, "mode " + std::to_string(mode) + " is not a server's answer");
  if (read_timestamp(packet, kOriginateAt) != nonce)
    return fail(ErrorCode::kCorrupt, "unexpected answer: it does not match the request");
  const unsigned stratum = packet.data[kStratumAt];
  if (stratum == 0)
    return fail(ErrorCode::kUnsupported, "the server refuses to answer: '" + kiss_code(packet) + "'");
  const auto received = read_timestamp(packet, kReceiveAt);
  const auto transmitted = read_timestamp(packet, kTransmitAt);
  if (stratum > kLastStratum || received == 0 || transmitted == 0)
    return fail(ErrorCode::kCorrupt, "the answer contains no time");
  return SntpAnswer{ntp_to_unix_s(received), ntp_to_unix_s(transmitted), stratum,
                    packet.data[0] >> 6U != kNotSynchronised && stratum < kLastStratum};
}

/// One question is under way at a time; the socket is opened anew for each, so that a late answer of an
/// earlier one, or an address that changed, does no harm.
struct SntpClient::State : std::enable_shared_from_this<State> {
  struct Question {
    int descriptor{-1};
    std::uint64_t nonce{0};
    double asked_s{0};
    bool stray_noted{false};  ///< packets of other hosts are reported once per request
  };

  EventLoop& loop;
  Resolver& resolver;
  Params params;
  Handlers handlers;
  milliseconds period;
  std::mt19937_64 nonces{std::random_device{}()};
  EventLoop::TimerId timer{0};
  Question question;
  unsigned quick{0};  ///< questions asked so far, up to kQuick
  std::string problem;
  bool closed{false};

  State(EventLoop& loop_, Resolver& resolver_, Params params_, Handlers handlers_)
      : loop(loop_),
        resolver(resolver_),
        params(std::move(params_)),
        handlers(std::move(handlers_)),
        period(params.first_period) {}

  void wait(milliseconds delay) {
    loop.cancel(timer);
    timer = loop.after(delay, [this] {
      timer = 0;
      ask();
    });
  }

  void ask() {
    const std::weak_ptr<State> weak = weak_from_this();
    resolver.resolve(params.host, [weak](Result<std::string> address) {
      const auto self = weak.lock();
      if (!self || self->closed) return;
      if (!address) return self->fail_with(address.error().message);
      self->ask_at(*address);
    });
  }

  void ask_at(const std::string& address) {
    question = {open_socket(address, params.port), nonces(), 0.0, false};
    if (question.descriptor < 0) return fail_with(std::strerror(errno));
    loop.watch(question.descriptor, EPOLLIN, Priority::kControl, [this](std::uint32_t) { on_readable(); });
    const auto packet = sntp_request(question.nonce);
    question.asked_s = wall_clock_s();
    if (::send(question.descriptor, packet.data(), packet.size(), MSG_NOSIGNAL) < 0)
      return fail_with(std::strerror(errno));
    timer = loop.after(params.timeout, [this] {
      timer = 0;
      fail_with("no answer for " + std::to_string(params.timeout.count()) + " ms");
    });
  }

  void on_readable() {
    const auto datagram = receive(question.descriptor);
    if (datagram.size < 0) {
      if (errno == EAGAIN || errno == EINTR) return;
      return fail_with(std::strerror(errno));  // "connection refused": no server on that port
    }
    const ByteView bytes{datagram.bytes.data(), static_cast<std::size_t>(datagram.size)};
    const auto answer = read_sntp_answer(bytes, question.nonce);
    if (answer) return take(*answer, datagram.received_s);
    if (answer.error().code == ErrorCode::kUnsupported) {
      period = std::max(period, params.longest_period / 2);  // RFC 4330, section 8: leave it alone
      return fail_with(answer.error().message);
    }
    if (std::exchange(question.stray_noted, true)) return;
    note(answer.error().message);  // a stranger's; ours may still come
  }

  void take(const SntpAnswer& answer, double received_s) {
    const Sample sample{question.asked_s, answer.received_s, answer.transmitted_s,
                        received_s,       answer.stratum,    answer.synchronised};
    close_question();
    problem.clear();
    quick = std::min(quick + 1, kQuick);
    period = quick < kQuick ? params.first_period : params.period;
    wait(period);
    const auto alive = shared_from_this();  // the handler may destroy the client
    if (handlers.on_sample) handlers.on_sample(sample);
  }

  void fail_with(const std::string& reason) {
    close_question();
    period = std::min(std::max(period * 2, params.first_period), params.longest_period);
    wait(period);
    note(reason);
  }

  void note(const std::string& reason) {
    const auto text = "NTP server " + params.host + ":" + std::to_string(params.port) + ": " + reason;
    if (text == problem) return;
    problem = text;
    const auto alive = shared_from_this();
    if (handlers.on_problem) handlers.on_problem(text);
  }

  void close_question() {
    loop.cancel(timer);
    timer = 0;
    if (question.descriptor < 0) return;
    loop.unwatch(question.descriptor);
    ::close(question.descriptor);
    question.descriptor = -1;
  }
};

SntpClient::SntpClient(EventLoop& loop, Resolver& resolver, Params params, Handlers handlers)
    : state_(std::make_shared<State>(loop, resolver, std::move(params), std::move(handlers))) {
  state_->wait(milliseconds(0));
}

SntpClient::~SntpClient() {
  state_->closed = true;
  state_->close_question();
}

milliseconds SntpClient::period() const {
  return state_->period;
}

const std::string& SntpClient::problem() const {
  return state_->problem;
}

}  // namespace extperfc::translate
