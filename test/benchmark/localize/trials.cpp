#include "test/benchmark/localize/trials.hpp"

#include <algorithm>

#include "extperfc/base/rng.hpp"

namespace extperfc::benchmark {
namespace {

Outcome judge(const Subject& subject, const Pose2& truth, bool known) {
  constexpr double kCertain_m = 0.2;
  Outcome outcome;
  outcome.known = known;
  outcome.pose = subject.pose();
  outcome.truth = truth;
  outcome.right = is_right(outcome.pose, truth);
  outcome.off_m = distance_m(outcome.pose, truth);
  outcome.off_deg = apart_deg(outcome.pose, truth);
  const auto sigma_m = subject.sigma_m();
  outcome.certain = sigma_m && *sigma_m <= kCertain_m;
  return outcome;
}

/// The place before the robot is carried away; returns odometry there.
Pose2 settle(Subject& subject, const HalfCase& half, const std::vector<Step>& steps, std::size_t from) {
  subject.begin_at(half.recording->truth[steps[from].scan]);
  for (std::size_t i = from; i < from + kFollowed; ++i)
    subject.update(half.recording->scans[steps[i].scan], steps[i].odom);
  return steps[from + kFollowed - 1].odom;
}

LaserScan with_noise(LaserScan scan, Rng& rng) {
  constexpr double kSigma_m = 0.01;
  for (float& range : scan.ranges)
    if (range > scan.range_min && range < scan.range_max)
      range += static_cast<float>(rng.normal(0, kSigma_m));
  return scan;
}

}  // namespace

std::vector<Outcome> follow(Subject& subject, const HalfCase& half, const std::vector<Step>& steps,
                            std::size_t first, std::size_t end) {
  std::vector<Outcome> outcomes;
  for (std::size_t i = first; i < end; ++i) {
    subject.update(half.recording->scans[steps[i].scan], steps[i].odom);
    outcomes.push_back(judge(subject, half.recording->truth[steps[i].scan], steps[i].known));
  }
  return outcomes;
}

std::vector<Loss> find_losses(const std::vector<Outcome>& outcomes) {
  constexpr std::size_t kTolerated = 5;
  std::vector<Loss> losses;
  Loss loss;
  std::size_t wrong = 0;
  bool was_known = true;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const bool returned = !was_known;
    was_known = outcomes[i].known;
    if (!outcomes[i].known) continue;
    if (outcomes[i].right) {
      if (wrong > kTolerated) losses.back().updates = wrong;
      wrong = 0;
      continue;
    }
    if (wrong == 0) loss = {i, returned, std::nullopt};
    if (++wrong == kTolerated + 1) losses.push_back(loss);
  }
  return losses;
}

std::optional<std::size_t> updates_until_right(const std::vector<Outcome>& outcomes) {
  constexpr std::size_t kToStay = 10;
  std::size_t first = outcomes.size();
  while (first > 0 && outcomes[first - 1].right) --first;
  if (first + kToStay > outcomes.size()) return std::nullopt;
  return first + 1;
}

std::vector<Kidnap> draw_kidnaps(const HalfCase& half, const std::vector<Step>& steps, std::size_t count,
                                 std::uint64_t seed) {
  constexpr double kCarried_m = 3;
  constexpr int kTries = 1000;
  Rng rng(seed);
  const auto from = known_starts(steps, kFollowed, steps.size());
  const auto to = known_starts(steps, kWindow, steps.size());
  std::vector<Kidnap> drawn;
  if (from.empty() || to.empty()) return drawn;
  const auto any_of = [&](const std::vector<std::size_t>& starts) {
    return starts[static_cast<std::size_t>(rng.integer(0, static_cast<int>(starts.size()) - 1))];
  };
  for (int i = 0; i < kTries && drawn.size() < count; ++i) {
    const Kidnap kidnap{any_of(from), any_of(to), seed + drawn.size()};
    const auto at = [&](std::size_t step) { return half.recording->truth[steps[step].scan]; };
    if (distance_m(at(kidnap.from + kFollowed - 1), at(kidnap.to)) >= kCarried_m) drawn.push_back(kidnap);
  }
  return drawn;
}

std::vector<Outcome> kidnap_driving(Subject& subject, const HalfCase& half, const std::vector<Step>& steps,
                                    const Kidnap& kidnap) {
  const Pose2 odom = settle(subject, half, steps, kidnap.from);
  std::vector<Step> after(steps.begin() + static_cast<std::ptrdiff_t>(kidnap.to),
                          steps.begin() + static_cast<std::ptrdiff_t>(kidnap.to + kWindow));
  const Pose2 there = after[0].odom;
  for (Step& step : after) step.odom = compose(odom, between(there, step.odom));
  return follow(subject, half, after, 0, after.size());
}

std::vector<Outcome> kidnap_standing(Subject& subject, const HalfCase& half, const std::vector<Step>& steps,
                                     const Kidnap& kidnap) {
  const Pose2 odom = settle(subject, half, steps, kidnap.from);
  const std::size_t there = steps[kidnap.to].scan;
  Rng rng(kidnap.seed);
  std::vector<Outcome> outcomes;
  for (std::size_t i = 0; i < kStanding; ++i) {
    subject.update(with_noise(half.recording->scans[there], rng), odom);
    outcomes.push_back(judge(subject, half.recording->truth[there], true));
  }
  return outcomes;
}

}  // namespace extperfc::benchmark
