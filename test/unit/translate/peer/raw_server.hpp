#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include <sys/epoll.h>
#include <sys/socket.h>

#include "extperfc/translate/event_loop.hpp"

#include "translate/peer/socket.hpp"

namespace extperfc::translate {

/// A server that sends any bytes that a test wants: `on_bytes` gets what a connection sent so far.
class RawServer {
 public:
  struct Connection {
    Socket socket;
    std::string received;
    void send(const std::string& bytes) const {
      [[maybe_unused]] const auto sent = ::send(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    }
  };
  using OnBytes = std::function<void(Connection&)>;

  RawServer(EventLoop& loop, OnBytes on_bytes) : loop_(loop), on_bytes_(std::move(on_bytes)) {
    listener_ = std::move(*listen_at("127.0.0.1", 0));
    port_ = port_of(listener_.get());
    loop_.watch(listener_.get(), EPOLLIN, Priority::kNormal, [this](std::uint32_t) { accept(); });
  }
  ~RawServer() {
    loop_.unwatch(listener_.get());
    close_all();
  }
  RawServer(const RawServer&) = delete;
  RawServer& operator=(const RawServer&) = delete;

  [[nodiscard]] std::string uri() const { return "http://127.0.0.1:" + std::to_string(port_) + "/"; }
  [[nodiscard]] int accepted() const { return accepted_; }
  [[nodiscard]] std::size_t open() const { return connections_.size(); }
  void close_all() {
    for (const auto& [descriptor, connection] : connections_) loop_.unwatch(descriptor);
    connections_.clear();
  }
  void close(const Connection& connection) {
    const int descriptor = connection.socket.get();
    loop_.unwatch(descriptor);
    connections_.erase(descriptor);
  }

 private:
  void accept() {
    Socket taken(::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!taken) return;
    ++accepted_;
    const int descriptor = taken.get();
    connections_[descriptor].socket = std::move(taken);
    loop_.watch(descriptor, EPOLLIN, Priority::kNormal,
                [this, descriptor](std::uint32_t) { read(descriptor); });
  }
  void read(int descriptor) {
    std::array<char, 65536> bytes{};
    const auto count = ::recv(descriptor, bytes.data(), bytes.size(), 0);
    auto& connection = connections_[descriptor];
    if (count <= 0) return close(connection);
    connection.received.append(bytes.data(), static_cast<std::size_t>(count));
    on_bytes_(connection);
  }

  EventLoop& loop_;
  OnBytes on_bytes_;
  Socket listener_;
  std::uint16_t port_{0};
  int accepted_{0};
  std::map<int, Connection> connections_;
};

/// A client that sends any bytes that a test wants.
class RawClient {
 public:
  RawClient(EventLoop& loop, std::uint16_t port) : loop_(loop) {
    socket_ = std::move(*start_connection("127.0.0.1", port));
    loop_.watch(socket_.get(), EPOLLIN, Priority::kNormal, [this](std::uint32_t) { read(); });
  }
  ~RawClient() { loop_.unwatch(socket_.get()); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  /// False when not all of it was taken.
  bool send(const std::string& bytes) {
    return ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
           static_cast<ssize_t>(bytes.size());
  }
  [[nodiscard]] const std::string& received() const { return received_; }
  [[nodiscard]] bool closed() const { return closed_; }

 private:
  void read() {
    std::array<char, 65536> bytes{};
    const auto count = ::recv(socket_.get(), bytes.data(), bytes.size(), 0);
    if (count > 0) {
      received_.append(bytes.data(), static_cast<std::size_t>(count));
    } else {
      closed_ = true;
      loop_.unwatch(socket_.get());
    }
  }

  EventLoop& loop_;
  Socket socket_;
  std::string received_;
  bool closed_{false};
};

}  // namespace extperfc::translate
