#include "arm/trajectory/reachability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>
#include <string>

#include "arm/trajectory/stage_bounds.hpp"

namespace extperfc::arm {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kNewtonSteps =
    200;  // a step drops at least one of at most 4 * kMaxJoints + 1 lines; 3 are usual
constexpr int kVelocityPasses = 6;

/// Closed interval of squared path speeds [rad^2/s^2].
struct SpeedRange {
  double lower{0};
  double upper{0};
};

/// Lines offset + slope x that bound u, the one that counts at some x.
struct Bound {
  double value{0};
  double slope{0};
};

/// Bounds on u at one x.
struct Window {
  Bound lower{-kInfinity, 0};
  Bound upper{kInfinity, 0};

  void between(const Bound& low, const Bound& high) {
    if (low.value > lower.value) lower = low;
    if (high.value < upper.value) upper = high;
  }
  [[nodiscard]] double gap() const { return lower.value - upper.value; }
  [[nodiscard]] bool open() const { return gap() <= 1e-14 * (std::abs(lower.value) + std::abs(upper.value)); }
};

/// One stage: from node i to node i + 1 of the grid.
struct Stage {
  std::size_t piece{0};
  double offset{0};  ///< from the piece's start [rad]
  double length{0};  ///< [rad]
  bool straight{true};
  std::size_t corner{0};  ///< which of the corners' stages it is
};

/// |along u + across x| <= limit for every Bezier point of every joint of a stage of a rounded corner.
class CornerStage {
 public:
  CornerStage(const PathPiece& piece, const Stage& stage, const JointVector& limit) : length_(stage.length) {
    rows_.reserve(4 * static_cast<std::size_t>(limit.size()));
    const auto shape = stage_shape(piece, stage.offset, stage.length);
    for (Eigen::Index j = 0; j < limit.size(); ++j)
      for (int k = 0; k < 4; ++k)
        add((piece.direction[j] + piece.direction_change[j] * shape.along[k]) / limit[j],
            piece.direction_change[j] * shape.across[k] / limit[j]);
  }

  /// Squared speeds at the start from which one in `next` can be reached; none if there are none.
  [[nodiscard]] std::optional<SpeedRange> controllable(const SpeedRange& next, double cap) const {
    const auto upper = search(next, std::min(cap, largest_), 1);
    if (!upper) return std::nullopt;
    if (window(0, next).open()) return SpeedRange{0, *upper};
    const auto lower = search(next, 0, -1);
    if (!lower || *lower > *upper) return std::nullopt;
    return SpeedRange{*lower, *upper};
  }

  /// Largest squared speed at the end when it is `x`, which is controllable, at the start.
  [[nodiscard]] double fastest(double x, const SpeedRange& next) const {
    const auto bounds = window(x, next);
    return std::clamp(x + 2 * length_ * bounds.upper.value, next.lower, next.upper);
  }

 private:
  struct Row {
    double inverse{0};  ///< 1 / |along|
    double slope{0};    ///< across / along, signed as along > 0
  };

  void add(double along, double across) {
    if (std::abs(along) < 1e-12) {
      if (across != 0) largest_ = std::min(largest_, 1 / std::abs(across));
      return;
    }
    rows_.push_back({1 / std::abs(along), across / along});
  }

  [[nodiscard]] Window window(double x, const SpeedRange& next) const {
    Window bounds;
    for (const Row& row : rows_) {
      const double middle = -row.slope * x;
      bounds.between({middle - row.inverse, -row.slope}, {middle + row.inverse, -row.slope});
    }
    const double per_x = 1 / (2 * length_);
    bounds.between({(next.lower - x) * per_x, -per_x}, {(next.upper - x) * per_x, -per_x});
    return bounds;
  }

  /// The place nearest to `x` where the bounds on u meet, below x (side 1) or above it (side -1). Newton's
  /// method on the convex piecewise linear gap never steps over it.
  [[nodiscard]] std::optional<double> search(const SpeedRange& next, double x, int side) const {
    for (int step = 0; step < kNewtonSteps; ++step) {
      const auto bounds = window(x, next);
      if (bounds.open()) return x;
      const double slope = bounds.lower.slope - bounds.upper.slope;
      if (slope * side <= 0) return std::nullopt;
      const double moved = x - bounds.gap() / slope;
      if (moved == x) return x;
      if (moved < 0) return std::nullopt;
      x = moved;
    }
    return std::nullopt;
  }

  std::vector<Row> rows_;
  double length_;
  double largest_{kInfinity};  ///< of x, from Bezier points that u does not move
};

std::string text(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

class SpeedSolver {
 public:
  SpeedSolver(const JointPath& path, const Passage& passage, const JointVector& velocity,
              const JointVector& acceleration, int stages)
      : path_(path), passage_(passage), velocity_(velocity), acceleration_(acceleration) {
    for (std::size_t p = passage.first_piece; p < passage.first_piece + passage.pieces; ++p) {
      const auto& piece = path.pieces()[p];
      const int count = piece.straight ? 1 : stages;
      for (int k = 0; k < count; ++k)
        stages_.push_back({p, piece.length * k / count, piece.length / count, piece.straight, 0});
    }
    for (auto& stage : stages_) {
      if (stage.straight) continue;
      stage.corner = corners_.size();
      corners_.emplace_back(piece_of(stage), stage, acceleration);
    }
    for (const auto& stage : stages_) caps_.push_back(speed_cap(stage, 0));
    caps_.push_back(speed_cap(stages_.back(), stages_.back().length));
  }

  Result<std::vector<PathPhase>> solve() {
    std::vector<PathPhase> phases;
    for (int pass = 0; pass < kVelocityPasses; ++pass) {
      if (auto done = backward(); !done) return tl::unexpected(done.error());
      if (auto done = forward(); !done) return tl::unexpected(done.error());
      phases = emit();
      if (!lower_caps(phases)) break;
    }
    return fit(std::move(phases));
  }

 private:
  [[nodiscard]] const PathPiece& piece_of(const Stage& stage) const { return path_.pieces()[stage.piece]; }

  /// Largest squared speed that the velocity limits permit at a place of a stage.
  [[nodiscard]] double speed_cap(const Stage& stage, double offset) const {
    const JointVector tangent = evaluate(piece_of(stage), stage.offset + offset).tangent;
    const double use = (tangent.array() / velocity_.array()).abs().maxCoeff();
    return 1 / (use * use);
  }

  /// Largest |s''| on a straight.
  [[nodiscard]] double straight_acceleration(const Stage& stage) const {
    return 1 / (piece_of(stage).direction.array() / acceleration_.array()).abs().maxCoeff();
  }

  [[nodiscard]] std::optional<SpeedRange> controllable(std::size_t i) const {
    const SpeedRange& next = reach_[i + 1];
    if (!stages_[i].straight) return corners_[stages_[i].corner].controllable(next, caps_[i]);
    const double change = 2 * straight_acceleration(stages_[i]) * stages_[i].length;
    const SpeedRange range{std::max(0.0, next.lower - change), std::min(caps_[i], next.upper + change)};
    if (range.lower > range.upper) return std::nullopt;
    return range;
  }

  Result<void> backward() {
    const double end = passage_.end_speed * passage_.end_speed;
    if (end > caps_.back() * (1 + 1e-9))
      return fail(ErrorCode::kInvalidArgument,
                  "time parameterization: the end speed of " + text(passage_.end_speed) +
                      " rad/s is beyond the velocity limits, which permit " + text(std::sqrt(caps_.back())));
    reach_.assign(stages_.size() + 1, {});
    reach_.back() = {end, end};
    for (std::size_t i = stages_.size(); i-- > 0;) {
      const auto range = controllable(i);
      if (!range)
        return fail(ErrorCode::kInvalidArgument, "time parameterization: the end speed of " +
                                                     text(passage_.end_speed) +
                                                     " rad/s cannot be reached within the limits");
      reach_[i] = *range;
    }
    return {};
  }

  Result<void> forward() {
    const double start = passage_.start_speed * passage_.start_speed;
    const auto& range = reach_.front();
    if (start > range.upper * (1 + 1e-9) || start < range.lower * (1 - 1e-9))
      return fail(ErrorCode::kInvalidArgument, "time parameterization: the start speed is " +
                                                   text(passage_.start_speed) + " rad/s, the limits permit " +
                                                   text(std::sqrt(range.lower)) + " to " +
                                                   text(std::sqrt(range.upper)));
    squared_.assign(stages_.size() + 1, 0.0);
    squared_.front() = std::clamp(start, range.lower, range.upper);
    for (std::size_t i = 0; i < stages_.size(); ++i) {
      const auto& stage = stages_[i];
      const double x = squared_[i];
      squared_[i + 1] =
          stage.straight ? std::min(reach_[i + 1].upper, x + 2 * straight_acceleration(stage) * stage.length)
                         : corners_[stage.corner].fastest(x, reach_[i + 1]);
    }
    return {};
  }

  [[nodiscard]] std::vector<PathPhase> emit() {
    std::vector<PathPhase> phases;
    first_phase_.clear();
    for (std::size_t i = 0; i < stages_.size(); ++i) {
      first_phase_.push_back(phases.size());
      if (stages_[i].straight)
        add_straight(i, phases);
      else
        add_phase(stages_[i], 0, stages_[i].length, squared_[i], squared_[i + 1], phases);
    }
    return phases;
  }

  /// Largest squared speed on a straight between nodes of which the squared speeds sum to `ends`: gaining,
  /// hold_s and losing fill it, v^2 / a + v hold_s = length + ends / (2 a) with a = max_acceleration.
  [[nodiscard]] double peak(double max_acceleration, double length, double ends) const {
    const double hold = passage_.hold_s;
    const double free = length / max_acceleration + ends / (2 * max_acceleration * max_acceleration);
    if (hold <= 0) return max_acceleration * max_acceleration * free;
    const double speed = 2 * max_acceleration * free / (hold + std::sqrt(hold * hold + 4 * free));
    return speed * speed;
  }

  /// Gains speed, holds it, loses it, each as far as needed.
  void add_straight(std::size_t i, std::vector<PathPhase>& phases) const {
    const auto& stage = stages_[i];
    const double max_acceleration = straight_acceleration(stage);
    const double x0 = squared_[i];
    const double x1 = squared_[i + 1];
    const double top =
        std::max({x0, x1, std::min(speed_cap(stage, 0), peak(max_acceleration, stage.length, x0 + x1))});
    const double gain = std::min(stage.length, (top - x0) / (2 * max_acceleration));
    const double loss = std::min(stage.length - gain, (top - x1) / (2 * max_acceleration));
    add_phase(stage, 0, gain, x0, top, phases);
    add_phase(stage, gain, stage.length - gain - loss, top, top, phases);
    add_phase(stage, stage.length - loss, loss, top, x1, phases);
  }

  static void add_phase(const Stage& stage, double offset, double length, double x0, double x1,
                        std::vector<PathPhase>& phases) {
    if (length <= 1e-13 * stage.length) return;
    const double duration_s = 2 * length / (std::sqrt(x0) + std::sqrt(x1));
    const double begin_s = phases.empty() ? 0 : phases.back().begin_s + phases.back().duration_s;
    phases.push_back(
        {begin_s, duration_s, stage.piece, stage.offset + offset, std::sqrt(x0), (x1 - x0) / (2 * length)});
  }

  /// Lowers the caps around stages that are too fast inside; false if there are none.
  bool lower_caps(const std::vector<PathPhase>& phases) {
    bool lowered = false;
    for (std::size_t i = 0; i < stages_.size(); ++i) {
      if (stages_[i].straight) continue;
      const double use = velocity_use(piece_of(stages_[i]), phases[first_phase_[i]], velocity_);
      if (use <= 1 + 1e-10) continue;
      lowered = true;
      const double factor = 1 / (use * use);
      if (i > 0 || passage_.start_speed <= 0) caps_[i] = std::min(caps_[i], squared_[i] * factor);
      if (i + 1 < stages_.size() || passage_.end_speed <= 0)
        caps_[i + 1] = std::min(caps_[i + 1], squared_[i + 1] * factor);
    }
    return lowered;
  }

  /// Takes the last rounding away by slowing down as a whole.
  Result<std::vector<PathPhase>> fit(std::vector<PathPhase> phases) const {
    double slower = 1;
    for (const auto& phase : phases) {
      const auto& piece = path_.pieces()[phase.piece];
      slower = std::max({slower, velocity_use(piece, phase, velocity_),
                         std::sqrt(acceleration_use(piece, phase, acceleration_))});
    }
    if (!std::isfinite(slower) || (slower > 1 + 1e-6 && (passage_.start_speed > 0 || passage_.end_speed > 0)))
      return fail(ErrorCode::kInvalidArgument,
                  "time parameterization: limits are exceeded by a factor of " + text(slower));
    for (auto& phase : phases) {
      phase.begin_s *= slower;
      phase.duration_s *= slower;
      phase.speed /= slower;
      phase.acceleration /= slower * slower;
    }
    return phases;
  }

  const JointPath& path_;
  Passage passage_;
  const JointVector& velocity_;
  const JointVector& acceleration_;
  std::vector<Stage> stages_;
  std::vector<CornerStage> corners_;
  std::vector<double> caps_;       ///< per node, of squared speed
  std::vector<SpeedRange> reach_;  ///< per node: from there the end can be reached
  std::vector<double> squared_;    ///< per node: the solution
  std::vector<std::size_t> first_phase_;
};

}  // namespace

Result<std::vector<PathPhase>> fastest_phases(const JointPath& path, const Passage& passage,
                                              const JointVector& velocity, const JointVector& acceleration,
                                              int stages) {
  return SpeedSolver(path, passage, velocity, acceleration, stages).solve();
}

}  // namespace extperfc::arm
