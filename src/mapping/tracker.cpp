#include "mapping/tracker.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace extperfc::mapping {

namespace {

constexpr std::size_t kRemembered = 25;  // scans that the map holds at least, twice as many at most
constexpr double kRememberEveryM = 0.15;
constexpr double kRememberEveryRad = 0.12;
constexpr double kReachOfNewestM =
    2.0;  // of the newest key frame, where they are the local map of a resumed session
constexpr double kPointReachM = 0.25;  // maximum distance from a point to its surface
// A match this many standard deviations from odometry contradicts it.
constexpr double kContradiction = 6.0;
// No robot moves this far from scan to scan: its odometry was reset. In a gap between scans it may move on.
constexpr double kJumpM = 3.0;
constexpr double kJumpRad = 1.5;
constexpr double kFastMPerS = 1.5;
constexpr double kFastRadPerS = 1.0;
constexpr double kLongestDriveS = 30.0;  // without scans that odometry is believed for
// After a gap at least this long and a motion this large the surroundings may be others.
constexpr double kUnseenS = 0.3;
constexpr double kUnseenM = 0.5;
constexpr double kUnseenRad = 0.5;
// Scans whose fit is below the minimum plus this are searched in a wider window.
constexpr double kComfortableFit = 0.15;
constexpr double kUnusualDrop = 0.12;  // of the fit, below that of the latest scans
// Without odometry: constant velocity, with this standard deviation from scan to scan.
constexpr double kUnknownStepM = 0.12;
constexpr double kUnknownStepRad = 0.12;
// Slides along corridors: two standard deviations of wheels that do not slip are this, srr of the distance
// and str of the rotation.
constexpr double kMinWheelErrorM = 0.01;
constexpr double kSlideDistanceM = 0.5;  // after this distance, a third of a slide still counts
constexpr double kWeakRatio = 0.2;       // of the strongest direction's information
constexpr double kFreeM = 1.0;           // across the corridor the scan decides
// A scan of fewer points may show nothing but a pedestrian: it cannot contradict odometry.
constexpr std::size_t kMinContradictingPoints = 60;
constexpr int kCarriedScans = 5;  // that show other surroundings, one after another: the robot was carried

/// The component of the motion between two poses along a direction of unit length.
Eigen::Vector2d moved_along(const Eigen::Vector2d& along, const Pose2& from, const Pose2& to) {
  return along.dot(Eigen::Vector2d(to.x - from.x, to.y - from.y)) * along;
}

}  // namespace

bool Tracker::jumps(const std::optional<Pose2>& odom_T_base) const {
  if (!odom_T_base || !last_odometry_) return false;
  const Pose2 step = between(*last_odometry_, *odom_T_base);
  return std::hypot(step.x, step.y) > kJumpM + kFastMPerS * gap_s_ ||
         std::abs(step.yaw) > kJumpRad + kFastRadPerS * gap_s_;
}

/// Whether scans were missing while the robot drove from its last pose to `there`.
bool Tracker::drove_unseen(const Pose2& there) const {
  const Pose2 step = between(pose_, there);
  return gap_s_ >= kUnseenS && (std::hypot(step.x, step.y) > kUnseenM || std::abs(step.yaw) > kUnseenRad);
}

/// Where a scan is looked for about the pose at which it is expected.
Tracker::Window Tracker::window_about(const Pose2& expected) const {
  constexpr Window kUsual{0.4, 0.3};
  constexpr Window kWide{1.2, 0.6};
  return resuming_ || drove_unseen(expected) ? kWide : kUsual;
}

Pose2 Tracker::expected_step(const std::optional<Pose2>& odom_T_base) const {
  if (jumps(odom_T_base)) return last_step_;
  if (odom_T_base && last_odometry_) return between(*last_odometry_, *odom_T_base);
  if (odom_T_base) return {};  // a single odometry pose gives no motion
  return last_step_;
}

PosePrior Tracker::prior(const Pose2& step, bool has_odometry) const {
  PosePrior prior;
  prior.mean = compose(pose_, step);
  const double distance_m = std::hypot(step.x, step.y);
  const double rotation_rad = std::abs(step.yaw);
  prior.sigma_m =
      has_odometry ? 0.02 + 3 * noise_.srr * distance_m + 0.2 * noise_.str * rotation_rad : kUnknownStepM;
  prior.sigma_rad =
      has_odometry ? 0.05 + 5 * noise_.stt * rotation_rad + 0.5 * noise_.srt * distance_m : kUnknownStepRad;
  return prior;
}

Tracked Tracker::add(const ScanPoints& points, const std::optional<Pose2>& odom_T_base, double gap_s) {
  gap_s_ = gap_s <= kLongestDriveS ? gap_s : 0.0;
  const bool jump = jumps(odom_T_base);
  const bool has_odometry = odom_T_base && last_odometry_ && !jump;
  const Pose2 step = expected_step(odom_T_base);
  const bool enough = points.surface.size() >= kMinPoints;
  const PosePrior before = prior(step, has_odometry);
  Tracked tracked;
  tracked.pose = before.mean;
  if (map_.empty() && enough) {
    tracked.matched = true;
    tracked.fit = 1.0;
  } else if (enough) {
    match_scan(points, before, tracked);
    if (tracked.matched && has_odometry && !resuming_) {
      if (points.surface.size() < kMinContradictingPoints && disagrees(tracked.pose, step, before.mean)) {
        tracked = {};
        tracked.pose = before.mean;
      } else {
        watch_slide(points, before, step, tracked);
        judge_hold(points, tracked);
      }
    }
  }
  watch_place(points, before, tracked);
  if (!has_odometry) slide_ = {};
  if (has_odometry && !resuming_) tracked.doubt = doubt(tracked, step, before);
  if (!has_odometry && tracked.matched) tracked.doubt = unmeasured(tracked);
  if (!tracked.matched) tracked.doubt += reckoned(step, has_odometry);
  constexpr double kFollow = 0.1;
  if (!tracked.lost) usual_fit_ += kFollow * (tracked.fit - usual_fit_);
  const double per_m2 = 1 / (before.sigma_m * before.sigma_m);
  tracked.information +=
      Eigen::Vector3d(per_m2, per_m2, 1 / (before.sigma_rad * before.sigma_rad)).asDiagonal();
  const Pose2 off = between(before.mean, tracked.pose);
  tracked.odometry_contradicted =
      jump || (has_odometry && (std::hypot(off.x, off.y) > kContradiction * before.sigma_m + 0.05 ||
                                std::abs(off.yaw) > kContradiction * before.sigma_rad + 0.03));
  last_step_ = resuming_ ? Pose2{} : between(pose_, tracked.pose);
  constexpr double kForget = 0.97;
  longest_step_m_ = std::max(kForget * longest_step_m_, std::hypot(last_step_.x, last_step_.y));
  if (tracked.matched) resuming_ = false;
  pose_ = tracked.pose;
  last_odometry_ = odom_T_base;
  if (enough && !tracked.lost) remember(points, pose_);
  last_scan_ = points;
  return tracked;
}

/// Scans that show other surroundings follow odometry; after some of them, or where the robot drove on
/// without scans, tracking begins anew.
void Tracker::watch_place(const ScanPoints& points, const PosePrior& prior, Tracked& tracked) {
  const bool lost = shows_elsewhere(points, prior, tracked);
  const bool drove = lost && lost_scans_ == 0 && !fixed_ && !resuming_ && drove_unseen(prior.mean);
  lost_scans_ = lost && !drove ? lost_scans_ + 1 : 0;
  if (!lost) return;
  const double fit = tracked.fit;
  tracked = {};
  tracked.pose = prior.mean;
  tracked.fit = fit;
  if (drove) return restart();
  tracked.lost = fixed_ || lost_scans_ < kCarriedScans;
  if (fixed_ && lost_scans_ >= kCarriedScans) resuming_ = true;
  if (tracked.lost) return;
  restart();
  tracked.fit = 1.0;
  tracked.matched = tracked.carried = true;
}

void Tracker::match_scan(const ScanPoints& points, const PosePrior& prior, Tracked& tracked) const {
  ScanMatch best = match(map_, points, prior.mean, prior, kPointReachM);
  if (best.fit < minimum_fit_ + kComfortableFit || is_unusual(best)) best = look_wider(points, prior, best);
  tracked.fit = best.fit;
  if (best.fit < minimum_fit_ && best.used * 2 < static_cast<int>(points.surface.size())) return;
  tracked.matched = true;
  tracked.pose = best.pose;
  tracked.information = best.information;
}

bool Tracker::is_unusual(const ScanMatch& match) const {
  return match.fit < usual_fit_ - kUnusualDrop;
}

/// True when a scan has too little in common with the one before it, wherever near it is placed, or when
/// those since then still do not fit the local map. A robot that drives through a door sees both sides of it
/// for a while.
bool Tracker::shows_elsewhere(const ScanPoints& points, const PosePrior& prior,
                              const Tracked& tracked) const {
  constexpr double kResumedFit = 0.55;
  constexpr double kMaxFit = 0.65;
  constexpr double kDrop = 0.25;    // of the fit, below that of the latest scans
  constexpr double kCommon = 0.55;  // fraction of either scan
  if (points.surface.size() < kMinContradictingPoints || recent_.empty()) return false;
  if (resuming_) return tracked.fit < kResumedFit;
  if (tracked.fit > std::min(kMaxFit, usual_fit_ - kDrop)) return false;
  if (lost_scans_ > 0) return true;
  return last_scan_.surface.size() >= kMinContradictingPoints &&
         common_with_last(points, between(pose_, tracked.pose), window_about(prior.mean)) < kCommon;
}

/// The largest fraction of the scan or of the one before it that the other explains, near `step`.
double Tracker::common_with_last(const ScanPoints& points, const Pose2& step, const Window& window) const {
  SurfaceMap last;
  last.add(last_scan_, {});
  SurfaceMap now;
  now.add(points, {});
  const auto common = [&](const ScanMatch& found) {
    const Agreement forward = agreement(last, points, found.pose);
    const Agreement backward = agreement(now, last_scan_, inverse(found.pose));
    return std::max(forward.on_surface / std::max(1.0, forward.all),
                    backward.on_surface / std::max(1.0, backward.all));
  };
  const Pose2 wide = search_near(last, points, step, window.m, window.rad);
  return std::max(common(match(last, points, step, {step, 0.1, 0.1}, kPointReachM)),
                  common(match(last, points, wide, {wide, 1.0, 1.0}, kPointReachM)));
}

/// Fraction of the scan that the local map explains, less what contradicts it: points beside surfaces that
/// they should lie on, and points where the latest scans saw free space. Points where nothing was seen yet
/// are no argument.
double Tracker::support(const ScanPoints& points, const Pose2& pose) const {
  constexpr std::size_t kApart = 5;
  constexpr std::size_t kProfiles = 4;
  constexpr double kInFreeSpace = 2.0;
  const Agreement seen = agreement(map_, points, pose);
  double in_free_space = 0;
  for (std::size_t i = 0; i < kProfiles && i * kApart < recent_.size(); ++i) {
    const Remembered& other = recent_[recent_.size() - 1 - i * kApart];
    in_free_space =
        std::max(in_free_space, fraction_in_free_space(other.profile, points, between(other.pose, pose)));
  }
  return (2 * seen.on_surface - seen.near_surface) / std::max(1.0, seen.all) - kInFreeSpace * in_free_space;
}

/// What wheels that do not slip are off by in a step, at most.
Tracker::StepError Tracker::usual_error(const Pose2& step) const {
  constexpr double kNoiseM = 0.02;
  constexpr double kNoiseRad = 0.02;
  constexpr double kSigmas = 3.0;
  const double distance_m = std::hypot(step.x, step.y);
  const double rotation_rad = std::abs(step.yaw);
  return {kNoiseM + kSigmas * (noise_.srr * distance_m + noise_.str * 0.2 * rotation_rad),
          kNoiseRad + kSigmas * (noise_.stt * rotation_rad + noise_.srt * distance_m)};
}

bool Tracker::disagrees(const Pose2& matched, const Pose2& step, const Pose2& by_wheels) const {
  const StepError usual = usual_error(step);
  const Pose2 off = between(by_wheels, matched);
  return std::hypot(off.x, off.y) > usual.m || std::abs(off.yaw) > usual.rad;
}

/// Neither side is believed blindly when they disagree by more than the noise of wheels that do not slip.
Eigen::Matrix3d Tracker::doubt(const Tracked& tracked, const Pose2& step, const PosePrior& prior) const {
  // The matched pose is off by this fraction of the disagreement, as one standard deviation.
  constexpr double kOff = 0.5;
  constexpr double kOffWithGoodFit = 0.2;
  const bool good = tracked.matched &&
                    tracked.fit > std::max(minimum_fit_ + kComfortableFit, usual_fit_ - 0.5 * kUnusualDrop);
  const double trust = good ? kOffWithGoodFit : kOff;
  const StepError usual = usual_error(step);
  Eigen::Vector3d off(tracked.pose.x - prior.mean.x, tracked.pose.y - prior.mean.y,
                      wrap_angle(tracked.pose.yaw - prior.mean.yaw));
  Eigen::Matrix3d doubt = Eigen::Matrix3d::Zero();
  off *= trust;
  if (off.head<2>().norm() > trust * usual.m)
    doubt.topLeftCorner<2, 2>() = off.head<2>() * off.head<2>().transpose();
  if (std::abs(off.z()) > trust * usual.rad) doubt(2, 2) = off.z() * off.z();
  return doubt;
}

/// What a motion is uncertain by that no scan measures: it follows the wheels, whose errors grow with the
/// root of the distance, or nothing at all.
Eigen::Matrix3d Tracker::reckoned(const Pose2& step, bool has_odometry) const {
  const auto square = [](double value) { return value * value; };
  double position_m2 = square(kUnknownStepM);
  double rotation_rad2 = square(kUnknownStepRad);
  if (has_odometry) {
    const double distance_m = std::hypot(step.x, step.y);
    const double rotation_rad = std::abs(step.yaw);
    position_m2 = square(noise_.srr) * distance_m + square(0.2 * noise_.str) * rotation_rad;
    rotation_rad2 = square(noise_.stt) * rotation_rad + square(noise_.srt) * distance_m;
  }
  return Eigen::Vector3d(position_m2, position_m2, rotation_rad2).asDiagonal();
}

/// Without odometry neither scan nor wheels measure the motion along a corridor: it may be what it was
/// lately.
Eigen::Matrix3d Tracker::unmeasured(const Tracked& tracked) const {
  constexpr double kOff = 0.5;  // of the motion, as one standard deviation
  Eigen::Matrix3d doubt = Eigen::Matrix3d::Zero();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(tracked.information.topLeftCorner<2, 2>());
  if (axes.eigenvalues()[0] > kWeakRatio * axes.eigenvalues()[1]) return doubt;
  const Eigen::Vector2d along = axes.eigenvectors().col(0);
  const double moved_m = moved_along(along, pose_, tracked.pose).norm();
  const Eigen::Vector2d off = kOff * std::max(moved_m, longest_step_m_) * along;
  doubt.topLeftCorner<2, 2>() = off * off.transpose();
  return doubt;
}

/// In a corridor few points constrain the position along it, and some of those are people, or move with the
/// robot as returns from walls at a grazing angle do. They pull the match slightly from scan to scan, so the
/// deviation is summed over half a metre. Wheels that do not slip have a constant relative error: within that
/// error the match decides, because it is tied to the local map; beyond it odometry does.
void Tracker::watch_slide(const ScanPoints& points, const PosePrior& prior, const Pose2& step,
                          Tracked& tracked) {
  const double distance_m = std::hypot(step.x, step.y);
  const double wheels_m = noise_.srr * distance_m + noise_.str * std::abs(step.yaw);
  const double keep = std::exp(-distance_m / kSlideDistanceM);
  slide_ = {keep * slide_.off_m, keep * slide_.wheels_m};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(tracked.information.topLeftCorner<2, 2>());
  if (axes.eigenvalues()[0] > kWeakRatio * axes.eigenvalues()[1]) return;
  const Eigen::Vector2d along = axes.eigenvectors().col(0);
  slide_.off_m += moved_along(along, prior.mean, tracked.pose);
  slide_.wheels_m += wheels_m;
  if (std::abs(along.dot(slide_.off_m)) <= kMinWheelErrorM + slide_.wheels_m) return;
  hold(points, {prior.mean, kFreeM, prior.sigma_rad, along, 0.5 * (kMinWheelErrorM + wheels_m)}, tracked);
}

/// Undoes the slide along a corridor and matches again with odometry as a narrow prior along it, unless the
/// scan then fits clearly worse: wheels do slip.
void Tracker::hold(const ScanPoints& points, PosePrior prior, Tracked& tracked) {
  constexpr double kClearlyWorse = 0.12;
  const double slid_m = prior.along.dot(slide_.off_m);
  prior.mean = {tracked.pose.x - slid_m * prior.along.x(), tracked.pose.y - slid_m * prior.along.y(),
                tracked.pose.yaw};
  const ScanMatch held = match(map_, points, prior.mean, prior, kPointReachM);
  if (graded_fit(map_, points, held.pose) < graded_fit(map_, points, tracked.pose) - kClearlyWorse) {
    slide_ = {};
    return;
  }
  if (!wheel_spin_) begin_hold(prior.along);
  slide_.off_m += moved_along(prior.along, tracked.pose, held.pose);
  tracked.pose = held.pose;
  tracked.fit = held.fit;
  tracked.information = held.information;
}

void Tracker::begin_hold(const Eigen::Vector2d& along) {
  SurfaceMap before;
  for (const Remembered& scan : recent_)
    if (std::hypot(scan.pose.x - pose_.x, scan.pose.y - pose_.y) > WheelSpin::kWellBeforeM)
      before.add(scan.points, scan.pose);
  wheel_spin_.emplace(pose_, along, std::move(before));
}

/// Whether odometry decides rightly along the corridor, or the wheels spin.
void Tracker::judge_hold(const ScanPoints& points, Tracked& tracked) {
  if (!wheel_spin_) return;
  const WheelSpin::Verdict verdict = wheel_spin_->add(points, tracked.pose);
  if (verdict == WheelSpin::Verdict::kStands) {
    const ScanMatch& place = wheel_spin_->place();
    tracked.pose = place.pose;
    tracked.fit = place.fit;
    tracked.information = place.information;
    recent_.erase(
        std::remove_if(recent_.begin(), recent_.end(), [](const Remembered& scan) { return scan.held; }),
        recent_.end());
    redraw();
  }
  if (verdict != WheelSpin::Verdict::kOpen) end_hold();
}

void Tracker::end_hold() {
  wheel_spin_.reset();
  slide_ = {};
  for (Remembered& scan : recent_) scan.held = false;
}

/// For slipping wheels, jumps of odometry, a carried robot, or much new surroundings: searches around the
/// pose of odometry, the constant-velocity prediction and the last pose. The farther from odometry, the more
/// the scan must speak for a pose: the logarithm of a heavy-tailed prior, weighed against the support.
ScanMatch Tracker::look_wider(const ScanPoints& points, const PosePrior& prior,
                              const ScanMatch& first) const {
  constexpr double kSameRad = 0.15;
  constexpr double kMinGain = 0.05;
  constexpr double kGainPerLog = 0.045;
  constexpr double kFullScan = 200;  // points; fewer prove less
  constexpr double kSamePlaceM = 0.2;
  const Window window = window_about(prior.mean);
  ScanMatch best = first;
  double best_score = support(points, first.pose) + kMinGain;
  const double per_log =
      kGainPerLog * std::clamp(kFullScan / static_cast<double>(points.surface.size()), 1.0, 4.0);
  const auto cost = [&](const Pose2& pose) {
    const double m = std::hypot(pose.x - prior.mean.x, pose.y - prior.mean.y) / prior.sigma_m;
    const double rad = wrap_angle(pose.yaw - prior.mean.yaw) / prior.sigma_rad;
    return resuming_ ? 0.0 : per_log * std::log1p(m * m + rad * rad);
  };
  best_score -= cost(first.pose);
  std::vector<Pose2> tried;
  for (const Pose2& centre : {prior.mean, compose(pose_, last_step_), pose_}) {
    const bool known = std::any_of(tried.begin(), tried.end(), [&](const Pose2& other) {
      return std::hypot(other.x - centre.x, other.y - centre.y) < kSamePlaceM &&
             std::abs(wrap_angle(other.yaw - centre.yaw)) < kSameRad;
    });
    if (known) continue;
    tried.push_back(centre);
    const Pose2 start = search_near(map_, points, centre, window.m, window.rad);
    const ScanMatch wide = match(map_, points, start, {start, 1.0, 1.0}, kPointReachM);
    const double score = support(points, wide.pose) - cost(wide.pose);
    if (score <= best_score) continue;
    best = wide;
    best_score = score;
  }
  return best;
}

void Tracker::remember(const ScanPoints& points, const Pose2& pose) {
  if (fixed_) return;
  if (!recent_.empty()) {
    const Pose2 since = between(recent_.back().pose, pose);
    if (std::hypot(since.x, since.y) < kRememberEveryM && std::abs(since.yaw) < kRememberEveryRad) return;
  }
  recent_.push_back({pose, points, RangeProfile(points), wheel_spin_.has_value()});
  map_.add(points, pose);
  if (recent_.size() < 2 * kRemembered) return;
  while (recent_.size() > kRemembered) recent_.pop_front();
  redraw();
}

/// The local map begins anew, with the next scan that is remembered.
void Tracker::restart() {
  recent_.clear();
  map_.clear();
  slide_ = {};
  wheel_spin_.reset();
  lost_scans_ = 0;
  usual_fit_ = 0;
}

void Tracker::redraw() {
  map_.clear();
  for (const Remembered& scan : recent_) map_.add(scan.points, scan.pose);
}

void Tracker::resume_from(const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses,
                          const Pose2& pose) {
  restart();
  // The newest ones where the robot stands at their end, else those around it.
  std::vector<std::size_t> chosen;
  for (std::size_t i = frames.size(); i-- > 0;)
    if (!frames[i].is_thinned()) chosen.push_back(i);
  const auto away = [&](std::size_t i) { return std::hypot(poses[i].x - pose.x, poses[i].y - pose.y); };
  if (away(frames.size() - 1) > kReachOfNewestM)
    std::stable_sort(chosen.begin(), chosen.end(),
                     [&](std::size_t a, std::size_t b) { return away(a) < away(b); });
  chosen.resize(std::min(chosen.size(), kRemembered));
  std::sort(chosen.begin(), chosen.end());
  take(frames, poses, chosen);
  begin_at(pose);
}

void Tracker::begin_at(const Pose2& pose) {
  pose_ = pose;
  last_step_ = {};
  last_odometry_.reset();
  slide_ = {};
  resuming_ = true;
}

void Tracker::use_as_map(const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses,
                         const std::vector<std::size_t>& chosen) {
  fixed_ = true;
  take(frames, poses, chosen);
}

/// As local map.
void Tracker::take(const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses,
                   const std::vector<std::size_t>& chosen) {
  recent_.clear();
  for (const std::size_t i : chosen)
    recent_.push_back({poses[i], frames[i].points, RangeProfile(frames[i].points), false});
  redraw();
}

}  // namespace extperfc::mapping
