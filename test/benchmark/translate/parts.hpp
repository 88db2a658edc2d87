#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace extperfc::benchmark {

/// What a receiver reports for every message, on kRecordDescriptor.
struct Arrival {
  std::uint32_t topic{0};   ///< its place in the receiver's list
  std::uint32_t number{0};  ///< as sent
  std::int64_t sent_ns{0};
  std::int64_t arrived_ns{0};
  std::uint32_t size{0};
  std::uint32_t whole{0};  ///< 1 when it is what was sent
};

/// Between registrations: a roscpp node's XML-RPC server queues 5 connections, and what comes at once beyond
/// that waits for TCP's retransmission, for seconds to minutes.
inline constexpr std::chrono::milliseconds kRegistrationPause{10};

/// The programs that the benchmark starts, each a process of its own. All end with their standard input.
/// They return an exit code; errors are printed on standard error.

/// Subscribes with roscpp: `arguments` are the master's URI, then topic, type, MD5 and size of the messages
/// sent (0: any), four by four.
int run_receiver(const std::vector<std::string>& arguments);
/// Republishes bytes with roscpp, as a relay of raw messages does: the master's URI, then pairs of topics.
int run_relay(const std::vector<std::string>& arguments);
/// The translator: both masters' URIs, and the folder of write_packages().
int run_bridge(const std::vector<std::string>& arguments);

/// Joins a master as a node, quietly. `name` is made unique.
void start_ros(const std::string& master_uri, const std::string& name);

}  // namespace extperfc::benchmark
