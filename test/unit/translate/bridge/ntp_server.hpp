#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "extperfc/translate/clock_offset.hpp"
#include "extperfc/translate/event_loop.hpp"
#include "extperfc/translate/sntp_client.hpp"

namespace extperfc::translate {

/// An NTP server on the test's own event loop, whose answers the test spoils.
class NtpServer {
 public:
  using Packet = std::vector<std::uint8_t>;
  /// Gets the right answer; what it returns is sent, unless it is empty.
  using Spoil = std::function<Packet(Packet answer)>;

  NtpServer(EventLoop& loop, double offset_s, Spoil spoil = nullptr)
      : loop_(loop), offset_s_(offset_s), spoil_(std::move(spoil)) {
    descriptor_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (::bind(descriptor_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        ::getsockname(descriptor_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
      throw std::runtime_error("no UDP port on 127.0.0.1");
    port_ = ntohs(address.sin_port);
    loop_.watch(descriptor_, EPOLLIN, Priority::kNormal, [this](std::uint32_t) { answer(); });
  }
  ~NtpServer() {
    loop_.unwatch(descriptor_);
    ::close(descriptor_);
  }
  NtpServer(const NtpServer&) = delete;
  NtpServer& operator=(const NtpServer&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] int questions() const { return questions_; }
  void spoil(Spoil spoil) { spoil_ = std::move(spoil); }

 private:
  void answer() {
    Packet packet(100);
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const auto count =
        ::recvfrom(descriptor_, packet.data(), packet.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
    if (count < 0) return;
    ++questions_;
    packet.resize(static_cast<std::size_t>(count));
    Packet answer(kSntpBytes);
    answer[0] = 4U << 3U | 4U;  // version 4, server
    answer[1] = 2;              // stratum
    std::copy(packet.begin() + 40, packet.begin() + 48, answer.begin() + 24);
    const auto now = unix_s_to_ntp(wall_clock_s() + offset_s_);
    for (std::size_t i = 0; i < 8; ++i)
      answer[32 + i] = answer[40 + i] = static_cast<std::uint8_t>(now >> (8U * (7 - i)));
    if (spoil_) answer = spoil_(std::move(answer));
    if (!answer.empty())
      (void)::sendto(descriptor_, answer.data(), answer.size(), 0, reinterpret_cast<sockaddr*>(&from), size);
  }

  EventLoop& loop_;
  double offset_s_;
  Spoil spoil_;
  int descriptor_{-1};
  std::uint16_t port_{0};
  int questions_{0};
};

}  // namespace extperfc::translate
