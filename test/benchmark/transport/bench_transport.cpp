// What it costs to hand an RGB-D pair on: as pointers, serialised, and to another process. Run with --help.

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include <ros/init.h>
#include <ros/master.h>
#include <ros/node_handle.h>
#include <ros/this_node.h>

#include "extperfc/base/running_stats.hpp"
#include "extperfc/base/stopwatch.hpp"

#include "test/benchmark/report.hpp"
#include "test/benchmark/transport/pair_receiver.hpp"
#include "test/benchmark/transport/pair_sender.hpp"
#include "test/benchmark/transport/publisher_process.hpp"

namespace extperfc::benchmark {
namespace {

constexpr char kHelp[] =
    "bench_transport [--pairs N] [--json FILE]; needs a ROS master, which tools/bench starts\n"
    "  --pairs N    through each of the three transports (300)\n"
    "  --json FILE  write the results\n";

constexpr char kExplanation[] =
    "latency: from the stamp, set just before publishing, to the callback with the matched pair, on the "
    "threads of\n"
    "a nodelet manager. CPU: publisher and subscriber together, both processes, until 3 ms after the "
    "callback.\n"
    "The three transports alternate, pair by pair.\n";

constexpr double kDeadlineS = 20.0;
constexpr int kWarmUps = 10;

struct Options {
  int pairs{300};
  std::string json;
};

struct Samples {
  const char* name;
  std::vector<double> latency_us;
  std::vector<double> cpu_us;
  int same_address{0};
};

/// The three transports from a camera to its user.
class Transports {
 public:
  Transports() : ns_(ros::this_node::getName()) {}

  [[nodiscard]] Result<void> start() {
    if (auto started = process_.start(ns_ + "/tcp"); !started) return started;
    const Stopwatch watch;
    while (!pointer_sender_.connected() || !reference_sender_.connected()) {
      if (watch.seconds() > kDeadlineS)
        return fail(ErrorCode::kFailed, "the topics in this process do not connect");
      ros::WallDuration(0.005).sleep();
    }
    return wait_for_process();
  }

  [[nodiscard]] Result<void> one_of_each() {
    for (const auto transport : {&Transports::by_pointer, &Transports::by_reference, &Transports::by_process})
      if (auto done = (this->*transport)(); !done) return done;
    return {};
  }

  void forget() {
    for (auto* samples : {&pointer, &reference, &process}) *samples = Samples{samples->name, {}, {}};
  }

  Samples pointer{"pointer", {}, {}};
  Samples reference{"by reference", {}, {}};
  Samples process{"TCP", {}, {}};

 private:
  /// The other process connects in its own time; what it publishes before is lost.
  Result<void> wait_for_process() {
    const Stopwatch watch;
    while (watch.seconds() < kDeadlineS) {
      if (auto published = process_.publish(); !published) return published;
      if (process_receiver_.wait(0.1)) return {};
    }
    return fail(ErrorCode::kFailed, "nothing comes from the other process");
  }

  [[nodiscard]] double cpu_us() const { return 1e6 * (process_cpu_seconds() + process_.cpu_seconds()); }

  template <typename Send>
  Result<void> measure(PairReceiver& receiver, Samples& samples, const ImagePair* pair, const Send& send) {
    ros::WallDuration(0.003).sleep();
    receiver.clear();
    const double cpu_start_us = cpu_us();
    if (auto sent = send(); !sent) return sent;
    const auto arrival = receiver.wait(kDeadlineS);
    if (!arrival) return fail(ErrorCode::kFailed, std::string(samples.name) + ": a pair did not arrive");
    ros::WallDuration(0.003).sleep();  // what the threads still do for this pair counts too
    samples.cpu_us.push_back(cpu_us() - cpu_start_us);
    samples.latency_us.push_back(arrival->latency_us);
    samples.same_address += static_cast<int>(pair && arrival->color_data == pair->color->data.data() &&
                                             arrival->depth_data == pair->depth->data.data());
    return {};
  }

  Result<void> by_pointer() {
    const ImagePair pair = make_pair();
    return measure(pointer_receiver_, pointer, &pair, [&]() -> Result<void> {
      pointer_sender_.send_pointers(pair);
      return {};
    });
  }

  Result<void> by_reference() {
    const ImagePair pair = make_pair();
    return measure(reference_receiver_, reference, &pair, [&]() -> Result<void> {
      reference_sender_.send_references(pair);
      return {};
    });
  }

  Result<void> by_process() {
    return measure(process_receiver_, process, nullptr, [this] { return process_.publish(); });
  }

  std::string ns_;
  nodelet::detail::CallbackQueueManager manager_;
  PairReceiver pointer_receiver_{ns_ + "/pointer", manager_};
  PairReceiver reference_receiver_{ns_ + "/reference", manager_};
  PairReceiver process_receiver_{ns_ + "/tcp", manager_};
  PairSender pointer_sender_{ns_ + "/pointer"};
  PairSender reference_sender_{ns_ + "/reference"};
  PublisherProcess process_;
};

void add_rows(const char* metric, std::vector<double> Samples::*values, double fraction,
              Transports& transports, std::vector<Row>& rows) {
  const auto of = [&](Samples& samples) { return percentile(samples.*values, fraction); };
  const double ours = of(transports.pointer);
  for (Samples* peer : {&transports.reference, &transports.process}) {
    rows.push_back({"pointer", metric, "us", ours, of(*peer), peer->name});
    rows.push_back({"pointer", std::string(metric) + ": gain over " + peer->name, "x", of(*peer) / ours});
  }
}

std::vector<Row> rows_of(Transports& transports) {
  std::vector<Row> rows;
  add_rows("latency, median", &Samples::latency_us, 0.5, transports, rows);
  add_rows("latency, p95", &Samples::latency_us, 0.95, transports, rows);
  add_rows("CPU per pair, median", &Samples::cpu_us, 0.5, transports, rows);
  const auto percent_same = [](const Samples& samples) {
    return 100.0 * samples.same_address / static_cast<double>(samples.latency_us.size());
  };
  rows.push_back(at_least({"pointer", "pairs at the same address", "%", percent_same(transports.pointer),
                           percent_same(transports.reference), transports.reference.name},
                          100.0));
  return rows;
}

Result<std::vector<Row>> measure(const Options& options) {
  Transports transports;
  if (auto started = transports.start(); !started) return tl::unexpected(started.error());
  for (int i = 0; i < kWarmUps; ++i)
    if (auto done = transports.one_of_each(); !done) return tl::unexpected(done.error());
  transports.forget();
  for (int i = 0; i < options.pairs; ++i)
    if (auto done = transports.one_of_each(); !done) return tl::unexpected(done.error());
  return rows_of(transports);
}

std::optional<Options> parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; i += 2) {
    if (i + 1 >= argc) return std::nullopt;
    const char* const value = argv[i + 1];
    const char* const end = value + std::strlen(value);
    if (std::strcmp(argv[i], "--json") == 0) {
      options.json = value;
    } else if (std::strcmp(argv[i], "--pairs") == 0) {
      if (std::from_chars(value, end, options.pairs).ptr != end || options.pairs < 1) return std::nullopt;
    } else {
      return std::nullopt;
    }
  }
  return options;
}

int complain(const std::string& message) {
  std::cerr << "bench_transport: " << message << "\n";
  return 1;
}

int run(const Options& options) {
  const Stopwatch watch;
  const auto rows = measure(options);
  if (!rows) return complain(rows.error().message);
  std::printf("%s\n%d pairs of 640 x 480 (rgb8, 16UC1) in each direction\n%s\n",
              machine_description().c_str(), options.pairs, kExplanation);
  std::fflush(stdout);
  print_table(std::cout, *rows);
  std::cout << "\n" << watch.seconds() << " s\n";
  if (options.json.empty() || write_json(options.json, "transport", *rows)) return 0;
  return complain("cannot write " + options.json);
}

int main_program(int argc, char** argv) {
  const bool help = argc == 2 && (std::strcmp(argv[1], "--help") == 0 || std::strcmp(argv[1], "-h") == 0);
  const auto options = parse(argc, argv);
  if (help || !options) {
    (help ? std::cout : std::cerr) << kHelp;
    return help ? 0 : 2;
  }
  if (!ros::master::check()) return complain("no ROS master: start this with tools/bench transport");
  ros::NodeHandle handle;
  ros::AsyncSpinner connections(1);  // of the publishers
  connections.start();
  return run(*options);
}

}  // namespace
}  // namespace extperfc::benchmark

int main(int argc, char** argv) {
  const bool is_child = argc == 3 && std::strcmp(argv[1], "--child") == 0;
  ros::init(argc, argv, is_child ? "bench_transport_publisher" : "bench_transport",
            ros::init_options::AnonymousName);
  return is_child ? extperfc::benchmark::serve_as_publisher(argv[2])
                  : extperfc::benchmark::main_program(argc, argv);
}
