#include "ros/mapping/mapper_nodelet.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <pluginlib/class_list_macros.hpp>

#include "extperfc/base/stopwatch.hpp"

#include "ros/convert/laser_scan.hpp"

namespace extperfc::ros_mapping {

namespace {

constexpr double kRanBackS = 0.5;         ///< smaller steps backwards are out-of-order messages
constexpr double kComplaintPeriodS = 10;  ///< of the log, while an error lasts

const std_msgs::Header& header_of(const sensor_msgs::LaserScanConstPtr& scan,
                                  const sensor_msgs::MultiEchoLaserScanConstPtr& echoes) {
  return scan ? scan->header : echoes->header;
}

}  // namespace

MapperNodelet::~MapperNodelet() {
  closing_ = true;
  diagnostics_timer_.stop();
  scan_subscriber_.shutdown();
  imu_subscriber_.shutdown();
  people_subscriber_.shutdown();
  if (services_) services_->stop();
  if (queue_) queue_->close();
  if (frames_) frames_->close();
  imu_.close();
  if (worker_.joinable()) worker_.join();
  if (maps_) maps_->stop();
  if (frame_publisher_) frame_publisher_->stop();
}

void MapperNodelet::onInit() {
  auto params = ros_params::load_mapper_params(getPrivateNodeHandle());
  if (!params) {
    NODELET_FATAL("%s", params.error().message.c_str());
    throw std::runtime_error(params.error().message);
  }
  params_ = *params;
  if (!params_.notice.empty()) NODELET_WARN("%s", params_.notice.c_str());
  mapper_ = std::make_unique<SharedMapper>(make_mapper());
  make_parts();
  start_diagnostics();
  worker_ = std::thread([this] { work(); });
  if (!params_.session.empty()) maps_->changed(ros::Time::now());
  subscribe();
}

mapping::Mapper MapperNodelet::make_mapper() const {
  auto mapper = params_.session.empty() ? mapping::Mapper::make(params_.mapper)
                                        : mapping::Mapper::load(params_.session, params_.mapper);
  if (!mapper) {
    NODELET_FATAL("%s", mapper.error().message.c_str());
    throw std::runtime_error(mapper.error().message);
  }
  if (params_.localization) (void)mapper->set_mode(mapping::MapperMode::kLocalization);
  return std::move(*mapper);
}

void MapperNodelet::make_parts() {
  const auto handle = getNodeHandle();
  health_ = std::make_unique<MappingHealth>(params_.timeout_s);
  queue_ = std::make_unique<ScanQueue<Waiting>>(static_cast<std::size_t>(params_.queue_size));
  chain_.emplace(OdometryChain::Limits{params_.odometry_max_speed_m_s, params_.odometry_max_yaw_rate_rad_s});
  frames_ = std::make_unique<RobotFrames>(params_.base_frame, params_.odom_frame);
  people_ = std::make_unique<PeopleFilter>(params_.odom_frame);
  frame_publisher_ = std::make_unique<FramePublisher>(
      FramePublisher::Options{params_.map_frame, params_.transform_publish_period, params_.tf_delay});
  maps_ = std::make_unique<MapPublisher>(
      handle, *mapper_,
      MapPublisher::Options{params_.map_frame, params_.map_update_interval, params_.trajectory_interval_s});
  poses_ = std::make_unique<PosePublisher>(handle, getPrivateNodeHandle(), params_.map_frame);
  services_ = std::make_unique<MapperServices>(
      getNodeHandle(), getPrivateNodeHandle(), params_.mapper, params_.map_frame, *mapper_, *maps_,
      MapperServices::Callbacks{[this](bool paused) { set_paused(paused); }, [this] { on_other_map(); }});
}

/// By wall time: the updater's own clock stands still after time ran back.
void MapperNodelet::start_diagnostics() {
  updater_ =
      std::make_unique<diagnostic_updater::Updater>(getNodeHandle(), getPrivateNodeHandle(), getName());
  updater_->setHardwareID("none");
  updater_->add("mapper", this, &MapperNodelet::report);
  diagnostics_timer_ =
      getNodeHandle().createWallTimer(ros::WallDuration(params_.diagnostic_period),
                                      [this](const ros::WallTimerEvent&) { updater_->force_update(); });
}

void MapperNodelet::subscribe() {
  const auto depth = static_cast<std::uint32_t>(params_.queue_size);
  if (params_.use_imu)
    imu_subscriber_ = getNodeHandle().subscribe<sensor_msgs::Imu>(
        kImuTopic, 200, [this](const sensor_msgs::ImuConstPtr& message) { imu_.add(*message); });
  people_subscriber_ = getNodeHandle().subscribe<TrackArray>(
      "people_tracks", 1, [this](const TrackArrayConstPtr& message) { people_->add(*message); });
  scan_health_.listening(true);
  scan_subscriber_ = params_.multi_echo
                         ? getNodeHandle().subscribe(kScanTopic, depth, &MapperNodelet::on_echoes, this)
                         : getNodeHandle().subscribe(kScanTopic, depth, &MapperNodelet::on_scan, this);
}

void MapperNodelet::on_scan(const ros::MessageEvent<const sensor_msgs::LaserScan>& event) {
  const auto& message = event.getConstMessage();
  scan_health_.received(message->header.stamp, message->ranges.data(), ros_health::came_by_pointer(event));
  accept({message, nullptr, 0}, message->header);
}

void MapperNodelet::on_echoes(const ros::MessageEvent<const sensor_msgs::MultiEchoLaserScan>& event) {
  const auto& message = event.getConstMessage();
  scan_health_.received(message->header.stamp, message->ranges.data(), ros_health::came_by_pointer(event));
  accept({nullptr, message, 0}, message->header);
}

void MapperNodelet::accept(Waiting waiting, const std_msgs::Header& header) {
  const std::lock_guard lock(intake_mutex_);
  notice_time(header);
  if (paused_) return health_->skipped_while_paused();
  if (throttle_count_++ % static_cast<std::uint64_t>(params_.throttle_scans) != 0)
    return health_->throttled();
  waiting.epoch = epoch_;
  if (queue_->put(std::move(waiting))) health_->queue_full();
}

void MapperNodelet::notice_time(const std_msgs::Header& header) {
  const bool back = header.stamp.toSec() < newest_stamp_.toSec() - kRanBackS;
  newest_stamp_ = back ? header.stamp : std::max(newest_stamp_, header.stamp);
  if (!back) return;
  frames_->ran_back_to(header.stamp, header.frame_id);
  ++epoch_;
  health_->time_ran_back();
  NODELET_WARN("time ran back to %.3f: mapping continues from the present pose, odometry restarts",
               header.stamp.toSec());
}

void MapperNodelet::work() {
  while (const auto waiting = queue_->take()) {
    try {
      process(*waiting);
    } catch (const std::exception& error) {
      complain({ErrorCode::kFailed, std::string("a scan could not be used: ") + error.what()});
    }
  }
}

void MapperNodelet::process(const Waiting& waiting) {
  restart_odometry_if_needed(waiting.epoch);
  const double timeout_s = waiting.epoch == epoch_ ? params_.transform_timeout_s : 0.0;
  const auto& stamp = header_of(waiting.scan, waiting.echoes).stamp;
  const Stopwatch watch;
  const auto added = waiting.scan ? add(*waiting.scan, timeout_s)
                                  : add(ros_convert::to_single_echo(*waiting.echoes), timeout_s);
  if (added) {
    work_health_.done(watch.milliseconds(), ros_health::age_ms(stamp));
    last_complaint_ = {};
  } else if (!closing_) {
    complain(added.error());
  }
}

void MapperNodelet::restart_odometry_if_needed(std::uint64_t epoch) {
  const bool other_map = odometry_is_stale_.exchange(false);
  if (!other_map && epoch == worked_epoch_) return;
  worked_epoch_ = epoch;
  chain_->forget();
}

Result<void> MapperNodelet::add(const sensor_msgs::LaserScan& message, double timeout_s) {
  const auto& stamp = message.header.stamp;
  if (stamp.isZero() || message.header.frame_id.empty())
    return fail(ErrorCode::kInvalidArgument,
                "the scan has no stamp or no frame_id: its driver must set both");
  const auto base_T_scanner = frames_->base_T(message.header.frame_id, stamp, timeout_s);
  if (!base_T_scanner) return tl::unexpected(base_T_scanner.error());
  auto scan = ros_convert::to_laser_scan(message, *base_T_scanner, params_.max_tilt_rad);
  if (!scan) return tl::unexpected(scan.error());
  const auto odometry = odometry_at(stamp, timeout_s);
  if (!odometry) return tl::unexpected(odometry.error());
  const auto step = chain_->next(stamp.toSec(), *odometry, imu_yaw_at(stamp, timeout_s));
  if (step.jumped) {
    health_->jumped();
    NODELET_WARN("odometry jumped before %.3f: the motion since the previous scan comes from scan matching",
                 stamp.toSec());
  }
  if (*odometry) *scan = people_->without_people(std::move(*scan), **odometry);
  const Stopwatch watch;
  mapping::MapperStatistics statistics;
  auto mode = mapping::MapperMode::kMapping;
  const auto update = mapper_->with([&](mapping::Mapper& mapper) {
    auto result = mapper.add(*scan, step.odom_T_base);
    statistics = mapper.statistics();
    mode = mapper.mode();
    return result;
  });
  if (!update) return tl::unexpected(update.error());
  if (update->carried)
    NODELET_WARN("the robot was carried: the map goes on as a new part until a place is recognized");
  health_->used(*update, statistics, mode, watch.milliseconds());
  publish(*update, stamp, *odometry);
  return {};
}

Result<std::optional<Pose2>> MapperNodelet::odometry_at(const ros::Time& stamp, double timeout_s) {
  using Source = ros_params::OdometrySource;
  if (params_.odometry == Source::kNone) return std::optional<Pose2>();
  const auto pose = frames_->odom_T_base(stamp, timeout_s);
  if (pose) {
    health_->odometry("");
    had_odometry_ = true;
    odometry_is_missed_ = false;
    return std::optional<Pose2>(*pose);
  }
  if (params_.odometry == Source::kTf) return tl::unexpected(pose.error());
  if (!std::exchange(odometry_is_missed_, true))
    NODELET_WARN("no odometry, scan matching alone: %s", pose.error().message.c_str());
  health_->odometry(pose.error().message);
  return std::optional<Pose2>();
}

std::optional<double> MapperNodelet::imu_yaw_at(const ros::Time& stamp, double timeout_s) {
  if (!params_.use_imu) return std::nullopt;
  std::string problem;
  if (const auto frame = imu_.unknown_frame(); !frame.empty()) {
    if (const auto mount = frames_->base_T(frame, stamp, 0.0))
      imu_.set_mount(frame, *mount);
    else
      problem = "the IMU is assumed to be level: " + mount.error().message;
  }
  const auto yaw = imu_.at(stamp.toSec(), timeout_s);
  if (!yaw)
    problem = "no IMU reading at the scan's stamp on " + getNodeHandle().resolveName(kImuTopic) +
              ": rotation comes from odometry";
  health_->imu_missing(problem);
  return yaw;
}

void MapperNodelet::publish(const mapping::MapperUpdate& update, const ros::Time& stamp,
                            const std::optional<Pose2>& odometry) {
  if (odometry)
    frame_publisher_->set(params_.odom_frame, compose(update.pose, inverse(*odometry)));
  else if (!had_odometry_)
    frame_publisher_->set(params_.base_frame, update.pose);
  poses_->publish(update, stamp, *mapper_);
  maps_->changed(stamp);
}

void MapperNodelet::complain(const Error& error) {
  if (error.code == ErrorCode::kNotFound)
    health_->without_transform();
  else
    health_->refused();
  (void)work_health_.failed(error.message);
  const auto now = ros::WallTime::now();
  if ((now - last_complaint_).toSec() < kComplaintPeriodS) return;
  last_complaint_ = now;
  NODELET_ERROR("%s", error.message.c_str());
}

void MapperNodelet::set_paused(bool paused) {
  if (!paused) mapper_->with([](mapping::Mapper& mapper) { mapper.expect_elsewhere(); });
  paused_ = paused;
  health_->paused(paused);
}

void MapperNodelet::on_other_map() {
  odometry_is_stale_ = true;
  frame_publisher_->clear();
  maps_->restart();
  health_->restarted();
  if (mapper_->with([](const mapping::Mapper& mapper) { return mapper.statistics().scans; }) > 0)
    maps_->changed(ros::Time::now());
}

void MapperNodelet::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  status.summary(diagnostic_msgs::DiagnosticStatus::OK, paused_ ? "paused" : "running");
  scan_health_.report(status, getNodeHandle().resolveName(kScanTopic), params_.timeout_s);
  work_health_.report(status);
  status.add("waiting", queue_->waiting());
  health_->report(status);
  report_map(status);
  if (params_.use_imu) status.add("imu received", imu_.received());
  status.add("returns of people left out", people_->left_out());
}

void MapperNodelet::report_map(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  const auto map = maps_->statistics();
  status.add("maps published", map.maps);
  status.addf("map size [cells]", "%zu x %zu", map.width, map.height);
  status.addf("map held the mapper [ms]", "%.2f", map.held_ms);
  status.addf("map held the mapper at most [ms]", "%.2f", map.longest_held_ms);
  status.addf("map built and sent [ms]", "%.2f", map.build_ms);
}

}  // namespace extperfc::ros_mapping

PLUGINLIB_EXPORT_CLASS(extperfc::ros_mapping::MapperNodelet, nodelet::Nodelet)
