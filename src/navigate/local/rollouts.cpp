#include "navigate/local/rollouts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "extperfc/base/rng.hpp"

namespace extperfc::navigate {

namespace {

constexpr std::array<double, 6> kGuideFactors{1.0, 0.75, 0.5, 0.25, 0.1, -0.3};
constexpr int kGuides = static_cast<int>(kGuideFactors.size());
constexpr int kWarm = kGuides;      // the last solution itself
constexpr int kStop = kGuides + 1;  // brakes
constexpr int kFirstRandom = kGuides + 2;
constexpr int kOffsets = 16;           // cycles until noise repeats
constexpr float kCorrelation = 0.8F;   // of the noise from step to step
constexpr float kNear_s = 0.7F;        // trajectories are checked exactly so far
constexpr float kSpeedWeight = 8.0F;   // per (m/s)^2 above the speed that clearance and path admit
constexpr float kCentreWeight = 0.3F;  // of the cell's cost under the base's centre
constexpr float kExactness = 25.0F;  // times that a deviation counts more where the footprint nearly touches
constexpr std::size_t kBest = 6;

/// Part of a wide clearance that is missing, from 0; above 1: the footprint touches.
float lack_of(float clearance_m, float wide_m) {
  return std::max(0.0F, wide_m - clearance_m) / wide_m;
}

}  // namespace

Rollouts::Rollouts(const MppiParams& params)
    : params_(params),
      guide_(params.limits, params.base),
      steps_(std::max(2, static_cast<int>(std::lround(params.horizon_s / params.step_s)))) {
  const int samples = std::max(params.samples, kFirstRandom + 2);
  for (Table& table : control_) table.setZero(samples, steps_);
  for (Column& column : now_) column.setZero(samples);
  for (Table* table : {&x_, &y_, &yaw_}) table->setZero(samples, steps_);
  for (Column* column : {&cos_, &sin_, &a_, &b_, &c_, &d_, &costs_, &lengths_}) column->setZero(samples);
  station_.assign(static_cast<std::size_t>(samples), 0);
  touched_.assign(static_cast<std::size_t>(samples), 0);
  best_.resize(static_cast<std::size_t>(samples));
  mean_.setZero(steps_, 3);
  draw_noise(params.seed);
}

void Rollouts::draw_noise(std::uint64_t seed) {
  Rng rng(seed);
  const float fresh = std::sqrt(1 - kCorrelation * kCorrelation);
  constexpr std::array<float, 3> kAmplitudes{1.0F, 0.5F, 0.2F};
  for (Table& table : noise_) {
    table.setZero(samples(), steps_ + kOffsets);
    for (int sample = kFirstRandom; sample < samples(); ++sample) {
      const float amplitude = kAmplitudes[static_cast<std::size_t>(sample) % kAmplitudes.size()];
      auto value = static_cast<float>(rng.normal(0, 1));
      for (int step = 0; step < table.cols(); ++step) {
        table(sample, step) = amplitude * value;
        value = kCorrelation * value + fresh * static_cast<float>(rng.normal(0, 1));
      }
    }
  }
}

void Rollouts::reset() {
  mean_.setZero();
  cycle_ = 0;
}

void Rollouts::run(const Scene& scene) {
  factor_ = static_cast<float>(scene.rules.speed_factor);
  sample_controls(scene);
  const std::array<double, 3> current{scene.current.vx, scene.current.vy, scene.current.wz};
  for (std::size_t axis = 0; axis < 3; ++axis) now_[axis].setConstant(static_cast<float>(current[axis]));
  cos_.setConstant(static_cast<float>(std::cos(scene.robot.yaw)));
  sin_.setConstant(static_cast<float>(std::sin(scene.robot.yaw)));
  costs_.setZero();
  std::fill(station_.begin(), station_.end(), 0);
  std::fill(touched_.begin(), touched_.end(), 0);
  for (int step = 0; step < steps_; ++step) {
    limit_change(step);
    if (step == 0) {
      x_.col(0).setZero();
      y_.col(0).setZero();
      yaw_.col(0).setConstant(static_cast<float>(scene.robot.yaw));
    } else {
      x_.col(step) = x_.col(step - 1);
      y_.col(step) = y_.col(step - 1);
      yaw_.col(step) = yaw_.col(step - 1);
    }
    roll_step(step);
    rate_step(scene, step);
  }
  rate_ends(scene);
  ++cycle_;
}

/// Controls that are wanted: those of the guide, the last solution, braking, and random ones about the last
/// solution (even samples) or the guide (odd ones).
void Rollouts::sample_controls(const Scene& scene) {
  for (int sample = 0; sample < kGuides; ++sample)
    roll_guide(scene, sample, kGuideFactors[static_cast<std::size_t>(sample)]);
  const std::array<float, 3> sigma{
      static_cast<float>(params_.sigma_vx_m_s),
      params_.base == BaseKind::kHolonomic ? static_cast<float>(params_.sigma_vy_m_s) : 0.0F,
      static_cast<float>(params_.sigma_wz_rad_s)};
  const int offset = cycle_ % kOffsets;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    for (int step = 0; step < steps_; ++step) {
      auto column = control_[i].col(step);
      const auto noise = noise_[i].col(step + offset);
      const float guided = column(0);
      column.tail(samples() - kWarm) = mean_(step, axis) + sigma[i] * noise.tail(samples() - kWarm);
      column(kStop) = 0;
      for (int sample = kFirstRandom; sample < samples(); sample += 2)
        column(sample) += guided - mean_(step, axis);
    }
  }
}

void Rollouts::roll_guide(const Scene& scene, int sample, double rate_factor) {
  Pose2 pose{0, 0, scene.robot.yaw};
  Twist2 now = scene.current;
  std::size_t index = 0;
  for (int step = 0; step < steps_; ++step) {
    index = nearest_station(scene.stations, index, static_cast<float>(pose.x), static_cast<float>(pose.y),
                            static_cast<float>(pose.yaw));
    const Twist2 wanted = guide_.velocity(scene.stations, index, pose, rate_factor);
    now = limited_change(wanted, now, params_.limits, params_.step_s, scene.rules.speed_factor);
    control_[0](sample, step) = static_cast<float>(now.vx);
    control_[1](sample, step) = static_cast<float>(now.vy);
    control_[2](sample, step) = static_cast<float>(now.wz);
    const double yaw = pose.yaw + now.wz * params_.step_s;
    pose = advance(pose, now, params_.step_s);
    pose.yaw = yaw;
  }
}

/// As limited_change() does, for all samples at once: now_ moves towards the controls and replaces them.
void Rollouts::limit_change(int step) {
  const VelocityLimits& limits = params_.limits;
  const auto inverse = [](double value) { return value > 0 ? static_cast<float>(1 / value) : 0.0F; };
  const auto step_s = static_cast<float>(params_.step_s);
  auto vx = control_[0].col(step);
  auto vy = control_[1].col(step);
  auto wz = control_[2].col(step);
  if (limits.min_vx_m_s == 0) vx = vx.max(0.0F);
  if (limits.max_vy_m_s == 0) vy.setZero();
  a_ = vx.max(0.0F) * inverse(limits.max_vx_m_s) + vx.min(0.0F) * inverse(-limits.min_vx_m_s);
  b_ = (a_.square() + (vy * inverse(limits.max_vy_m_s)).square()).sqrt();
  c_ = factor_ / b_.max(std::max(factor_, 1e-6F));
  const float max_wz = factor_ * static_cast<float>(limits.max_wz_rad_s);
  a_ = vx * c_ - now_[0];
  b_ = vy * c_ - now_[1];
  c_ = wz.min(max_wz).max(-max_wz) - now_[2];
  d_ = ((a_ * inverse(limits.acc_x_m_s2)).square() + (b_ * inverse(limits.acc_y_m_s2)).square()).sqrt();
  d_ = d_.max(c_.abs() * inverse(limits.acc_wz_rad_s2));
  d_ = step_s / d_.max(step_s);
  costs_ += static_cast<float>(params_.smooth_weight) / static_cast<float>(steps_) *
            (a_.square() + b_.square() + 0.2F * c_.square()) * d_.square() / (step_s * step_s) * 0.2F;
  now_[0] += a_ * d_;
  now_[1] += b_ * d_;
  now_[2] += c_ * d_;
  vx = now_[0];
  vy = now_[1];
  wz = now_[2];
}

/// Poses after the step: the translation along the heading in the middle of the step.
void Rollouts::roll_step(int step) {
  const auto step_s = static_cast<float>(params_.step_s);
  a_ = now_[2] * (0.5F * step_s);
  b_ = a_ * (1.0F - a_.square() * (1.0F / 6) + a_.square().square() * (1.0F / 120));  // sine
  a_ = 1.0F - a_.square() * 0.5F + a_.square().square() * (1.0F / 24);                // cosine
  c_ = cos_ * a_ - sin_ * b_;
  d_ = sin_ * a_ + cos_ * b_;
  x_.col(step) += step_s * (c_ * now_[0] - d_ * now_[1]);
  y_.col(step) += step_s * (d_ * now_[0] + c_ * now_[1]);
  yaw_.col(step) += step_s * now_[2];
  cos_ = c_ * a_ - d_ * b_;
  sin_ = d_ * a_ + c_ * b_;
}

void Rollouts::rate_step(const Scene& scene, int step) {
  const float scale = 1.0F / static_cast<float>(steps_);
  for (int sample = 0; sample < samples(); ++sample) costs_[sample] += scale * rate_pose(scene, step, sample);
}

float Rollouts::rate_pose(const Scene& scene, int step, int sample) {
  const auto i = static_cast<std::size_t>(sample);
  const float x = x_(sample, step);
  const float y = y_(sample, step);
  const float yaw = yaw_(sample, step);
  station_[i] = nearest_station(scene.stations, station_[i], x, y, yaw);
  const Station& at = scene.stations[station_[i]];
  const float dx = x - at.x;
  const float dy = y - at.y;
  const float dyaw = yaw - at.yaw;
  constexpr auto kRadian2 = static_cast<float>(kRadian_m * kRadian_m);
  const float along = std::clamp(dx * at.dx + dy * at.dy + kRadian2 * dyaw * at.dyaw, -0.1F, 0.1F);
  lengths_[sample] = at.s + along;
  const float across_x = dx - along * at.dx;
  const float across_y = dy - along * at.dy;
  const float off = dyaw - along * at.dyaw;
  float cost = static_cast<float>(params_.path_weight) * (across_x * across_x + across_y * across_y) +
               static_cast<float>(params_.heading_weight) * std::min(off * off, 2.0F);
  cost *= exactness(scene, at);
  cost += obstacle_cost(scene, step, sample, at);
  if (!scene.people.empty())
    cost += static_cast<float>(params_.people_weight) * people_cost(scene, step, sample);
  return cost;
}

/// How much more a deviation from the path counts at a station. What a differential base is beside its path
/// or askew when it enters a door, it cannot mend in there.
float Rollouts::exactness(const Scene& scene, const Station& at) const {
  if (params_.base != BaseKind::kDifferential) return 1;
  const auto wide = static_cast<float>(scene.rules.wide_clearance_m);
  const float lack = lack_of(at.clearance_m, wide);
  return 1 + kExactness * lack * lack;
}

/// Who comes to a robot that stands chooses the distance, and will stop or pass: it need not give ground,
/// which in a corridor never ends. Standing counts less than moving there.
float Rollouts::people_cost(const Scene& scene, int step, int sample) const {
  constexpr float kPasses_m_s = 0.3F;
  constexpr float kStandingNear = 0.4F;
  constexpr float kStandingInTouch = 0.2F;
  const float cost = scene.people.at(static_cast<std::size_t>(step), x_(sample, step), y_(sample, step));
  const float standing = cost < PeopleCost::kTouches ? kStandingNear : kStandingInTouch;
  const float vx = now_[0][sample];
  const float vy = now_[1][sample];
  return cost * std::clamp(std::sqrt(vx * vx + vy * vy) / kPasses_m_s, standing, 1.0F);
}

float Rollouts::obstacle_cost(const Scene& scene, int step, int sample, const Station& at) {
  const auto i = static_cast<std::size_t>(sample);
  const float x = x_(sample, step);
  const float y = y_(sample, step);
  const auto wide = static_cast<float>(scene.rules.wide_clearance_m);
  const float clearance_m = scene.field.clearance(scene.outline, x, y, cos_[sample], sin_[sample], wide);
  const bool near = static_cast<float>(step + 1) * static_cast<float>(params_.step_s) <= kNear_s;
  if (touched_[i] == 0 && clearance_m < ClearanceField::kCheckBelow_m) {
    const bool exact = near && clearance_m >= 0;
    const Pose2 pose{scene.robot.x + x, scene.robot.y + y, yaw_(sample, step)};
    if (exact ? contact(scene.field.window(), scene.footprint, pose) != Contact::kFree : clearance_m <= 0)
      touched_[i] = 1;
  }
  float cost = touched_[i] != 0 ? kCollision : 0;
  // Only what is worse than on the path itself: a narrow door is passed, not waited for.
  const float lack = lack_of(clearance_m, wide);
  const float path_lack = lack_of(at.clearance_m, wide);
  const float centre = static_cast<float>(scene.field.cost(x, y)) - static_cast<float>(at.cost);
  cost += static_cast<float>(params_.obstacle_weight) * (std::max(0.0F, lack * lack - path_lack * path_lack) +
                                                         kCentreWeight / 252 * std::max(0.0F, centre));
  const float vx = now_[0][sample];
  const float vy = now_[1][sample];
  const float admitted = std::min(clearance_speed(scene.rules, clearance_m), std::max(0.08F, at.max_rate));
  const float excess = std::max(0.0F, std::sqrt(vx * vx + vy * vy) - admitted - 0.03F);
  return cost + kSpeedWeight * excess * excess;
}

/// How far the path's speed profile brings the robot within the horizon.
float Rollouts::reference_length(const Scene& scene) const {
  const double speed = std::hypot(scene.current.vx, scene.current.vy);
  float rate = static_cast<float>(std::hypot(speed, kRadian_m * scene.current.wz));
  const auto step_s = static_cast<float>(params_.step_s);
  const float acceleration = static_cast<float>(0.8 * params_.limits.acc_x_m_s2);
  float length = scene.stations.front().s;
  std::size_t index = 0;
  for (int step = 0; step < steps_; ++step) {
    while (index + 1 < scene.stations.size() && scene.stations[index + 1].s <= length) ++index;
    rate = std::min(rate + acceleration * step_s, scene.stations[index].max_rate);
    length += rate * step_s;
  }
  return std::min(length, scene.stations.back().s);
}

void Rollouts::rate_ends(const Scene& scene) {
  const float wanted = reference_length(scene);
  const auto weight = static_cast<float>(params_.progress_weight);
  costs_ += weight * (wanted - lengths_).max(0.0F);
  std::iota(best_.begin(), best_.end(), 0);
  const std::size_t kept = std::min(kBest, best_.size());
  std::partial_sort(best_.begin(), best_.begin() + static_cast<std::ptrdiff_t>(kept), best_.end(),
                    [this](int a, int b) { return costs_[a] < costs_[b]; });
}

void Rollouts::update_mean() {
  const auto temperature = static_cast<float>(params_.temperature);
  a_ = ((costs_[best_.front()] - costs_) / temperature).max(-30.0F).exp();
  a_ /= a_.sum();
  for (int step = 0; step < steps_; ++step)
    for (int axis = 0; axis < 3; ++axis)
      mean_(step, axis) = (a_ * control_[static_cast<std::size_t>(axis)].col(step)).sum();
}

void Rollouts::shift_mean(double dt_s) {
  const double shift = dt_s / params_.step_s;
  for (int step = 0; step < steps_; ++step) {
    const double from = std::min(step + shift, static_cast<double>(steps_ - 1));
    const int low = static_cast<int>(from);
    const int high = std::min(low + 1, steps_ - 1);
    const auto part = static_cast<float>(from - low);
    mean_.row(step) = (1 - part) * mean_.row(low) + part * mean_.row(high);
  }
}

Twist2 Rollouts::velocity(int sample, int step) const {
  return {control_[0](sample, step), control_[1](sample, step), control_[2](sample, step)};
}

void Rollouts::mean_poses(const Pose2& robot, std::vector<Pose2>& out) const {
  out.assign(1, robot);
  out.reserve(static_cast<std::size_t>(steps_) + 1);
  for (int step = 0; step < steps_; ++step) out.push_back(advance(out.back(), mean(step), params_.step_s));
}

void Rollouts::adopt(int sample) {
  for (int axis = 0; axis < 3; ++axis)
    mean_.col(axis) = control_[static_cast<std::size_t>(axis)].row(sample).transpose();
}

Twist2 Rollouts::mean(int step) const {
  return {mean_(step, 0), mean_(step, 1), mean_(step, 2)};
}

void Rollouts::poses(int sample, const Pose2& robot, std::vector<Pose2>& out) const {
  out.assign(1, robot);
  out.reserve(static_cast<std::size_t>(steps_) + 1);
  for (int step = 0; step < steps_; ++step)
    out.push_back({robot.x + x_(sample, step), robot.y + y_(sample, step), wrap_angle(yaw_(sample, step))});
}

}  // namespace extperfc::navigate
