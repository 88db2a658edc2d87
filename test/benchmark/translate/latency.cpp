#include "test/benchmark/translate/latency.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>

#include <ros/node_handle.h>
#include <unistd.h>

#include "extperfc/base/running_stats.hpp"
#include "extperfc/base/stopwatch.hpp"

#include "test/benchmark/translate/parts.hpp"
#include "test/benchmark/translate/sender.hpp"

namespace extperfc::benchmark {

namespace {

constexpr double kConnectPatienceS = 30.0;
constexpr double kArrivalPatienceS = 5.0;
constexpr int kWarmUps = 20;
constexpr useconds_t kPauseUs = 1'000;  // between messages, and before CPU clocks are read

struct SizeClass {
  const char* name;
  std::uint32_t bytes;
  int divisor;  ///< of the number of samples
  double
      known_relay_us;  ///< measured before on another day (docs/performance/translator.md), for orientation
};
constexpr std::array<SizeClass, 5> kSizes{{{"200 B", 200, 1, 114},
                                           {"2 kB", 2'000, 1, 144},
                                           {"100 kB", 100'000, 1, 284},
                                           {"1 MB", 1'000'000, 4, 2'000},
                                           {"6 MB", 6'000'000, 10, 13'500}}};

enum RouteIndex : std::size_t { kDirect, kRelay, kPass, kConvert, kRoutes };

/// One route from here to a subscriber, for one size.
struct Stream {
  std::unique_ptr<Sender> sender;
  ArrivalReader* reader{nullptr};
  const Process* middle{nullptr};
  std::uint32_t index{0};  ///< in the receiver's list
  std::uint32_t arriving_size{0};
  std::vector<double> latency_us{};
  double cpu_s{0};
};

Result<double> send_and_wait(Stream& stream) {
  const auto number = stream.sender->send();
  const Stopwatch watch;
  while (watch.seconds() < kArrivalPatienceS) {
    const auto arrival = stream.reader->wait(kArrivalPatienceS);
    if (!arrival) break;
    if (arrival->topic != stream.index || arrival->number != number) continue;  // of the warm-up
    if (arrival->whole == 0 || arrival->size != stream.arriving_size)
      return fail(ErrorCode::kCorrupt, "a message of " + std::to_string(stream.arriving_size) +
                                           " bytes arrived damaged, with " + std::to_string(arrival->size));
    return 1e-3 * static_cast<double>(arrival->arrived_ns - arrival->sent_ns);
  }
  return fail(ErrorCode::kFailed,
              "a message of " + std::to_string(stream.sender->size()) + " bytes did not arrive");
}

/// The processes between us and the subscribers, and the streams through them.
class Latency {
 public:
  explicit Latency(const Stage& stage) : stage_(stage) {}

  Result<void> start();
  Result<void> measure(std::size_t size, int samples);
  [[nodiscard]] std::vector<Row> rows();

 private:
  Result<void> start_processes();
  void make_streams();
  Result<void> connect();
  Result<void> block(Stream& stream, int samples);

  const Stage& stage_;
  ros::NodeHandle handle_;
  Process relay_, bridge_, robot_receiver_, workstation_receiver_;
  std::optional<ArrivalReader> robot_reader_, workstation_reader_;
  std::array<std::array<Stream, kRoutes>, kSizes.size()> streams_;
};

std::string topic_of(const char* route, const SizeClass& size) {
  return std::string("/") + route + "/bytes_" + std::to_string(size.bytes);
}

Result<void> Latency::start_processes() {
  std::vector<std::string> relay{"relay", stage_.robot_uri()};
  std::vector<std::string> at_robot{"receiver", stage_.robot_uri()};
  std::vector<std::string> at_workstation{"receiver", stage_.workstation_uri()};
  const auto& [plain, grown_robot, grown_workstation] = stage_.definitions();
  for (const auto& size : kSizes) {
    const auto bytes = std::to_string(size.bytes);
    relay.insert(relay.end(), {topic_of("to_relay", size), topic_of("relayed", size)});
    at_robot.insert(at_robot.end(), {topic_of("direct", size), plain.type, plain.md5, bytes});
    at_robot.insert(at_robot.end(), {topic_of("relayed", size), plain.type, plain.md5, bytes});
    at_workstation.insert(at_workstation.end(), {topic_of("pass", size), plain.type, plain.md5, bytes});
    at_workstation.insert(at_workstation.end(),
                          {topic_of("convert", size), grown_workstation.type, grown_workstation.md5, bytes});
  }
  const std::array<std::pair<Process*, std::vector<std::string>>, 4> parts{
      {{&relay_, relay},
       {&bridge_, {"bridge", stage_.robot_uri(), stage_.workstation_uri(), stage_.folder().string()}},
       {&robot_receiver_, at_robot},
       {&workstation_receiver_, at_workstation}}};
  for (const auto& [process, arguments] : parts) {
    auto started = Process::start_part(arguments);
    if (!started) return tl::unexpected(started.error());
    *process = std::move(*started);
  }
  return {};
}

void Latency::make_streams() {
  robot_reader_.emplace(robot_receiver_);
  workstation_reader_.emplace(workstation_receiver_);
  const auto& definitions = stage_.definitions();
  for (std::size_t s = 0; s < kSizes.size(); ++s) {
    const auto& size = kSizes[s];
    const auto first = static_cast<std::uint32_t>(2 * s);
    const auto stream = [&](const char* route, const Definition& definition, ArrivalReader& reader,
                            const Process* middle, std::uint32_t index, std::uint32_t growth) {
      return Stream{std::make_unique<Sender>(handle_, topic_of(route, size), definition, size.bytes), &reader,
                    middle, index, size.bytes + growth};
    };
    streams_[s][kDirect] = stream("direct", definitions.plain, *robot_reader_, nullptr, first, 0);
    streams_[s][kRelay] = stream("to_relay", definitions.plain, *robot_reader_, &relay_, first + 1, 0);
    streams_[s][kPass] = stream("pass", definitions.plain, *workstation_reader_, &bridge_, first, 0);
    streams_[s][kConvert] =
        stream("convert", definitions.grown_robot, *workstation_reader_, &bridge_, first + 1, kGrowth);
  }
}

// What is published before everybody is connected is lost: small ones are sent until one arrives.
Result<void> Latency::connect() {
  const Stopwatch watch;
  for (auto& of_size : streams_) {
    for (auto& stream : of_size) {
      for (bool arrived = false; !arrived;) {
        if (watch.seconds() > kConnectPatienceS)
          return fail(ErrorCode::kFailed, "nothing arrives on " + stream.sender->topic());
        if (!stream.sender->connected()) {
          usleep(10'000);
          continue;
        }
        stream.sender->send();
        while (const auto arrival = stream.reader->wait(0.1)) arrived |= arrival->topic == stream.index;
      }
    }
  }
  return {};
}

Result<void> Latency::start() {
  if (auto started = start_processes(); !started) return started;
  make_streams();
  return connect();
}

Result<void> Latency::block(Stream& stream, int samples) {
  usleep(3 * kPauseUs);
  const double cpu_before_s = stream.middle != nullptr ? stream.middle->cpu_seconds() : 0.0;
  for (int i = 0; i < samples; ++i) {
    const auto latency_us = send_and_wait(stream);
    if (!latency_us) return tl::unexpected(latency_us.error());
    stream.latency_us.push_back(*latency_us);
    usleep(kPauseUs);
  }
  usleep(3 * kPauseUs);
  if (stream.middle != nullptr) stream.cpu_s += stream.middle->cpu_seconds() - cpu_before_s;
  return {};
}

Result<void> Latency::measure(std::size_t size, int samples) {
  for (auto& stream : streams_[size]) {
    if (auto done = block(stream, std::min(kWarmUps, samples)); !done) return done;
    stream.latency_us.clear();
    stream.cpu_s = 0;
  }
  constexpr int kBlocks = 10;
  for (int b = 0; b < kBlocks; ++b)
    for (auto& stream : streams_[size])
      if (auto done = block(stream, std::max(1, samples / kBlocks)); !done) return done;
  return {};
}

void add_latency_rows(const std::string& route, Stream& ours, Stream& relay, Stream& direct,
                      const SizeClass& size, std::vector<Row>& rows) {
  const std::string name = std::string(size.name) + ", " + route;
  for (const auto& [metric, fraction] : {std::pair{"p50", 0.5}, std::pair{"p99", 0.99}}) {
    const double value = percentile(ours.latency_us, fraction);
    const double of_relay = percentile(relay.latency_us, fraction);
    const Row row{name, std::string("latency ") + metric, "us", value, of_relay, "relay"};
    rows.push_back(fraction == 0.5 ? at_most(row, of_relay) : row);
    rows.push_back({name, std::string("latency ") + metric, "us", value,
                    percentile(direct.latency_us, fraction), "direct"});
  }
  const auto cpu_us = [](const Stream& s) {
    return 1e6 * s.cpu_s / static_cast<double>(s.latency_us.size());
  };
  rows.push_back({name, "CPU per message", "us", cpu_us(ours), cpu_us(relay), "relay"});
}

std::vector<Row> Latency::rows() {
  std::vector<Row> rows;
  for (std::size_t s = 0; s < kSizes.size(); ++s) {
    auto& streams = streams_[s];
    add_latency_rows("pass", streams[kPass], streams[kRelay], streams[kDirect], kSizes[s], rows);
    add_latency_rows("convert", streams[kConvert], streams[kRelay], streams[kDirect], kSizes[s], rows);
    rows.push_back({std::string(kSizes[s].name) + ", relay", "latency p50", "us",
                    percentile(streams[kRelay].latency_us, 0.5), kSizes[s].known_relay_us,
                    "relay, noted before"});
  }
  return rows;
}

}  // namespace

Result<std::vector<Row>> latency_rows(const Stage& stage, const TranslateOptions& options) {
  Latency latency(stage);
  if (auto started = latency.start(); !started) return tl::unexpected(started.error());
  for (std::size_t s = 0; s < kSizes.size(); ++s) {
    std::fprintf(stderr, "latency, %s\n", kSizes[s].name);
    if (auto done = latency.measure(s, options.samples / kSizes[s].divisor); !done)
      return tl::unexpected(done.error());
  }
  return latency.rows();
}

}  // namespace extperfc::benchmark
