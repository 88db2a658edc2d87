#include "ros/scan/sweep_poses.hpp"

#include <tf2_eigen/tf2_eigen.h>

#include "extperfc/scan/level.hpp"

namespace extperfc::ros_scan {

using ros_params::LevelFrom;

struct SweepPoses::Wait {
  ros::WallTime deadline;
  const std::atomic<bool>& closing;
  bool for_strangers{false};  ///< for frames that tf has never heard of, too

  [[nodiscard]] bool goes_on() const { return !closing && ros::WallTime::now() < deadline; }
};

/// Where the target frame is at the cloud's stamp.
struct SweepPoses::Ground {
  Pose world_T_target{
      Pose::Identity()};  ///< with the vertical of tf or the IMU; identity where neither knows
  Pose world_T_levelled{Pose::Identity()};  ///< upright, where the vertical is known and wanted
  bool has_fixed{false};                    ///< tf knows the fixed frame
  bool has_imu{false};                      ///< the vertical is the IMU's
};

namespace {

constexpr int kTrackPoses = 5;  // of a revolution: every 25 ms at 10 Hz

/// No value for times before 0, which ros::Time cannot hold.
Result<ros::Time> moment(const ros::Time& stamp, double since_s) {
  const double at_s = stamp.toSec() + since_s;
  if (at_s > 0) return stamp + ros::Duration(since_s);
  return fail(ErrorCode::kInvalidArgument, "the sweep began before time 0");
}

}  // namespace

SweepPoses::SweepPoses(const ros_params::CloudToScanNodeletParams& params)
    : target_frame_(params.target_frame),
      fixed_frame_(params.fixed_frame),
      deskew_(params.deskew),
      level_(params.level),
      tolerance_s_(params.transform_tolerance) {
  const bool needs_tf = !target_frame_.empty() || !fixed_frame_.empty() || !params.self_volumes.empty() ||
                        level_ == LevelFrom::kImu;
  if (!needs_tf) return;
  buffer_ = std::make_unique<tf2_ros::Buffer>();
  listener_ = std::make_unique<tf2_ros::TransformListener>(*buffer_);
}

const std::string& SweepPoses::target_of(const std_msgs::Header& header) const {
  return target_frame_.empty() ? header.frame_id : target_frame_;
}

/// Polls in wall time: tf2's own wait would not end while simulated time stands still.
Result<Pose> SweepPoses::lookup(const std::string& target, const std::string& source, const ros::Time& time,
                                const Wait& wait) const {
  if (target == source) return Pose::Identity();
  while (!buffer_->canTransform(target, source, time) && wait.goes_on() &&
         (wait.for_strangers || buffer_->canTransform(target, source, ros::Time(0))))
    ros::WallDuration(0.002).sleep();
  try {
    return tf2::transformToEigen(buffer_->lookupTransform(target, source, time));
  } catch (const tf2::TransformException&) {
    return fail(ErrorCode::kNotFound,
                "no transform from " + source + " to " + target + " at the cloud's stamp; is tf published?");
  }
}

Result<SweepGeometry> SweepPoses::find(const std_msgs::Header& header, const Result<scan::TimeSpan>& span,
                                       scan::SelfFilter& robot, const std::atomic<bool>& closing) {
  Wait wait{ros::WallTime::now() + ros::WallDuration(tolerance_s_), closing, true};
  const auto target_T_cloud = lookup(target_of(header), header.frame_id, header.stamp, wait);
  if (!target_T_cloud) return tl::unexpected(target_T_cloud.error());
  wait.for_strangers = false;
  SweepGeometry sweep;
  const Ground ground = stand(header, wait, sweep);
  const Pose levelled_T_target = ground.world_T_levelled.inverse() * ground.world_T_target;
  sweep.track = {{0, levelled_T_target * *target_T_cloud}};
  if (deskew_ && !fixed_frame_.empty() && sweep.not_deskewed.empty()) {
    auto track = span ? follow(header, *span, ground, wait) : tl::unexpected(span.error());
    if (track)
      sweep.track = std::move(*track);
    else
      sweep.not_deskewed = track.error().message;
  }
  sweep.rotation_rad = Eigen::AngleAxisd(sweep.track.front().target_T_sensor.linear().transpose() *
                                         sweep.track.back().target_T_sensor.linear())
                           .angle();
  transform_robot(header, wait, robot, sweep);
  return sweep;
}

SweepPoses::Ground SweepPoses::stand(const std_msgs::Header& header, const Wait& wait,
                                     SweepGeometry& sweep) const {
  Ground ground;
  if (!fixed_frame_.empty()) {
    const auto fixed_T_target = lookup(fixed_frame_, target_of(header), header.stamp, wait);
    ground.has_fixed = fixed_T_target.has_value();
    if (fixed_T_target)
      ground.world_T_target = *fixed_T_target;
    else if (deskew_)
      sweep.not_deskewed = fixed_T_target.error().message;
    if (!fixed_T_target && level_ == LevelFrom::kTf) sweep.not_levelled = fixed_T_target.error().message;
  }
  if (level_ == LevelFrom::kImu) {
    const auto world_R_target = vertical(target_of(header), header.stamp, wait);
    ground.has_imu = world_R_target.has_value();
    if (world_R_target)
      ground.world_T_target = scan::with_tilt(ground.world_T_target, *world_R_target);
    else
      sweep.not_levelled = world_R_target.error().message;
  }
  const bool level = ground.has_imu || (level_ == LevelFrom::kTf && ground.has_fixed);
  ground.world_T_levelled = level ? scan::upright(ground.world_T_target) : ground.world_T_target;
  if (level) sweep.tilt_rad = scan::tilt_angle_rad(ground.world_T_target.linear());
  return ground;
}

Result<scan::SensorTrack> SweepPoses::follow(const std_msgs::Header& header, const scan::TimeSpan& span,
                                             const Ground& ground, const Wait& wait) const {
  scan::SensorTrack track;
  const Pose levelled_T_world = ground.world_T_levelled.inverse();
  for (int i = 0; i < kTrackPoses; ++i) {
    const double since_s = span.first_s + (span.last_s - span.first_s) * i / (kTrackPoses - 1);
    const auto time = moment(header.stamp, since_s);
    if (!time) return tl::unexpected(time.error());
    auto world_T_target = lookup(fixed_frame_, target_of(header), *time, wait);
    if (!world_T_target) return tl::unexpected(world_T_target.error());
    const auto target_T_cloud = lookup(target_of(header), header.frame_id, *time, wait);
    if (!target_T_cloud) return tl::unexpected(target_T_cloud.error());
    if (ground.has_imu) {
      const auto tilt = vertical(target_of(header), *time, wait);
      world_T_target =
          scan::with_tilt(*world_T_target, tilt ? *tilt : Eigen::Matrix3d(ground.world_T_target.linear()));
    }
    track.push_back({since_s, levelled_T_world * *world_T_target * *target_T_cloud});
  }
  return track;
}

Result<Eigen::Matrix3d> SweepPoses::vertical(const std::string& target, const ros::Time& time,
                                             const Wait& wait) const {
  const auto world_R_imu = imu_.at(time);
  if (!world_R_imu) return tl::unexpected(world_R_imu.error());
  const auto imu_T_target = lookup(imu_.frame(), target, time, wait);
  if (!imu_T_target) return tl::unexpected(imu_T_target.error());
  return Eigen::Matrix3d(world_R_imu->toRotationMatrix() * imu_T_target->linear());
}

void SweepPoses::transform_robot(const std_msgs::Header& header, const Wait& wait, scan::SelfFilter& robot,
                                 SweepGeometry& sweep) const {
  std::vector<std::optional<Pose>> poses;
  for (const auto& frame : robot.frames()) {
    const auto pose = lookup(header.frame_id, frame, header.stamp, wait);
    poses.push_back(pose ? std::optional(*pose) : std::nullopt);
    if (!pose) sweep.unseen.push_back(frame);
  }
  robot.place(poses);
}

}  // namespace extperfc::ros_scan
