#include "test/benchmark/map/varied_part.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "extperfc/base/rng.hpp"
#include "extperfc/offline/relations.hpp"
#include "extperfc/sources/scan_log.hpp"

#include "test/benchmark/map/carmen_writer.hpp"
#include "test/benchmark/map/log_part.hpp"
#include "test/benchmark/map/score.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::benchmark {
namespace {

using Records = std::vector<sources::ScanRecord>;

struct Variation {
  const char* name;
  std::function<void(Records&)> vary;
};

void halve_rays(Records& records) {
  for (auto& [scan, odometry, index] : records) {
    for (std::size_t i = 0; 2 * i < scan.ranges.size(); ++i) scan.ranges[i] = scan.ranges[2 * i];
    scan.ranges.resize((scan.ranges.size() + 1) / 2);
    scan.angle_increment *= 2;
  }
}

void shorten_rays(Records& records) {
  constexpr float kFarthestM = 8;
  for (auto& record : records)
    for (float& range : record.scan.ranges)
      if (range > kFarthestM) range = std::numeric_limits<float>::infinity();
}

void add_noise(Records& records) {
  constexpr double kSigmaM = 0.03;
  Rng rng(1);
  for (auto& record : records)
    for (float& range : record.scan.ranges)
      if (std::isfinite(range)) range += static_cast<float>(rng.normal(0, kSigmaM));
}

/// Keeps those whose place in the recording, modulo `period`, is at least `first`.
void keep(Records& records, std::size_t period, std::size_t first) {
  const auto is_out = [&](const sources::ScanRecord& record) { return record.index % period < first; };
  records.erase(std::remove_if(records.begin(), records.end(), is_out), records.end());
}

void reverse(Records& records) {
  if (records.empty()) return;
  const double first_s = records.front().scan.stamp_s;
  const double last_s = records.back().scan.stamp_s;
  std::reverse(records.begin(), records.end());
  for (auto& record : records) record.scan.stamp_s = first_s + last_s - record.scan.stamp_s;
}

void change_steps(Records& records, const std::function<Pose2(const Pose2&)>& changed) {
  std::optional<Pose2> before;
  Pose2 pose;
  for (auto& record : records) {
    if (!record.odom_T_base) continue;
    if (before) pose = compose(pose, changed(between(*before, *record.odom_T_base)));
    before = std::exchange(record.odom_T_base, pose);
  }
}

void bend_wheels(Records& records) {
  change_steps(records, [](const Pose2& step) {
    return Pose2{1.05 * step.x, step.y, 0.95 * step.yaw + 0.03 * std::abs(step.x)};
  });
}

void shake_wheels(Records& records) {
  Rng rng(2);
  change_steps(records, [&](const Pose2& step) {
    const double distance_m = std::hypot(step.x, step.y);
    return Pose2{step.x + rng.normal(0, 0.1 * distance_m), step.y + rng.normal(0, 0.05 * distance_m),
                 step.yaw + rng.normal(0, 0.1 * std::abs(step.yaw) + 0.1 * distance_m)};
  });
}

const std::vector<Variation>& variations() {
  static const std::vector<Variation> kAll{
      {"every second ray", halve_rays},
      {"ranges up to 8 m", shorten_rays},
      {"3 cm of noise more", add_noise},
      {"every second scan", [](Records& records) { keep(records, 2, 1); }},
      {"15 of 200 scans missing", [](Records& records) { keep(records, 200, 15); }},
      {"60 of 300 scans missing", [](Records& records) { keep(records, 300, 60); }},
      {"driven backwards", reverse},
      {"wheels 5 % and 0.03 rad/m off", bend_wheels},
      {"wheels with 10 % of noise", shake_wheels},
  };
  return kAll;
}

Result<Records> read_all(const Recording& recording) {
  auto log = sources::open_carmen_log(recording.log);
  if (!log) return tl::unexpected(log.error());
  Records records;
  while (true) {
    auto record = (*log)->next();
    if (!record) return tl::unexpected(record.error());
    if (!*record) return records;
    records.push_back(**std::move(record));
  }
}

/// The relations between those scans that are left, by their new places.
Result<std::vector<offline::Relation>> relations_left(const Records& records,
                                                      const std::filesystem::path& file) {
  const auto relations = offline::read_relations(file);
  if (!relations) return tl::unexpected(relations.error());
  std::map<std::size_t, std::size_t> place;
  for (std::size_t i = 0; i < records.size(); ++i) place[records[i].index] = i;
  std::vector<offline::Relation> left;
  for (const auto& [from, to, from_T_to] : *relations)
    if (place.count(from) != 0 && place.count(to) != 0) left.push_back({place[from], place[to], from_T_to});
  return left;
}

Result<Recording> write_varied(const Records& records, const Recording& original,
                               const std::filesystem::path& folder) {
  Recording varied{folder / "varied.log", folder / "varied.relations"};
  CarmenWriter writer(varied.log);
  for (const auto& record : records) writer.add(record.scan, record.odom_T_base.value_or(Pose2{}));
  if (auto written = writer.finish(); !written) return tl::unexpected(written.error());
  const auto relations = relations_left(records, original.relations);
  if (!relations) return tl::unexpected(relations.error());
  if (auto written = write_relations(*relations, varied.relations); !written)
    return tl::unexpected(written.error());
  return varied;
}

Result<Figures> run_varied(const Subject& subject, Records records, const Variation& variation) {
  const TemporaryFolder folder;
  variation.vary(records);
  const auto varied = write_varied(records, subject.recording, folder.path());
  if (!varied) return tl::unexpected(varied.error());
  LogRun run;
  run.recording = *varied;
  run.scans = kWholeLog;
  return run_log(run);
}

}  // namespace

Result<std::vector<Row>> varied_rows(const std::vector<Subject>& subjects) {
  std::vector<Row> rows;
  for (const auto& subject : subjects) {
    const auto records = read_all(subject.recording);
    if (!records) return tl::unexpected(records.error());
    for (const auto& variation : variations()) {
      const auto figures = run_varied(subject, *records, variation);
      if (!figures) return tl::unexpected(figures.error());
      const std::string name = subject.name + ", " + variation.name;
      std::cerr << "  " << name << ": " << summary(*figures) << std::endl;
      rows.push_back({name, "translational error", "m", figure_of(*figures, "translation_m")});
      rows.push_back({name, "rotational error", "deg", figure_of(*figures, "rotation_deg")});
      rows.push_back({name, "worst loop relation", "m", figure_of(*figures, "worst_loop_m")});
      rows.push_back({name, "CPU of the log", "s", figure_of(*figures, "cpu_s")});
    }
  }
  return rows;
}

}  // namespace extperfc::benchmark
