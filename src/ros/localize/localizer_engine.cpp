#include "ros/localize/localizer_engine.hpp"

#include <cmath>
#include <utility>

#include <ros/console.h>
#include <tf2_eigen/tf2_eigen.h>

#include "ros/convert/laser_scan.hpp"
#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_localize {

namespace {

// Farther motion between two scans means that odometry restarted.
constexpr double kJumpM = 1.0;
constexpr double kJumpSpeedMS = 5.0;
// Uncertainty added when the pose is carried over a gap in time or odometry: 0.1 m, 0.1 rad.
constexpr double kGapVariance = 0.01;

double seconds_between(const ros::Time& from, const ros::Time& to) {
  return to.toSec() - from.toSec();
}

}  // namespace

LocalizerEngine::LocalizerEngine(const ros_params::LocalizerNodeParams& params, tf2_ros::Buffer& tf)
    : params_(params), tf_(tf) {
  GivenPose start;
  start.pose = params.initial_pose;
  start.covariance = params.initial_variance.asDiagonal();
  placement_ = start;
}

const std::vector<localize::Particle>& LocalizerEngine::particles() const {
  static const std::vector<localize::Particle> none;
  return localizer_ ? localizer_->particles() : none;
}

Result<std::optional<Located>> LocalizerEngine::process(const Work& work) {
  if (work.time_ran_back) {
    tf_.clear();
    time_ran_back_ = true;
    last_update_.reset();
  }
  if (work.placement) placement_ = work.placement;
  force_ = force_ || work.force;
  if (work.map)
    if (auto taken = take_map(work.map); !taken) return tl::unexpected(taken.error());
  if (!work.scan || !localizer_) return std::nullopt;
  auto located = locate(*work.scan);
  if (!located) return tl::unexpected(located.error());
  return *located;
}

Result<void> LocalizerEngine::take_map(const MapPtr& map) {
  force_ = true;
  if (localizer_) return localizer_->set_map(map);
  auto made = localize::Localizer::make(params_.filter, map);
  if (!made) return tl::unexpected(made.error());
  localizer_.emplace(std::move(*made));
  return {};
}

Result<Located> LocalizerEngine::locate(const sensor_msgs::LaserScan& message) {
  const auto& stamp = message.header.stamp;
  if (stamp.isZero())
    return fail(ErrorCode::kInvalidArgument,
                "the scan has no stamp (zero): its transforms cannot be looked up");
  const auto odom_T_base = odometry_at(stamp);
  if (!odom_T_base) return tl::unexpected(odom_T_base.error());
  const auto base_T_scanner = transform_at(params_.base_frame, message.header.frame_id, stamp);
  if (!base_T_scanner) return tl::unexpected(base_T_scanner.error());
  const auto scan = ros_convert::to_laser_scan(message, *base_T_scanner);
  if (!scan) return tl::unexpected(scan.error());

  const Odometry now{stamp, *odom_T_base};
  if (auto placed = place(now); !placed) return tl::unexpected(placed.error());
  const auto estimate = localizer_->update(*scan, *odom_T_base, update_is_due(stamp));
  if (!estimate) return tl::unexpected(estimate.error());
  last_ = now;
  if (*estimate) {
    force_ = false;
    last_update_ = stamp;
    map_T_odom_ = compose((*estimate)->pose, inverse(*odom_T_base));
  }
  return Located{stamp, map_T_odom_, compose(map_T_odom_, *odom_T_base), estimate->has_value(),
                 localizer_->estimate()};
}

bool LocalizerEngine::update_is_due(const ros::Time& stamp) const {
  if (force_ || !last_update_) return true;
  return params_.idle_update_period_s > 0 &&
         seconds_between(*last_update_, stamp) >= params_.idle_update_period_s;
}

Result<void> LocalizerEngine::place(const Odometry& now) {
  const bool gap = last_ && (time_ran_back_ || jumped(now));
  const auto placement = std::exchange(placement_, std::nullopt);
  if (!placement && !gap) return {};
  force_ = true;
  if (!placement) {
    auto kept = keep_pose(now);
    time_ran_back_ = false;
    return kept;
  }
  time_ran_back_ = false;
  if (const auto* given = std::get_if<GivenPose>(&*placement)) return place(*given, now);
  localizer_->initialize_globally();
  return {};
}

/// Carries the given pose on by odometry since its stamp: rviz stamps it when the arrow is drawn.
Result<void> LocalizerEngine::place(const GivenPose& given, const Odometry& now) {
  Pose2 pose = given.pose;
  if (!given.stamp.isZero() && tf_.canTransform(params_.odom_frame, params_.base_frame, given.stamp))
    if (const auto then = odometry_at(given.stamp)) pose = compose(pose, between(*then, now.odom_T_base));
  return localizer_->set_pose(pose, given.covariance);
}

/// Time ran back: a recording starts again in the same odometry frame, so map -> odom still holds. Otherwise
/// odometry restarted and the robot stands where it stood.
Result<void> LocalizerEngine::keep_pose(const Odometry& now) {
  const auto pose = compose(map_T_odom_, time_ran_back_ ? now.odom_T_base : last_->odom_T_base);
  ROS_WARN(time_ran_back_ ? "time ran back: keeping the transform from map to odometry"
                          : "odometry jumped: assuming that it restarted, keeping the pose");
  return localizer_->set_pose(pose,
                              localizer_->estimate().covariance + kGapVariance * Eigen::Matrix3d::Identity());
}

bool LocalizerEngine::jumped(const Odometry& now) const {
  const auto step = between(last_->odom_T_base, now.odom_T_base);
  return std::hypot(step.x, step.y) >
         kJumpM + kJumpSpeedMS * std::abs(seconds_between(last_->stamp, now.stamp));
}

Result<Pose2> LocalizerEngine::odometry_at(const ros::Time& stamp) {
  const auto odom_T_base = transform_at(params_.odom_frame, params_.base_frame, stamp);
  if (!odom_T_base) return tl::unexpected(odom_T_base.error());
  return to_pose2(*odom_T_base);
}

/// Polls in wall time: tf2's own wait would not end while simulated time stands still.
Result<Pose> LocalizerEngine::transform_at(const std::string& target, const std::string& source,
                                           const ros::Time& stamp) {
  if (target == source) return Pose::Identity();
  const auto deadline = ros::WallTime::now() + ros::WallDuration(params_.tf_timeout_s);
  while (!tf_.canTransform(target, source, stamp) && !stopped_ && ros::WallTime::now() < deadline)
    ros::WallDuration(0.002).sleep();
  try {
    const Pose found = tf2::transformToEigen(tf_.lookupTransform(target, source, stamp));
    if (found.matrix().allFinite()) return found;
  } catch (const tf2::TransformException&) {
    return fail(ErrorCode::kNotFound,
                "no transform from " + source + " to " + target +
                    " at the scan's stamp; check that tf is published and that the frame names are right");
  }
  return fail(ErrorCode::kCorrupt, "the transform from " + source + " to " + target + " is not finite");
}

}  // namespace extperfc::ros_localize
