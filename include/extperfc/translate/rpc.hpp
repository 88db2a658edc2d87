#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/event_loop.hpp"

/// XML-RPC over HTTP on an event loop: bounded, with deadlines, for several masters in one process.
/// Source: http://xmlrpc.com/spec.md; what rosmaster, rospy and roscpp of Indigo and Noetic send.
namespace extperfc::translate {

struct XmlValue;
using XmlArray = std::vector<XmlValue>;
using XmlStruct = std::map<std::string, XmlValue>;
struct XmlBinary {
  std::string bytes;
};
struct XmlDateTime {
  std::string text;  ///< as written: 20061121T09:30:00
};

/// A value of XML-RPC. Integers have 32 bits (`nil` is an extension that is read, and written as an empty
/// string).
struct XmlValue {
  std::variant<std::monostate, bool, std::int32_t, double, std::string, XmlBinary, XmlDateTime, XmlArray,
               XmlStruct>
      data;

  XmlValue() = default;
  XmlValue(bool value) : data(value) {}                      // NOLINT(google-explicit-constructor)
  XmlValue(std::int32_t value) : data(value) {}              // NOLINT(google-explicit-constructor)
  XmlValue(double value) : data(value) {}                    // NOLINT(google-explicit-constructor)
  XmlValue(std::string value) : data(std::move(value)) {}    // NOLINT(google-explicit-constructor)
  XmlValue(const char* value) : data(std::string(value)) {}  // NOLINT(google-explicit-constructor)
  XmlValue(XmlArray value) : data(std::move(value)) {}       // NOLINT(google-explicit-constructor)
  XmlValue(XmlStruct value) : data(std::move(value)) {}      // NOLINT(google-explicit-constructor)
  XmlValue(XmlBinary value) : data(std::move(value)) {}      // NOLINT(google-explicit-constructor)

  template <typename T>
  [[nodiscard]] const T* as() const {  ///< null when it is another kind
    return std::get_if<T>(&data);
  }
};
[[nodiscard]] bool operator==(const XmlValue& a, const XmlValue& b);

/// Bounds on what strangers may send.
struct RpcLimits {
  std::size_t header_bytes{16U << 10U};
  std::size_t body_bytes{
      16U << 20U};        ///< a getSystemState of a large robot has some 200 kB, a URDF parameter 1 MB
  std::size_t depth{32};  ///< values within values
  std::size_t values{1U << 20U};  ///< in one call or answer, so that empty ones cannot fill the memory
  std::size_t buffered_bytes{64U << 20U};     ///< of all connections of a server together
  std::size_t connections{512};               ///< of a server at once; more are closed at once
  std::chrono::milliseconds idle{60'000};     ///< a server closes a connection that is silent for so long
  std::chrono::milliseconds request{10'000};  ///< from a request's first byte to its last
};

[[nodiscard]] std::string encode_call(const std::string& method, const XmlArray& arguments);
[[nodiscard]] std::string encode_response(const XmlValue& value);
[[nodiscard]] std::string encode_fault(int code, const std::string& reason);
struct XmlCall {
  std::string method;
  XmlArray arguments;
};
[[nodiscard]] Result<XmlCall> decode_call(std::string_view xml, const RpcLimits& limits = {});
/// A fault is an error with the fault's text.
[[nodiscard]] Result<XmlValue> decode_response(std::string_view xml, const RpcLimits& limits = {});

struct HostPort {
  std::string host;
  std::uint16_t port{0};
};
/// "http://host:port/" or "rosrpc://host:port"; IPv6 in brackets.
[[nodiscard]] Result<HostPort> parse_uri(std::string_view uri);

/// Names to addresses: the table first, then the system, in a thread of its own, because that may take
/// seconds.
class Resolver {
 public:
  using Done = std::function<void(Result<std::string> address)>;  ///< numeric IPv4 or IPv6
  /// `remedy` is what the error of a name without an address advises.
  Resolver(EventLoop& loop, std::map<std::string, std::string> table,
           std::string remedy = "add it to /etc/hosts");
  ~Resolver();
  Resolver(const Resolver&) = delete;
  Resolver& operator=(const Resolver&) = delete;
  /// `done` runs on the loop; at once, inside this call, for table entries, numbers, and names found of late.
  void resolve(const std::string& host, Done done);

 private:
  struct State;
  std::shared_ptr<State> state_;
};

/// Calls without blocking. Connections are kept open between calls and opened again when the server closed
/// them.
class RpcClient {
 public:
  using Done = std::function<void(Result<XmlValue> response)>;
  RpcClient(EventLoop& loop, Resolver& resolver, RpcLimits limits = {});
  ~RpcClient();  ///< calls under way are forgotten: their `done` never runs
  RpcClient(const RpcClient&) = delete;
  RpcClient& operator=(const RpcClient&) = delete;

  /// `done` runs exactly once, later, on the loop: with the answer, or an error that names the URI and the
  /// method (no route, refused, timeout, not XML-RPC, fault). At most `kWaiting` calls wait for one server:
  /// more fail at once.
  void call(const std::string& uri, const std::string& method, XmlArray arguments,
            std::chrono::milliseconds timeout, Done done);
  static constexpr std::size_t kWaiting = 1000;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

/// Answers calls of others on one port.
class RpcServer {
 public:
  using Answer = std::function<XmlValue(const XmlCall& call, const std::string& peer_address)>;
  RpcServer(EventLoop& loop, RpcLimits limits = {});
  ~RpcServer();
  RpcServer(const RpcServer&) = delete;
  RpcServer& operator=(const RpcServer&) = delete;

  /// Listens; `port` 0 takes a free one. Unknown methods are for `answer` too; what it throws becomes a
  /// fault.
  [[nodiscard]] Result<std::uint16_t> open(const std::string& bind_address, std::uint16_t port,
                                           Answer answer);
  void close();

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace extperfc::translate
