#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/event_loop.hpp"
#include "extperfc/translate/rpc.hpp"
#include "extperfc/translate/tcpros.hpp"

#include "translate/peer/tcpros_socket.hpp"

namespace extperfc::translate {

/// Receives one connection header and not a byte more.
class HeaderReader {
 public:
  enum class Outcome : std::uint8_t { kWaiting, kDone, kFailed };
  explicit HeaderReader(std::size_t header_bytes) : max_bytes_(header_bytes) {}

  [[nodiscard]] Outcome read(int descriptor);
  [[nodiscard]] ConnectionHeader& header() { return header_; }
  [[nodiscard]] std::size_t held_bytes() const { return body_.size(); }
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  [[nodiscard]] Outcome fail_with(std::string problem);
  [[nodiscard]] Outcome length_is_known();

  std::size_t max_bytes_;
  std::array<std::uint8_t, 4> length_{};
  std::size_t have_{0}, size_{0};
  ByteBuffer body_;
  ConnectionHeader header_;
  std::string problem_;
};

/// Writes bytes to a socket that may be full.
class BytesWriter {
 public:
  enum class Outcome : std::uint8_t { kEmpty, kBlocked, kBroken };
  /// Sends at once what the socket takes; copies what is left.
  [[nodiscard]] Outcome write(int descriptor, ByteView head, ByteView body);
  [[nodiscard]] Outcome flush(int descriptor);
  [[nodiscard]] bool empty() const { return at_ == rest_.size(); }
  [[nodiscard]] std::uint64_t bytes_written() const { return written_; }

 private:
  ByteBuffer rest_;
  std::size_t at_{0};
  std::uint64_t written_{0};
};

/// A connection whose header has come in.
struct Incoming {
  LoopSocket socket;
  ConnectionHeader header;
  std::string remote_address;
};

/// The one port for topics and services. Large headers together are bounded too. Strangers get `handshake` to
/// send a header; when too many are at it, the one that took longest is closed, so that a flood does not keep
/// others out. `own` goes into refusals.
class TcprosListener {
 public:
  using OnIncoming = std::function<void(Incoming)>;
  TcprosListener(EventLoop& loop, TcprosParams params, ConnectionHeader own, OnIncoming on_incoming);
  ~TcprosListener();
  TcprosListener(const TcprosListener&) = delete;
  TcprosListener& operator=(const TcprosListener&) = delete;

  [[nodiscard]] Result<std::uint16_t> open(const std::string& bind_address);
  void close();
  [[nodiscard]] std::size_t handshakes() const;  ///< under way

 private:
  struct State;
  std::shared_ptr<State> state_;
};

/// A connection of ours whose handshake is done; `header` may hold an `error`.
struct Outgoing {
  LoopSocket socket;
  ConnectionHeader header;
};

/// Connects, sends a header, receives one. Destroying it gives up.
class TcprosConnector {
 public:
  using Done = std::function<void(Result<Outgoing>)>;
  struct Params {
    HostPort to;
    ConnectionHeader header;
    std::chrono::milliseconds timeout{0};  ///< from now to the other's header
    Priority priority{Priority::kNormal};
    TcprosParams tcpros;
  };
  /// `done` runs once, later or inside this call's events, never after the destructor.
  TcprosConnector(EventLoop& loop, Resolver& resolver, Params params, Done done);
  ~TcprosConnector();
  TcprosConnector(const TcprosConnector&) = delete;
  TcprosConnector& operator=(const TcprosConnector&) = delete;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace extperfc::translate
