#include "extperfc/arm/joint_trajectory.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace extperfc::arm {

namespace {

/// Gauss-Legendre rule of five points on [0, 1]: exact up to degree 9; a position is of degree 8 in time.
struct GaussPoint {
  double place;
  double weight;
};
constexpr std::array<GaussPoint, 5> kGauss{{{0.046910077030668004, 0.11846344252809454},
                                            {0.23076534494715845, 0.23931433524968324},
                                            {0.5, 0.28444444444444444},
                                            {0.7692346550528415, 0.23931433524968324},
                                            {0.953089922969332, 0.11846344252809454}}};

}  // namespace

JointTrajectory::JointTrajectory(JointPath path, TrajectoryLimits limits, std::vector<PathPhase> phases,
                                 std::vector<TrajectoryRun> runs, double smoothing_deviation_rad)
    : path_(std::move(path)),
      limits_(std::move(limits)),
      phases_(std::move(phases)),
      runs_(std::move(runs)),
      smoothing_deviation_rad_(smoothing_deviation_rad) {
  if (!runs_.empty()) duration_s_ = runs_.back().begin_s + runs_.back().phases_s + runs_.back().window_s;
  prepare_areas();
}

JointSample JointTrajectory::at(const PathPhase& phase, double time_s) const {
  const auto& piece = path_.pieces()[phase.piece];
  const double offset = phase.offset + time_s * (phase.speed + 0.5 * phase.acceleration * time_s);
  const double speed = std::max(0.0, phase.speed + phase.acceleration * time_s);
  const auto state = evaluate(piece, std::clamp(offset, 0.0, piece.length));
  return {state.position, speed * state.tangent,
          speed * speed * state.curvature + phase.acceleration * state.tangent};
}

const PathPhase& JointTrajectory::phase_at(const TrajectoryRun& run, double time_s) const {
  const auto first = phases_.begin() + static_cast<std::ptrdiff_t>(run.first_phase);
  const auto behind =
      std::upper_bound(first + 1, first + static_cast<std::ptrdiff_t>(run.phases), time_s,
                       [](double value, const PathPhase& phase) { return value < phase.begin_s; });
  return *(behind - 1);
}

JointVector JointTrajectory::run_start(const TrajectoryRun& run) const {
  return at(phases_[run.first_phase], 0).position;
}

JointVector JointTrajectory::run_end(const TrajectoryRun& run) const {
  const auto& phase = phases_[run.first_phase + run.phases - 1];
  if (&run == &runs_.back()) return path_.end();
  return evaluate(path_.pieces()[phase.piece], path_.pieces()[phase.piece].length).position;
}

/// What the phases say at `time_s` of the run; at rest outside of them.
JointSample JointTrajectory::raw(const TrajectoryRun& run, double time_s) const {
  const JointVector rest = JointVector::Zero(joints());
  if (time_s < 0) return {run_start(run), rest, rest};
  if (time_s >= run.phases_s) return {run_end(run), rest, rest};
  const auto& phase = phase_at(run, time_s);
  return at(phase, std::min(time_s - phase.begin_s, phase.duration_s));
}

JointVector JointTrajectory::phase_area(const PathPhase& phase, double duration_s,
                                        const JointVector& from) const {
  const auto& piece = path_.pieces()[phase.piece];
  const double t = duration_s;
  if (piece.straight)
    return t * (piece.position - from) +
           t * (phase.offset + t * (phase.speed / 2 + t * phase.acceleration / 6)) * piece.direction;
  JointVector sum = JointVector::Zero(joints());
  for (const auto& [place, weight] : kGauss) {
    const double since_s = t * place;
    const double offset = phase.offset + since_s * (phase.speed + 0.5 * phase.acceleration * since_s);
    sum += t * weight * (evaluate(piece, offset).position - from);
  }
  return sum;
}

void JointTrajectory::prepare_areas() {
  areas_.clear();
  if (std::none_of(runs_.begin(), runs_.end(), [](const auto& run) { return run.window_s > 0; })) return;
  areas_.reserve(phases_.size());
  for (const auto& run : runs_) {
    const JointVector from = run_start(run);
    JointVector sum = JointVector::Zero(joints());
    for (std::size_t i = run.first_phase; i < run.first_phase + run.phases; ++i) {
      areas_.push_back(sum);
      sum += phase_area(phases_[i], phases_[i].duration_s, from);
    }
  }
}

/// Integral of q - q(start) over the run from its start to `time_s`.
JointVector JointTrajectory::area(const TrajectoryRun& run, double time_s) const {
  if (time_s <= 0) return JointVector::Zero(joints());
  const JointVector from = run_start(run);
  const double inside_s = std::min(time_s, run.phases_s);
  const auto& phase = phase_at(run, inside_s);
  const auto index = static_cast<std::size_t>(&phase - phases_.data());
  const JointVector sum = areas_[index] + phase_area(phase, inside_s - phase.begin_s, from);
  return sum + (time_s - inside_s) * (run_end(run) - from);
}

const TrajectoryRun& JointTrajectory::run_at(double time_s) const {
  const auto behind =
      std::upper_bound(runs_.begin() + 1, runs_.end(), time_s,
                       [](double value, const TrajectoryRun& run) { return value < run.begin_s; });
  return *(behind - 1);
}

JointSample JointTrajectory::sample(double time_s) const {
  const JointVector none = JointVector::Zero(joints());
  if (runs_.empty()) return {path_.end(), none, none};
  if (time_s >= duration_s_) {
    const auto& phase = phases_.back();
    const JointVector speed = runs_.back().window_s > 0 ? none : at(phase, phase.duration_s).velocity;
    return {path_.end(), speed, none};
  }
  const auto& run = run_at(time_s);
  const double since_s = std::max(0.0, time_s - run.begin_s);
  if (run.window_s <= 0) return raw(run, since_s);
  const auto now = raw(run, since_s);
  const auto before = raw(run, since_s - run.window_s);
  return {run_start(run) + (area(run, since_s) - area(run, since_s - run.window_s)) / run.window_s,
          (now.position - before.position) / run.window_s, (now.velocity - before.velocity) / run.window_s};
}

std::optional<JointVector> JointTrajectory::jerk(double time_s) const {
  if (runs_.empty() || time_s < 0 || time_s >= duration_s_) return JointVector::Zero(joints());
  const auto& run = run_at(time_s);
  if (run.window_s <= 0) return std::nullopt;
  const double since_s = time_s - run.begin_s;
  return (raw(run, since_s).acceleration - raw(run, since_s - run.window_s).acceleration) / run.window_s;
}

std::vector<double> JointTrajectory::borders_s() const {
  std::vector<double> borders;
  for (const auto& run : runs_) {
    for (std::size_t i = run.first_phase; i < run.first_phase + run.phases; ++i) {
      borders.push_back(run.begin_s + phases_[i].begin_s);
      if (run.window_s > 0) borders.push_back(run.begin_s + phases_[i].begin_s + run.window_s);
    }
    if (run.window_s > 0) borders.push_back(run.begin_s + run.phases_s);
  }
  borders.push_back(duration_s_);
  std::sort(borders.begin(), borders.end());
  return borders;
}

}  // namespace extperfc::arm
