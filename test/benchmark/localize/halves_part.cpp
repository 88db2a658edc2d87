#include "test/benchmark/localize/halves_part.hpp"

#include <algorithm>
#include <iostream>
#include <memory>
#include <numeric>
#include <optional>

#include "extperfc/base/running_stats.hpp"

#include "test/benchmark/localize/rows.hpp"
#include "test/benchmark/localize/trials.hpp"

namespace extperfc::benchmark {
namespace {

constexpr int kTrackingParticles = 5000;  // at most, as in config/localizer.yaml
constexpr int kSearchParticles = 10000;
/// 10 s of a robot that stands, at two updates a second (config/localizer.yaml); 4 m of one that drives.
constexpr std::size_t kInTime = 20;

/// Figures of one filter over several drives.
struct Tracking {
  std::vector<double> off_m;
  std::vector<double> off_deg;
  std::size_t losses{0};
  std::size_t on_return{0};
  std::size_t unrecovered{0};
  std::size_t falsely_certain{0};
};

void add_drive(const std::vector<Outcome>& outcomes, Tracking& tracking) {
  constexpr std::size_t kSettled = 10;  // updates
  for (std::size_t i = kSettled; i < outcomes.size(); ++i) {
    if (!outcomes[i].known) continue;
    tracking.off_m.push_back(outcomes[i].off_m);
    tracking.off_deg.push_back(outcomes[i].off_deg);
    tracking.falsely_certain += outcomes[i].falsely_certain();
  }
  for (const Loss& loss : find_losses(outcomes)) {
    ++tracking.losses;
    tracking.on_return += loss.on_return;
    tracking.unrecovered += !loss.updates;
  }
}

double mean_of(const std::vector<double>& values) {
  return values.empty()
             ? 0
             : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Trials of being found.
struct Found {
  std::size_t trials{0};
  std::size_t right{0};
  std::size_t in_time{0};
  std::size_t certain_at_end{0};  ///< more than 1 m wrong
  std::vector<double> updates;    ///< until right, of those found
};

void add_trial(const std::vector<Outcome>& outcomes, Found& found) {
  ++found.trials;
  found.certain_at_end += outcomes.back().falsely_certain();
  const auto updates = updates_until_right(outcomes);
  if (!updates) return;
  ++found.right;
  found.in_time += *updates <= kInTime;
  found.updates.push_back(static_cast<double>(*updates));
}

/// One direction of one log.
class Direction {
 public:
  Direction(const std::string& log, const Recording& recording, Half mapped, const HalvesOptions& options)
      : name_(log + (mapped == Half::kFirst ? ", map of the first half" : ", map of the second half")),
        options_(options),
        half_(make_half_case(recording, mapped)) {}

  void measure(std::vector<Row>& rows);

 private:
  using Make = std::unique_ptr<Subject> (Direction::*)(int max_particles, std::uint64_t seed) const;

  [[nodiscard]] std::unique_ptr<Subject> ours(int max_particles, std::uint64_t seed) const {
    localize::LocalizerParams params;
    params.max_particles = max_particles;
    params.seed = seed;
    return make_ours(half_.map, params);
  }
  [[nodiscard]] std::unique_ptr<Subject> theirs(int max_particles, std::uint64_t) const {
    return make_theirs(*half_.map, 500, max_particles, half_.recording->scans[0].ranges.size());
  }
  [[nodiscard]] std::optional<Tracking> track(Make make) const;
  [[nodiscard]] std::optional<Found> find(Make make) const;
  template <typename Trial>
  [[nodiscard]] Found kidnap(Trial trial) const;
  void count_rows(std::vector<Row>& rows) const;
  void track_rows(std::vector<Row>& rows) const;
  void find_rows(std::vector<Row>& rows) const;
  void kidnap_rows(const std::string& how, Found found, std::vector<Row>& rows) const;

  std::string name_;
  HalvesOptions options_;
  HalfCase half_;
};

std::optional<Tracking> Direction::track(Make make) const {
  Tracking tracking;
  for (std::uint64_t seed = options_.first_seed;
       seed < options_.first_seed + static_cast<std::uint64_t>(options_.seeds); ++seed) {
    const auto subject = (this->*make)(kTrackingParticles, seed);
    if (!subject) return std::nullopt;
    const auto steps = steps_of(half_, seed);
    const auto starts = known_starts(steps, 1, steps.size());
    if (starts.empty()) return std::nullopt;
    subject->begin_at(half_.recording->truth[steps[starts[0]].scan]);
    add_drive(follow(*subject, half_, steps, starts[0], steps.size()), tracking);
  }
  return tracking;
}

std::optional<Found> Direction::find(Make make) const {
  const auto subject = (this->*make)(kSearchParticles, options_.first_seed);
  if (!subject) return std::nullopt;
  Found found;
  const auto steps = steps_of(half_, options_.first_seed);
  for (const std::size_t start : known_starts(steps, kWindow, options_.starts)) {
    subject->initialize_globally();
    add_trial(follow(*subject, half_, steps, start, start + kWindow), found);
  }
  return found;
}

template <typename Trial>
Found Direction::kidnap(Trial trial) const {
  Found found;
  const auto subject = ours(kTrackingParticles, options_.first_seed);
  const auto steps = steps_of(half_, options_.first_seed);
  for (const Kidnap& kidnap : draw_kidnaps(half_, steps, options_.kidnaps, options_.first_seed))
    add_trial(trial(*subject, half_, steps, kidnap), found);
  return found;
}

void Direction::count_rows(std::vector<Row>& rows) const {
  const auto steps = steps_of(half_, options_.first_seed);
  const auto known = std::count_if(steps.begin(), steps.end(), [](const Step& step) { return step.known; });
  rows.push_back({name_, "updates of the other half", "", static_cast<double>(steps.size())});
  rows.push_back({name_, "of them on known ground", "", static_cast<double>(known)});
}

void Direction::track_rows(std::vector<Row>& rows) const {
  auto mine = track(&Direction::ours);
  auto other = track(&Direction::theirs);
  if (!mine) return;
  const auto row = [&](const std::string& metric, const std::string& unit, auto value) {
    return both(name_, metric, unit, value(*mine),
                other ? std::optional<double>(value(*other)) : std::nullopt);
  };
  using Values = std::vector<double> Tracking::*;
  for (const auto& [what, unit, values, goal] :
       {std::tuple{"position", "m", Values(&Tracking::off_m), 0.05},
        std::tuple{"heading", "deg", Values(&Tracking::off_deg), 1.1}}) {
    const std::string of = std::string(" error of ") + what;
    const auto at = [field = values](double fraction) {
      return [field, fraction](Tracking& tracking) { return percentile(tracking.*field, fraction); };
    };
    rows.push_back(at_most(
        row("mean" + of, unit, [field = values](Tracking& tracking) { return mean_of(tracking.*field); }),
        goal));
    rows.push_back(row("median" + of, unit, at(0.5)));
    rows.push_back(row("95 %" + of, unit, at(0.95)));
    rows.push_back(row("worst" + of, unit, at(1)));
  }
  const auto count = [&](const std::string& metric, std::size_t Tracking::*field) {
    return row(metric, "", [field](Tracking& tracking) { return static_cast<double>(tracking.*field); });
  };
  rows.push_back(count("losses", &Tracking::losses));
  rows.push_back(count("of them on return from unknown ground", &Tracking::on_return));
  rows.push_back(at_most(count("of them not recovered", &Tracking::unrecovered), 0));
  rows.push_back(
      {name_, "updates certain and over 1 m wrong", "", static_cast<double>(mine->falsely_certain)});
}

void Direction::find_rows(std::vector<Row>& rows) const {
  auto mine = find(&Direction::ours);
  const auto other = find(&Direction::theirs);
  if (!mine || mine->trials == 0) {
    std::cerr << name_ << ": no " << kWindow << " updates on known ground in a row: no trials\n";
    return;
  }
  rows.push_back(
      at_least(both(name_, "found from no start pose, of " + std::to_string(mine->trials), "starts",
                    static_cast<double>(mine->right),
                    other ? std::optional<double>(static_cast<double>(other->right)) : std::nullopt),
               static_cast<double>(mine->trials)));
  rows.push_back({name_, "updates until found, median", "", percentile(mine->updates, 0.5)});
  rows.push_back({name_, "updates until found, largest", "", percentile(mine->updates, 1)});
}

void Direction::kidnap_rows(const std::string& how, Found found, std::vector<Row>& rows) const {
  if (found.trials == 0) return;
  const std::string of = ", of " + std::to_string(found.trials);
  constexpr double kGoal = 0.95;
  rows.push_back(at_least({name_, "carried away, then " + how + ": right within 20 updates" + of, "trials",
                           static_cast<double>(found.in_time)},
                          kGoal * static_cast<double>(found.trials)));
  rows.push_back({name_, "right later" + of, "trials", static_cast<double>(found.right - found.in_time)});
  rows.push_back({name_, "updates until right, median", "", percentile(found.updates, 0.5)});
  rows.push_back({name_, "updates until right, largest", "", percentile(found.updates, 1)});
  rows.push_back({name_, "certain and over 1 m wrong at the end" + of, "trials",
                  static_cast<double>(found.certain_at_end)});
}

void Direction::measure(std::vector<Row>& rows) {
  count_rows(rows);
  track_rows(rows);
  find_rows(rows);
  kidnap_rows("driving", kidnap(kidnap_driving), rows);
  kidnap_rows("standing", kidnap(kidnap_standing), rows);
}

}  // namespace

Result<std::vector<Row>> halves_rows(const HalvesOptions& options) {
  std::vector<Row> rows;
  for (const std::string& name : options.names) {
    const auto log = options.logs / (name + ".clf.bz2");
    if (!std::filesystem::exists(log)) {
      std::cerr << "left out: there is no log " << log << "\n";
      continue;
    }
    const auto recording = load_recording(
        log, options.trajectories.empty() ? "" : options.trajectories / (name + ".tum"), SIZE_MAX);
    if (!recording) return tl::unexpected(recording.error());
    for (const Half mapped : {Half::kFirst, Half::kSecond})
      Direction(name, *recording, mapped, options).measure(rows);
  }
  return rows;
}

}  // namespace extperfc::benchmark
