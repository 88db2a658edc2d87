#include "extperfc/mapping/mapper.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "extperfc/world/pose.hpp"

#include "mapping/closed_graph.hpp"
#include "mapping/known_map_tracker.hpp"
#include "mapping/map_parts.hpp"
#include "mapping/map_renderer.hpp"
#include "mapping/path_filter.hpp"
#include "mapping/pose_distance.hpp"
#include "mapping/rotation_by.hpp"
#include "mapping/session.hpp"
#include "mapping/submap_cache.hpp"
#include "mapping/thinning.hpp"
#include "mapping/tracker.hpp"

namespace extperfc::mapping {

namespace {

constexpr std::size_t kCellsPerMapCall = 1'500'000;  // drawn at most in one call of map()
// Updated in one call: 2.4 million cells; copied in one call: cells of a map whose extent grew or whose last
// version is still in use.
constexpr MapRenderer::MapBounds kMapCall{600, 6'000'000};
constexpr double kSmallestCovariance = 1e-8;
constexpr std::size_t kThinEveryFrames = 32;
constexpr std::size_t kSearchAfterFrames = 16;  // of a new part of the map

PathFilterParams filter_params(const MapperParams& params) {
  return {params.particles, params.resample_threshold, params.seed};
}

OdometryNoise odometry_noise(const MapperParams& params) {
  return {params.srr, params.srt, params.str, params.stt};
}

}  // namespace

struct LoopSearch::Impl {
  PathFilter::Search search;
};

LoopSearch::LoopSearch(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LoopSearch::LoopSearch(LoopSearch&&) noexcept = default;
LoopSearch& LoopSearch::operator=(LoopSearch&&) noexcept = default;
LoopSearch::~LoopSearch() = default;

void LoopSearch::run() {
  impl_->search.run();
}

class Mapper::Impl {
 public:
  explicit Impl(const MapperParams& params)
      : params_(params),
        tracker_(odometry_noise(params), params.minimum_score),
        filter_(filter_params(params)),
        renderer_(params.resolution_m, params.occupied_threshold) {}

  MapperUpdate add(const LaserScan& scan, const std::optional<Pose2>& odom_T_base);
  [[nodiscard]] Pose2 pose() const;
  [[nodiscard]] Trajectory trajectory() const;
  [[nodiscard]] MapperStatistics statistics() const;
  [[nodiscard]] std::vector<WeightedPose> particles() const;
  std::shared_ptr<const OccupancyGrid> map();
  [[nodiscard]] PathFilter::Search search() const { return filter_.search(); }
  bool adopt(PathFilter::Search search);
  void finish();
  void redraw();
  [[nodiscard]] Result<void> save(const std::filesystem::path& file) const;
  void resume_from(Session session);
  [[nodiscard]] Session session() const { return {filter_.frames(), filter_.graph(), scans_}; }
  [[nodiscard]] Result<void> put_at(const Pose2& pose, const Eigen::Matrix3d& covariance);
  void expect_elsewhere();
  [[nodiscard]] Result<void> set_mode(MapperMode mode);
  [[nodiscard]] MapperMode mode() const {
    return known_map_ ? MapperMode::kLocalization : MapperMode::kMapping;
  }
  [[nodiscard]] bool wants_search() const {
    return filter_.parts() > 1 && filter_.frames().size() >= next_search_;
  }
  [[nodiscard]] const MapperParams& params() const { return params_; }
  [[nodiscard]] bool settled() const { return settled_ && renderer_.complete(); }
  [[nodiscard]] std::uint64_t map_version() const { return map_version_; }

 private:
  void map_scan(const LaserScan& scan, const ScanPoints& points, const Tracked& tracked,
                MapperUpdate& update);
  [[nodiscard]] bool wants_key_frame(const LaserScan& scan, const Tracked& tracked) const;
  bool add_key_frame(const ScanPoints& points, const Tracked& tracked);
  void thin();
  void add_carried(const ScanPoints& points, const Tracked& tracked);
  void begin_step(const Tracked& tracked);
  [[nodiscard]] Eigen::Matrix3d covariance(const Tracked& tracked) const;

  MapperParams params_;
  Tracker tracker_;
  std::optional<KnownMapTracker> known_map_;  ///< during localization
  PathFilter filter_;
  MapRenderer renderer_;
  std::vector<PassedScan> scans_;
  MapperStatistics statistics_;
  Pose2 key_pose_;  ///< tracked pose of the newest key frame
  double key_path_m_{0};
  Eigen::Matrix3d doubt_{Eigen::Matrix3d::Zero()};  ///< of the steps since then
  double key_stamp_s_{0};
  std::optional<double> last_stamp_s_;
  std::size_t lost_scans_{0};        ///< the latest ones
  std::optional<StartPose> put_at_;  ///< since the latest scan
  std::size_t first_of_part_{0};  ///< key frame from which on the robot's pose in the other parts is unknown
  std::size_t next_search_{0};    ///< number of key frames from which on a search may join parts
  bool settled_{true};
  bool settle_at_once_{false};  ///< after finish(): no time bound
  std::uint64_t map_version_{0};
};

MapperUpdate Mapper::Impl::add(const LaserScan& scan, const std::optional<Pose2>& odom_T_base) {
  const auto points = scan_points(scan, {params_.max_usable_range_m, params_.max_range_m});
  const Pose2 before = tracker_.pose();
  const double gap_s = last_stamp_s_ ? std::max(0.0, scan.stamp_s - *last_stamp_s_) : 0.0;
  last_stamp_s_ = scan.stamp_s;
  const Tracked tracked = known_map_
                              ? known_map_->add(points, odom_T_base, gap_s, filter_.frames(), filter_.poses())
                              : tracker_.add(points, odom_T_base, gap_s);
  statistics_.path_m += distance(tracker_.pose(), before);
  ++statistics_.scans;
  if (tracked.odometry_contradicted) ++statistics_.odometry_contradictions;
  MapperUpdate update;
  update.fit = tracked.fit;
  update.matched = tracked.matched;
  update.odometry_contradicted = tracked.odometry_contradicted;
  update.lost = tracked.lost;
  update.carried = tracked.carried;
  if (points.surface.size() < Tracker::kMinPoints) {
    update.status = ScanStatus::kUnusable;
    ++statistics_.unusable_scans;
  }
  if (!known_map_) map_scan(scan, points, tracked, update);
  update.pose = pose();
  update.covariance = known_map_ ? known_map_->covariance() : covariance(tracked);
  return update;
}

void Mapper::Impl::map_scan(const LaserScan& scan, const ScanPoints& points, const Tracked& tracked,
                            MapperUpdate& update) {
  settle_at_once_ = false;
  doubt_ += tracked.doubt;
  scans_.push_back({scan.stamp_s, tracked.pose, 0});
  if (!tracked.carried) lost_scans_ = tracked.lost ? lost_scans_ + 1 : 0;
  if (update.status != ScanStatus::kUnusable) {
    if ((tracked.carried || (put_at_ && !tracked.lost)) && !filter_.frames().empty()) {
      update.status = ScanStatus::kKeyFrame;
      update.map_changed = true;
      add_carried(points, tracked);
    } else if (!tracked.lost && wants_key_frame(scan, tracked)) {
      update.status = ScanStatus::kKeyFrame;
      update.map_changed = add_key_frame(points, tracked);
    }
    if (update.status == ScanStatus::kKeyFrame) key_stamp_s_ = scan.stamp_s;
  }
  const std::size_t frames = filter_.frames().size();
  scans_.back().key_frame = frames == 0 ? 0 : static_cast<std::uint32_t>(frames - 1);
}

bool Mapper::Impl::wants_key_frame(const LaserScan& scan, const Tracked& tracked) const {
  if (filter_.frames().empty()) return true;
  const Pose2 since = between(key_pose_, tracked.pose);
  const double waited_s = std::abs(scan.stamp_s - key_stamp_s_);
  return std::hypot(since.x, since.y) >= params_.linear_update_m ||
         std::abs(since.yaw) >= params_.angular_update_rad ||
         (params_.temporal_update_s >= 0 && waited_s >= params_.temporal_update_s);
}

/// True when poses of old key frames changed.
bool Mapper::Impl::add_key_frame(const ScanPoints& points, const Tracked& tracked) {
  KeyFrame frame{scans_.size() - 1, statistics_.path_m, points};
  PathFilter::Step step;
  if (filter_.frames().empty()) {
    filter_.begin(tracked.pose, std::move(frame));
  } else {
    const Eigen::Matrix3d rotation = rotation_by(-key_pose_.yaw);
    const TrackedStep tracked_step{
        between(key_pose_, tracked.pose), rotation * tracked.information * rotation.transpose(),
        statistics_.path_m - key_path_m_, rotation * doubt_ * rotation.transpose()};
    step = filter_.add(tracked_step, std::move(frame));
  }
  begin_step(tracked);
  if (filter_.frames().size() % kThinEveryFrames == 0) thin();
  return step.map_changed;
}

/// Parts that are not joined yet need all that was seen.
void Mapper::Impl::thin() {
  if (filter_.parts() > 1) return;
  const auto often =
      seen_often(filter_.frames(), filter_.poses(), static_cast<std::size_t>(params_.kept_passes));
  for (const std::size_t i : often) renderer_.forget(i, filter_.frames()[i].points);
  filter_.thin(often);
  statistics_.thinned_key_frames += often.size();
}

/// Of a robot that was carried: to a pose that was given, or anywhere.
void Mapper::Impl::add_carried(const ScanPoints& points, const Tracked& tracked) {
  constexpr double kMatchedM = 0.1;
  constexpr double kMatchedRad = 0.05;
  if (put_at_ && !tracked.carried) {
    if (tracked.matched) {
      put_at_->pose = tracked.pose;
      put_at_->covariance =
          Eigen::Vector3d(kMatchedM * kMatchedM, kMatchedM * kMatchedM, kMatchedRad * kMatchedRad)
              .asDiagonal();
    }
  } else {
    put_at_.reset();
    ++statistics_.carried;
  }
  const auto driven = put_at_ ? std::nullopt : std::optional<Pose2>(between(key_pose_, tracked.pose));
  filter_.add_carried(put_at_, driven, {scans_.size() - 1, statistics_.path_m, points});
  // Scans since the robot was put down belong to the new part.
  const std::size_t newest = filter_.frames().size() - 1;
  for (std::size_t i = 0; i < std::min(lost_scans_, scans_.size() - 1); ++i)
    scans_[scans_.size() - 2 - i].key_frame = static_cast<std::uint32_t>(newest);
  put_at_.reset();
  first_of_part_ = filter_.frames().size() - 1;
  next_search_ = first_of_part_ + kSearchAfterFrames;
  begin_step(tracked);
}

/// The newest key frame is where the next step begins.
void Mapper::Impl::begin_step(const Tracked& tracked) {
  key_pose_ = tracked.pose;
  key_path_m_ = statistics_.path_m;
  doubt_.setZero();
  settled_ = false;
  ++map_version_;
}

/// The local map is that of the key frames around, in the map's frame.
Result<void> Mapper::Impl::put_at(const Pose2& pose, const Eigen::Matrix3d& covariance) {
  if (filter_.frames().empty())
    return fail(ErrorCode::kInvalidArgument, "there is no map yet in which the robot could be put somewhere");
  if (!is_finite(pose) || !covariance.allFinite() ||
      Eigen::LLT<Eigen::Matrix3d>(covariance).info() != Eigen::Success)
    return fail(ErrorCode::kInvalidArgument,
                "the robot's pose must be finite, and its covariance finite and positive definite");
  if (known_map_) {
    known_map_.emplace(odometry_noise(params_), params_.minimum_score, pose, covariance);
    return {};
  }
  const Pose2 moved = compose(filter_.poses().back(), inverse(key_pose_));
  for (PassedScan& scan : scans_) scan.tracked = compose(moved, scan.tracked);
  key_pose_ = filter_.poses().back();
  tracker_.resume_from(filter_.frames(), filter_.poses(), pose);
  put_at_ = StartPose{pose, covariance};
  return {};
}

void Mapper::Impl::expect_elsewhere() {
  if (known_map_)
    known_map_->expect_elsewhere();
  else
    tracker_.expect_elsewhere();
}

Result<void> Mapper::Impl::set_mode(MapperMode mode) {
  constexpr double kKnownM = 0.2;
  constexpr double kKnownRad = 0.1;
  if (mode == this->mode()) return {};
  if (filter_.frames().empty())
    return fail(ErrorCode::kInvalidArgument, "there is no map yet in which the robot could be localized");
  if (mode == MapperMode::kLocalization) {
    const StartPose usual{
        pose(), Eigen::Vector3d(kKnownM * kKnownM, kKnownM * kKnownM, kKnownRad * kKnownRad).asDiagonal()};
    const StartPose start = put_at_.value_or(usual);
    put_at_.reset();
    known_map_.emplace(odometry_noise(params_), params_.minimum_score, start.pose, start.covariance);
    return {};
  }
  const KnownMapTracker localized = *std::exchange(known_map_, std::nullopt);
  return put_at(localized.pose(), localized.covariance());
}

Pose2 Mapper::Impl::pose() const {
  if (known_map_) return known_map_->pose();
  if (filter_.poses().empty()) return tracker_.pose();
  return compose(filter_.poses().back(), between(key_pose_, tracker_.pose()));
}

Eigen::Matrix3d Mapper::Impl::covariance(const Tracked& tracked) const {
  const Eigen::Matrix3d tracked_covariance =
      (tracked.information + kSmallestCovariance * Eigen::Matrix3d::Identity()).inverse();
  const Eigen::Matrix3d rotation = rotation_by(wrap_angle(pose().yaw - tracker_.pose().yaw));
  Eigen::Matrix3d since_key_frame = rotation * tracked_covariance * rotation.transpose();
  if (filter_.frames().empty()) return since_key_frame;
  const Eigen::Matrix3d to_map = rotation_by(filter_.poses().front().yaw);
  return since_key_frame + filter_.covariance() +
         to_map * filter_.uncertainty().with_bias() * to_map.transpose();
}

/// Between two key frames, the corrections of both are blended by the number of scans from either.
Trajectory Mapper::Impl::trajectory() const {
  Trajectory trajectory;
  trajectory.reserve(scans_.size());
  const auto& frames = filter_.frames();
  const auto& poses = filter_.poses();
  std::vector<bool> carried_from(frames.size(), false);
  for (const Constraint& constraint : filter_.graph().constraints())
    if (constraint.is_unknown()) carried_from[constraint.from] = true;
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    const PassedScan& scan = scans_[i];
    if (frames.empty()) {
      trajectory.push_back({scan.stamp_s, scan.tracked});
      continue;
    }
    const std::size_t k = scan.key_frame;
    Pose2 pose = compose(poses[k], between(scans_[frames[k].scan].tracked, scan.tracked));
    if (k + 1 < frames.size() && i >= frames[k].scan &&
        !carried_from[k]) {  // scans before the first key frame hang on it alone
      const std::size_t next_scan = frames[k + 1].scan;
      const Pose2 other = compose(poses[k + 1], between(scans_[next_scan].tracked, scan.tracked));
      const double fraction =
          static_cast<double>(i - frames[k].scan) / static_cast<double>(next_scan - frames[k].scan);
      pose = {pose.x + fraction * (other.x - pose.x), pose.y + fraction * (other.y - pose.y),
              wrap_angle(pose.yaw + fraction * wrap_angle(other.yaw - pose.yaw))};
    }
    trajectory.push_back({scan.stamp_s, pose});
  }
  return trajectory;
}

MapperStatistics Mapper::Impl::statistics() const {
  MapperStatistics statistics = statistics_;
  statistics.key_frames = filter_.frames().size();
  statistics.loops = filter_.loops();
  statistics.parts = std::max<std::size_t>(1, filter_.parts());
  statistics.resamplings = filter_.resamplings();
  statistics.effective_particles = filter_.effective_particles();
  statistics.entropy = filter_.entropy();
  if (!filter_.frames().empty()) statistics.position_sigma_m = filter_.uncertainty().sigma_m();
  return statistics;
}

std::vector<WeightedPose> Mapper::Impl::particles() const {
  std::vector<WeightedPose> particles;
  const auto weights = filter_.weights();
  for (std::size_t i = 0; i < weights.size(); ++i)
    particles.push_back({filter_.particles()[i].pose, weights[i]});
  return particles;
}

std::shared_ptr<const OccupancyGrid> Mapper::Impl::map() {
  if (!settled_) {
    settled_ = renderer_.update(filter_.frames(), filter_.poses(), kCellsPerMapCall);
    if (!settled_) ++map_version_;
  }
  const bool was_complete = renderer_.complete();
  auto map = settle_at_once_ ? renderer_.map() : renderer_.map(kMapCall);
  if (!renderer_.complete() || !was_complete) ++map_version_;
  return map;
}

bool Mapper::Impl::adopt(PathFilter::Search search) {
  const std::vector<Pose2> before = filter_.poses();
  if (!filter_.adopt(std::move(search))) return false;
  if (known_map_) known_map_->follow(before, filter_.poses());
  const std::size_t frames = filter_.frames().size();
  next_search_ = frames + std::max(kSearchAfterFrames, frames - std::min(frames, first_of_part_));
  settled_ = false;
  ++map_version_;
  return true;
}

void Mapper::Impl::finish() {
  const std::vector<Pose2> before = filter_.poses();
  filter_.finish();
  if (known_map_) known_map_->follow(before, filter_.poses());
  redraw();
}

/// The whole map, at once.
void Mapper::Impl::redraw() {
  settle_at_once_ = true;
  settled_ = renderer_.update(filter_.frames(), filter_.poses(), std::numeric_limits<std::size_t>::max());
  ++map_version_;
}

Result<void> Mapper::Impl::save(const std::filesystem::path& file) const {
  return write_session(session(), file);
}

/// The tracker resumes in the map's frame, using the session's latest key frames as local map.
void Mapper::Impl::resume_from(Session session) {
  scans_ = std::move(session.scans);
  const auto& poses = session.graph.poses();
  // Old scans keep their poses relative to their key frames; the tracker resumes at the newest key frame.
  const std::size_t newest = session.frames.back().scan;
  const Pose2 moved = compose(poses.back(), inverse(scans_[newest].tracked));
  for (PassedScan& scan : scans_) scan.tracked = compose(moved, scan.tracked);
  tracker_.resume_from(session.frames, poses, scans_.back().tracked);
  statistics_.scans = scans_.size();
  statistics_.path_m = session.frames.back().travelled_m;
  statistics_.thinned_key_frames =
      static_cast<std::size_t>(std::count_if(session.frames.begin(), session.frames.end(),
                                             [](const KeyFrame& frame) { return frame.is_thinned(); }));
  key_pose_ = poses.back();
  key_path_m_ = statistics_.path_m;
  key_stamp_s_ = scans_.back().stamp_s;
  filter_.restore(std::move(session.frames), std::move(session.graph));
  first_of_part_ = filter_.frames().size();
  next_search_ = first_of_part_ + kSearchAfterFrames;
  settled_ = false;
  ++map_version_;
}

namespace {

tl::unexpected<Error> out_of_range(const char* name, double value, const char* range) {
  return fail(ErrorCode::kInvalidArgument,
              std::string(name) + " is " + std::to_string(value) + ", which is outside " + range);
}

}  // namespace

Result<void> validate(const MapperParams& params) {
  struct Check {
    const char* name;
    double value;
    double lowest;
    double highest;
    const char* range;
  };
  constexpr double kMaxMagnitude = 1e6;
  const Check checks[] = {
      {"particles", static_cast<double>(params.particles), 1, 1000, "[1, 1000]"},
      {"delta (resolution)", params.resolution_m, 0.01, 1, "[0.01, 1] m"},
      {"maxRange", params.max_range_m, 0, kMaxMagnitude, "[0, 1e6] m"},
      {"maxUrange", params.max_usable_range_m, 0, kMaxMagnitude, "[0, 1e6] m"},
      {"linearUpdate", params.linear_update_m, 0.05, 5, "[0.05, 5] m"},
      {"angularUpdate", params.angular_update_rad, 0.02, 3.2, "[0.02, 3.2] rad"},
      {"temporalUpdate", params.temporal_update_s, -kMaxMagnitude, kMaxMagnitude, "[-1e6, 1e6] s"},
      {"resampleThreshold", params.resample_threshold, 0, 1, "[0, 1]"},
      {"minimumScore", params.minimum_score, 0, 1, "[0, 1]"},
      {"srr", params.srr, 0, 10, "[0, 10]"},
      {"srt", params.srt, 0, 10, "[0, 10]"},
      {"str", params.str, 0, 10, "[0, 10]"},
      {"stt", params.stt, 0, 10, "[0, 10]"},
      {"keptPasses", static_cast<double>(params.kept_passes), 0, 100, "[0, 100]"},
      {"occ_thresh", params.occupied_threshold, 0.01, 0.99, "[0.01, 0.99]"},
  };
  for (const Check& check : checks)
    if (!(check.value >= check.lowest && check.value <= check.highest))  // NaN fails
      return out_of_range(check.name, check.value, check.range);
  return {};
}

Result<Mapper> Mapper::make(const MapperParams& params) {
  if (auto valid = validate(params); !valid) return tl::unexpected(valid.error());
  return Mapper(std::make_unique<Impl>(params));
}

Mapper::Mapper(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Mapper::Mapper(Mapper&&) noexcept = default;
Mapper& Mapper::operator=(Mapper&&) noexcept = default;
Mapper::~Mapper() = default;

Result<MapperUpdate> Mapper::add(const LaserScan& scan, const std::optional<Pose2>& odom_T_base) {
  if (auto valid = extperfc::validate(scan); !valid) return tl::unexpected(valid.error());
  if (odom_T_base && !is_finite(*odom_T_base))
    return fail(ErrorCode::kInvalidArgument, "odometry is not a finite pose");
  return impl_->add(scan, odom_T_base);
}

Result<void> Mapper::put_at(const Pose2& pose, const Eigen::Matrix3d& covariance) {
  return impl_->put_at(pose, covariance);
}

void Mapper::expect_elsewhere() {
  impl_->expect_elsewhere();
}

Result<void> Mapper::set_mode(MapperMode mode) {
  return impl_->set_mode(mode);
}

MapperMode Mapper::mode() const {
  return impl_->mode();
}

bool Mapper::wants_search() const {
  return impl_->wants_search();
}

Pose2 Mapper::pose() const {
  return impl_->pose();
}

std::vector<WeightedPose> Mapper::particles() const {
  return impl_->particles();
}

std::shared_ptr<const OccupancyGrid> Mapper::map() {
  return impl_->map();
}

bool Mapper::settled() const {
  return impl_->settled();
}

std::uint64_t Mapper::map_version() const {
  return impl_->map_version();
}

Trajectory Mapper::trajectory() const {
  return impl_->trajectory();
}

MapperStatistics Mapper::statistics() const {
  return impl_->statistics();
}

void Mapper::optimize() {
  LoopSearch whole = search();
  whole.run();
  (void)adopt(std::move(whole));
}

LoopSearch Mapper::search() const {
  return LoopSearch(std::make_unique<LoopSearch::Impl>(LoopSearch::Impl{impl_->search()}));
}

bool Mapper::adopt(LoopSearch search) {
  return impl_->adopt(std::move(search.impl_->search));
}

void Mapper::finish() {
  impl_->finish();
}

Result<void> Mapper::save(const std::filesystem::path& file) const {
  if (impl_->statistics().key_frames == 0)
    return fail(ErrorCode::kInvalidArgument, "cannot save the session: no scan was mapped yet");
  return impl_->save(file);
}

Result<Mapper> Mapper::load(const std::filesystem::path& file, const MapperParams& params) {
  if (auto valid = validate(params); !valid) return tl::unexpected(valid.error());
  auto session = read_session(file);
  if (!session) return tl::unexpected(session.error());
  auto impl = std::make_unique<Impl>(params);
  impl->resume_from(std::move(*session));
  return Mapper(std::move(impl));
}

Result<void> Mapper::merge(const std::filesystem::path& file) {
  auto other = read_session(file);
  if (!other) return tl::unexpected(other.error());
  if (impl_->statistics().key_frames == 0)
    return fail(ErrorCode::kInvalidArgument, "there is no map yet to merge " + file.string() + " with");
  const std::size_t parts = count_parts(impl_->session().graph) + count_parts(other->graph);
  Session both = concatenated(impl_->session(), std::move(*other));
  SubmapCache submaps;
  both.graph = closed_graph(both.frames, std::move(both.graph), {}, submaps);
  if (count_parts(both.graph) >= parts)
    return fail(ErrorCode::kNotFound, "no place of " + file.string() + " was recognized in the map");
  auto impl = std::make_unique<Impl>(impl_->params());
  impl->resume_from(std::move(both));
  impl->redraw();
  impl_ = std::move(impl);
  return {};
}

}  // namespace extperfc::mapping
