#include "test/benchmark/translate/load.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include <ros/node_handle.h>
#include <unistd.h>

#include "extperfc/base/running_stats.hpp"
#include "extperfc/base/stopwatch.hpp"

#include "test/benchmark/translate/parts.hpp"
#include "test/benchmark/translate/sender.hpp"

namespace extperfc::benchmark {

namespace {

constexpr std::uint32_t kMessageBytes = 200;
constexpr int kConvertEvery = 5;  // every fifth topic has a type that differs
constexpr double kConnectPatienceS = 120.0;
constexpr double kWarmUpS = 2.0;
constexpr double kDrainS = 1.0;
constexpr useconds_t kTickUs = 1'000;

struct Measured {
  std::vector<double> latency_us;
  std::int64_t begin_ns{0};
  double seconds{0};
  double sent{0}, arrived{0}, damaged{0};
  double middle_cpu_s{0}, sender_cpu_s{0}, receiver_cpu_s{0};
  double resident_before_mb{0}, resident_after_mb{0};
};

/// Many topics through one process in the middle.
class Load {
 public:
  Load(const Stage& stage, const TranslateOptions& options) : stage_(stage), options_(options) {}

  Result<void> start_translator();
  Result<void> start_relay();
  Result<Measured> measure();

 private:
  Result<void> start(const std::vector<std::string>& middle, const std::vector<std::string>& receiver);
  Result<void> connect();
  void send_for(double seconds, Measured* measured);
  void collect(Measured* measured);
  [[nodiscard]] bool converts(int topic) const { return translator_ && topic % kConvertEvery == 0; }
  void advertise(const std::string& prefix);

  const Stage& stage_;
  const TranslateOptions& options_;
  ros::NodeHandle handle_;
  bool translator_{false};
  std::vector<std::unique_ptr<Sender>> senders_;
  Process middle_, receiver_;  // end before the senders, of which they would miss every topic
  std::unique_ptr<ArrivalReader> reader_;
};

std::string topic_of(const std::string& prefix, int topic) {
  return prefix + "/topic_" + std::to_string(topic);
}

Result<void> Load::start_translator() {
  translator_ = true;
  std::vector<std::string> receiver{"receiver", stage_.workstation_uri()};
  for (int t = 0; t < options_.topics; ++t) {
    const auto& definition =
        converts(t) ? stage_.definitions().grown_workstation : stage_.definitions().plain;
    receiver.insert(receiver.end(),
                    {topic_of("/load", t), definition.type, definition.md5, std::to_string(kMessageBytes)});
  }
  advertise("/load");
  return start({"bridge", stage_.robot_uri(), stage_.workstation_uri(), stage_.folder().string()}, receiver);
}

Result<void> Load::start_relay() {
  std::vector<std::string> receiver{"receiver", stage_.robot_uri()};
  std::vector<std::string> relay{"relay", stage_.robot_uri()};
  for (int t = 0; t < options_.topics; ++t) {
    const auto to = topic_of("/relayed_load", t);
    relay.insert(relay.end(), {topic_of("/load_to_relay", t), to});
    const auto& definition = stage_.definitions().plain;
    receiver.insert(receiver.end(), {to, definition.type, definition.md5, std::to_string(kMessageBytes)});
  }
  advertise("/load_to_relay");
  return start(relay, receiver);
}

void Load::advertise(const std::string& prefix) {
  for (int t = 0; t < options_.topics; ++t) {
    const auto& definition = converts(t) ? stage_.definitions().grown_robot : stage_.definitions().plain;
    senders_.push_back(std::make_unique<Sender>(handle_, topic_of(prefix, t), definition, kMessageBytes));
  }
}

Result<void> Load::start(const std::vector<std::string>& middle, const std::vector<std::string>& receiver) {
  for (const auto& [process, arguments] : {std::pair{&middle_, &middle}, std::pair{&receiver_, &receiver}}) {
    auto started = Process::start_part(*arguments);
    if (!started) return tl::unexpected(started.error());
    *process = std::move(*started);
  }
  reader_ = std::make_unique<ArrivalReader>(receiver_);
  return connect();
}

// A few messages of every topic until all have arrived once: what is published before is lost.
Result<void> Load::connect() {
  const Stopwatch watch;
  std::set<std::uint32_t> missing;
  for (std::uint32_t t = 0; t < senders_.size(); ++t) missing.insert(t);
  while (!missing.empty()) {
    if (watch.seconds() > kConnectPatienceS)
      return fail(ErrorCode::kFailed, std::to_string(missing.size()) + " of " +
                                          std::to_string(senders_.size()) +
                                          " topics under load do not arrive");
    for (const auto t : missing) {
      if (!senders_[t]->connected()) continue;
      senders_[t]->send();  // at the first the relay advertises
      std::this_thread::sleep_for(kRegistrationPause);
    }
    usleep(200'000);
    for (const auto& arrival : reader_->read_all()) missing.erase(arrival.topic);
  }
  usleep(500'000);
  (void)reader_->read_all();
  return {};
}

void Load::collect(Measured* measured) {
  for (const auto& arrival : reader_->read_all()) {
    if (measured == nullptr || arrival.sent_ns < measured->begin_ns) continue;  // of the warm-up
    measured->arrived += 1;
    measured->damaged += arrival.whole == 0 ? 1 : 0;
    measured->latency_us.push_back(1e-3 * static_cast<double>(arrival.arrived_ns - arrival.sent_ns));
  }
}

// In steps of a millisecond, topic after topic; what a step was late, the next makes up.
void Load::send_for(double seconds, Measured* measured) {
  const Stopwatch watch;
  std::size_t next = 0;
  double sent = 0;
  while (watch.seconds() < seconds) {
    const double due = std::floor(watch.seconds() * options_.rate_hz);
    for (; sent < due; ++sent) senders_[next++ % senders_.size()]->send();
    collect(measured);
    usleep(kTickUs);
  }
  if (measured == nullptr) return;
  measured->seconds = watch.seconds();
  measured->sent = sent;
}

Result<Measured> Load::measure() {
  constexpr double kBytesPerMb = 1e6;
  send_for(kWarmUpS, nullptr);
  usleep(static_cast<useconds_t>(1e6 * kDrainS));
  collect(nullptr);
  Measured measured;
  measured.begin_ns = monotonic_ns();
  measured.latency_us.reserve(static_cast<std::size_t>(options_.seconds * options_.rate_hz * 1.1));
  measured.resident_before_mb = static_cast<double>(middle_.resident_bytes()) / kBytesPerMb;
  const double middle_s = middle_.cpu_seconds();
  const double receiver_s = receiver_.cpu_seconds();
  const double sender_s = process_cpu_seconds();
  send_for(options_.seconds, &measured);
  measured.middle_cpu_s = middle_.cpu_seconds() - middle_s;
  measured.receiver_cpu_s = receiver_.cpu_seconds() - receiver_s;
  measured.sender_cpu_s = process_cpu_seconds() - sender_s;
  const Stopwatch drain;
  while (drain.seconds() < kDrainS) {
    collect(&measured);
    usleep(kTickUs);
  }
  measured.resident_after_mb = static_cast<double>(middle_.resident_bytes()) / kBytesPerMb;
  if (!middle_.alive()) return fail(ErrorCode::kFailed, "the process in the middle died under load");
  return measured;
}

std::vector<Row> rows_of(Measured& ours, Measured& relay, const TranslateOptions& options) {
  const std::string name = std::to_string(options.topics) + " topics, " +
                           std::to_string(static_cast<int>(options.rate_hz)) + " messages/s";
  std::vector<Row> rows;
  const auto add = [&](const char* metric, const char* unit, double value, double of_relay) {
    rows.push_back({name, metric, unit, value, of_relay, "relay"});
  };
  add("delivered", "1/s", ours.arrived / ours.seconds, relay.arrived / relay.seconds);
  rows.back() = at_least(rows.back(), 0.99 * options.rate_hz);
  add("lost", "%", 100.0 * (1.0 - ours.arrived / ours.sent), 100.0 * (1.0 - relay.arrived / relay.sent));
  add("damaged", "", ours.damaged, relay.damaged);
  rows.back() = at_most(rows.back(), 0.0);
  add("latency p50", "us", percentile(ours.latency_us, 0.5), percentile(relay.latency_us, 0.5));
  add("latency p99", "us", percentile(ours.latency_us, 0.99), percentile(relay.latency_us, 0.99));
  const auto cores = [](double cpu_s, const Measured& m) { return cpu_s / m.seconds; };
  add("CPU", "cores", cores(ours.middle_cpu_s, ours), cores(relay.middle_cpu_s, relay));
  add("CPU per message", "us", 1e6 * ours.middle_cpu_s / ours.arrived,
      1e6 * relay.middle_cpu_s / relay.arrived);
  add("CPU of publisher and subscriber", "cores", cores(ours.sender_cpu_s + ours.receiver_cpu_s, ours),
      cores(relay.sender_cpu_s + relay.receiver_cpu_s, relay));
  add("resident memory before", "MB", ours.resident_before_mb, relay.resident_before_mb);
  add("resident memory after", "MB", ours.resident_after_mb, relay.resident_after_mb);
  rows.back() = at_most(rows.back(), 1.1 * ours.resident_before_mb + 5.0);
  return rows;
}

Result<Measured> measure_one(const Stage& stage, const TranslateOptions& options,
                             Result<void> (Load::*start)()) {
  Load load(stage, options);
  if (auto started = (load.*start)(); !started) return tl::unexpected(started.error());
  return load.measure();
}

}  // namespace

Result<std::vector<Row>> load_rows(const Stage& stage, const TranslateOptions& options) {
  std::fprintf(stderr, "load, translator\n");
  auto ours = measure_one(stage, options, &Load::start_translator);
  if (!ours) return tl::unexpected(ours.error());
  std::fprintf(stderr, "load, relay\n");
  auto relay = measure_one(stage, options, &Load::start_relay);
  if (!relay) return tl::unexpected(relay.error());
  return rows_of(*ours, *relay, options);
}

}  // namespace extperfc::benchmark
