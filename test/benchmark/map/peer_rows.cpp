#include <iostream>
#include <map>
#include <string>

#include "test/benchmark/map/child.hpp"
#include "test/benchmark/map/log_part.hpp"
#include "test/benchmark/map/peer.hpp"
#include "test/benchmark/map/rows.hpp"
#include "test/benchmark/map/score.hpp"

namespace extperfc::benchmark {
namespace {

struct Line {
  const char* figure;
  const char* metric;
  const char* unit;
};

constexpr Line kLines[] = {
    {"relations", "relations", "1"},
    {"translation_m", "translational error", "m"},
    {"rotation_deg", "rotational error", "deg"},
    {"worst_loop_m", "worst loop relation", "m"},
    {"cpu_s", "CPU of the log", "s"},
    {"peak_mb", "peak memory", "MB"},
};

/// Our mapper and its peers on one recording.
class Comparison {
 public:
  Comparison(const Subject& subject, const MapOptions& options) : subject_(subject), options_(options) {}

  /// Errors: our mapper failed, or the recording cannot be read.
  Result<std::vector<Row>> rows();

 private:
  Result<void> add_program(const PeerProgram& peer);
  Result<void> add_odometry();
  Result<void> add(const std::string& peer_name, const Figures& peer, std::size_t scans);
  Result<Figures> ours(std::size_t scans);

  const Subject& subject_;
  const MapOptions& options_;
  std::map<std::size_t, Figures> ours_;  // by the number of scans
  std::vector<Row> rows_;
};

Result<std::vector<Row>> Comparison::rows() {
  for (const auto& peer : peer_programs())
    if (auto added = add_program(peer); !added) return tl::unexpected(added.error());
  if (auto added = add_odometry(); !added) return tl::unexpected(added.error());
  return rows_;
}

Result<void> Comparison::add_program(const PeerProgram& peer) {
  const auto run = run_peer(peer, subject_.recording, options_.peer_scans);
  if (run) {
    std::cerr << "  " << with_scans(subject_, run->scans) << ", " << peer.name << ": "
              << summary(run->figures) << std::endl;
    return add(peer.name, run->figures, run->scans);
  }
  if (run.error().code == ErrorCode::kNotFound) {
    std::cout << "no comparison with " << peer.name << ": " << run.error().message << "\n";
    return {};
  }
  std::cout << peer.name << " failed on " << subject_.name << ": " << run.error().message << "\n";
  return add(std::string(peer.name) + " (failed)", {}, options_.peer_scans);
}

Result<void> Comparison::add_odometry() {
  const auto figures = run_odometry(subject_.recording, options_.peer_scans);
  if (!figures) return tl::unexpected(figures.error());
  return add("odometry", *figures, options_.peer_scans);
}

Result<void> Comparison::add(const std::string& peer_name, const Figures& peer, std::size_t scans) {
  const auto run = ours(scans);
  if (!run) return tl::unexpected(run.error());
  const std::string name = with_scans(subject_, scans);
  const auto add_row = [&](const char* metric, const char* unit, double ours, double peers) {
    Row row{name, metric, unit, ours};
    row.peer = peers;
    row.peer_name = peer_name;
    rows_.push_back(row);
  };
  for (const Line& line : kLines)
    add_row(line.metric, line.unit, figure_of(*run, line.figure), figure_of(peer, line.figure));
  if (peer.count("filter_steps") > 0)
    add_row("CPU per filter step, mean", "ms", 1e3 * run->at("cpu_s") / run->at("key_frames"),
            1e3 * peer.at("cpu_s") / peer.at("filter_steps"));
  return {};
}

/// With the mapper's own parameters; each number of scans once.
Result<Figures> Comparison::ours(std::size_t scans) {
  if (const auto known = ours_.find(scans); known != ours_.end()) return known->second;
  LogRun run;
  run.recording = subject_.recording;
  run.scans = scans;
  auto figures = run_log(run);
  if (figures) ours_[scans] = *figures;
  return figures;
}

}  // namespace

Result<std::vector<Row>> peer_rows(const std::vector<Subject>& subjects, const MapOptions& options) {
  std::vector<Row> rows;
  for (const auto& subject : subjects) {
    auto more = Comparison(subject, options).rows();
    if (!more) return more;
    rows.insert(rows.end(), more->begin(), more->end());
  }
  return rows;
}

}  // namespace extperfc::benchmark
