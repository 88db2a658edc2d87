#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <unistd.h>

#include "translate/peer/socket.hpp"

namespace extperfc::translate {
namespace {

/// A socket address of either family.
struct Address {
  sockaddr_storage storage{};
  socklen_t size{0};

  [[nodiscard]] const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
};

Result<Address> make_address(const std::string& text, std::uint16_t port) {
  Address address;
  sockaddr_in v4{};
  sockaddr_in6 v6{};
  if (::inet_pton(AF_INET, text.c_str(), &v4.sin_addr) == 1) {
    v4.sin_family = AF_INET;
    v4.sin_port = htons(port);
    address.size = sizeof v4;
    std::memcpy(&address.storage, &v4, sizeof v4);
  } else if (::inet_pton(AF_INET6, text.c_str(), &v6.sin6_addr) == 1) {
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(port);
    address.size = sizeof v6;
    std::memcpy(&address.storage, &v6, sizeof v6);
  } else {
    return fail(ErrorCode::kInvalidArgument, "'" + text + "' is not a numeric address");
  }
  return address;
}

std::string text_of(const sockaddr_storage& storage) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (storage.ss_family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, &storage, sizeof v4);
    ::inet_ntop(AF_INET, &v4.sin_addr, text.data(), text.size());
  } else if (storage.ss_family == AF_INET6) {
    sockaddr_in6 v6{};
    std::memcpy(&v6, &storage, sizeof v6);
    ::inet_ntop(AF_INET6, &v6.sin6_addr, text.data(), text.size());
  }
  return text.data();
}

Result<Socket> open_socket(const Address& address) {
  Socket made(::socket(address.get()->sa_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!made) return fail(ErrorCode::kFailed, "no socket: " + system_message(errno));
  return made;
}

void set_on(int descriptor, int level, int option) {
  const int on = 1;
  ::setsockopt(descriptor, level, option, &on, sizeof on);
}

}  // namespace

void Socket::reset() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

int Socket::release() {
  const int descriptor = descriptor_;
  descriptor_ = -1;
  return descriptor;
}

std::string system_message(int error) {
  return std::generic_category().message(error);
}

Result<Socket> start_connection(const std::string& address, std::uint16_t port) {
  const auto target = make_address(address, port);
  if (!target) return tl::unexpected(target.error());
  auto made = open_socket(*target);
  if (!made) return made;
  set_on(made->get(), IPPROTO_TCP, TCP_NODELAY);
  if (::connect(made->get(), target->get(), target->size) != 0 && errno != EINPROGRESS)
    return fail(ErrorCode::kFailed, system_message(errno));
  return made;
}

int connection_error(int descriptor) {
  int error = 0;
  socklen_t size = sizeof error;
  return ::getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error, &size) == 0 ? error : errno;
}

Result<Socket> listen_at(const std::string& address, std::uint16_t port) {
  const auto own = make_address(address, port);
  if (!own) return tl::unexpected(own.error());
  auto made = open_socket(*own);
  if (!made) return made;
  set_on(made->get(), SOL_SOCKET, SO_REUSEADDR);
  if (::bind(made->get(), own->get(), own->size) != 0 || ::listen(made->get(), SOMAXCONN) != 0)
    return fail(ErrorCode::kFailed, "cannot listen at " + address + " port " + std::to_string(port) + ": " +
                                        system_message(errno));
  return made;
}

std::uint16_t port_of(int descriptor) {
  sockaddr_storage storage{};
  socklen_t size = sizeof storage;
  if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&storage), &size) != 0) return 0;
  sockaddr_in v4{};
  std::memcpy(&v4, &storage, sizeof v4);  // the port stands at the same place in both families
  return ntohs(v4.sin_port);
}

std::string peer_address_of(int descriptor) {
  sockaddr_storage storage{};
  socklen_t size = sizeof storage;
  if (::getpeername(descriptor, reinterpret_cast<sockaddr*>(&storage), &size) != 0) return {};
  return text_of(storage);
}

}  // namespace extperfc::translate
