#pragma once

#include <cstdint>
#include <string>

#include <sys/socket.h>

#include "extperfc/base/error.hpp"

namespace extperfc::translate {

/// A socket that closes itself.
class Socket {
 public:
  Socket() = default;
  explicit Socket(int descriptor) : descriptor_(descriptor) {}
  ~Socket() { reset(); }
  Socket(Socket&& other) noexcept : descriptor_(other.release()) {}
  Socket& operator=(Socket&& other) noexcept {
    if (this != &other) {
      reset();
      descriptor_ = other.release();
    }
    return *this;
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  [[nodiscard]] int get() const { return descriptor_; }
  [[nodiscard]] explicit operator bool() const { return descriptor_ >= 0; }
  void reset();
  int release();

 private:
  int descriptor_{-1};
};

/// What the system says about an errno.
[[nodiscard]] std::string system_message(int error);

/// Begins a connection to a numeric address, without blocking: writable when it stands or failed.
[[nodiscard]] Result<Socket> start_connection(const std::string& address, std::uint16_t port);
/// What became of it: 0 or an errno.
[[nodiscard]] int connection_error(int descriptor);
/// A listening socket, without blocking. `port` 0 takes a free one.
[[nodiscard]] Result<Socket> listen_at(const std::string& address, std::uint16_t port);
[[nodiscard]] std::uint16_t port_of(int descriptor);
/// Of the other end, numeric; "" when it is gone.
[[nodiscard]] std::string peer_address_of(int descriptor);

}  // namespace extperfc::translate
