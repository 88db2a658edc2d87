#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "extperfc/translate/tcpros.hpp"

namespace extperfc::translate::testing {

/// A stranger's socket at 127.0.0.1, without any manners. Never blocks.
class RawSocket {
 public:
  RawSocket() = default;
  explicit RawSocket(int descriptor) : descriptor_(descriptor) {}
  RawSocket(RawSocket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  RawSocket& operator=(RawSocket&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  RawSocket(const RawSocket&) = delete;
  RawSocket& operator=(const RawSocket&) = delete;
  ~RawSocket() { close(); }

  static RawSocket connect_to(std::uint16_t port) {
    RawSocket made(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    const auto address = local(port);
    ::connect(made.descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
    return made;
  }
  static RawSocket listen_on_any(std::uint16_t& port) {
    RawSocket made(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    auto address = local(0);
    ::bind(made.descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
    ::listen(made.descriptor_, 16);
    socklen_t size = sizeof(address);
    ::getsockname(made.descriptor_, reinterpret_cast<sockaddr*>(&address), &size);
    port = ntohs(address.sin_port);
    return made;
  }
  [[nodiscard]] RawSocket accept() const {
    return RawSocket(::accept4(descriptor_, nullptr, nullptr, SOCK_CLOEXEC));
  }

  [[nodiscard]] explicit operator bool() const { return descriptor_ >= 0; }
  [[nodiscard]] int get() const { return descriptor_; }
  void close() {
    if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  }

  /// False when the other end closed or reset the connection.
  bool send(const void* bytes, std::size_t size) const {
    return ::send(descriptor_, bytes, size, MSG_NOSIGNAL | MSG_DONTWAIT) >= 0;
  }
  bool send(const std::string& bytes) const { return send(bytes.data(), bytes.size()); }
  bool send(const ConnectionHeader& header) const {
    const auto bytes = encode_header(header);
    return send(bytes.data(), bytes.size());
  }
  /// Collects what has come; true when the other end has closed.
  bool drain() {
    char some[65536];
    for (;;) {
      const auto got = ::recv(descriptor_, some, sizeof(some), MSG_DONTWAIT);
      if (got == 0 || (got < 0 && errno != EAGAIN && errno != EWOULDBLOCK)) return true;
      if (got < 0) return false;
      received.append(some, static_cast<std::size_t>(got));
    }
  }
  /// The first connection header that came, or an empty one.
  [[nodiscard]] ConnectionHeader header() const {
    if (received.size() < 4) return {};
    std::uint32_t size = 0;
    for (unsigned i = 0; i < 4; ++i)
      size |= static_cast<std::uint32_t>(static_cast<std::uint8_t>(received[i])) << (8U * i);
    if (received.size() < 4 + std::size_t{size}) return {};
    const auto decoded = decode_header({reinterpret_cast<const std::uint8_t*>(received.data()) + 4, size});
    return decoded ? *decoded : ConnectionHeader{};
  }

  std::string received;

 private:
  static sockaddr_in local(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
  }

  int descriptor_{-1};
};

/// A uint32 as TCPROS writes it.
inline std::string little_endian(std::uint32_t value) {
  std::string bytes;
  for (unsigned i = 0; i < 4; ++i) bytes.push_back(static_cast<char>(value >> (8U * i)));
  return bytes;
}

}  // namespace extperfc::translate::testing
