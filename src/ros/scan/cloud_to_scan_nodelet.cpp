#include <atomic>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>

#include "extperfc/base/latest_slot.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/scan/cloud_to_scan.hpp"

#include "ros/convert/scan.hpp"
#include "ros/health/reporter.hpp"
#include "ros/health/stream_health.hpp"
#include "ros/params/cloud_to_scan_params.hpp"
#include "ros/scan/sweep_poses.hpp"

namespace extperfc::ros_scan {

/// Converts a lidar's point cloud to planar scans: compensates the robot's motion and tilt, and removes the
/// floor and the robot itself. Both scans have the cloud's stamp and the frame target_frame. NaN is an
/// unknown ray (no return, or hidden by the robot), infinity a ray that a beam passed through, up to
/// range_max and beyond.
///
/// Subscribes (only while one of the scans has subscribers):
///   velodyne_points  sensor_msgs/PointCloud2 with x, y, z; intensity, ring and time, t or timestamp are used
///                    if present; any number type, byte order and padding, organised or not
///   imu/data         sensor_msgs/Imu with an orientation; with level: imu only
///   /tf, /tf_static  tf2_msgs/TFMessage
/// Publishes:
///   scan          sensor_msgs/LaserScan for maps: per ray the nearest surface that two rings agree on
///   scan_nearest  sensor_msgs/LaserScan for cost maps: per ray the nearest point
///   diagnostics   diagnostic_msgs/DiagnosticArray
/// Parameters: config/cloud_to_scan.yaml; names as in pointcloud_to_laserscan.
/// Frames: needs cloud frame -> target_frame at the cloud's stamp when target_frame is set. Uses target_frame
///   -> fixed_frame over the sweep, the IMU's frame and the frames of self_volumes; without them the scan is
///   published all the same, and diagnostics warn.
/// Diagnostics: rates, latency, how clouds arrive, numbers of used and ignored points and rays; WARN while
///   clouds are not deskewed or not levelled although they should be, a frame of the robot is missing, or no
///   ground plane is found; ERROR while clouds cannot be used (fields, layout, transforms).
/// Threads: the callbacks only store; one worker waits for transforms and computes. The newest cloud replaces
///   a waiting one.
class CloudToScanNodelet : public nodelet::Nodelet {
 public:
  ~CloudToScanNodelet() override {
    reporter_.reset();
    {
      const std::lock_guard lock(subscription_mutex_);
      closing_ = true;  // a subscriber that connects or disconnects now must not subscribe again
    }
    subscriber_.shutdown();
    imu_subscriber_.shutdown();
    clouds_.close();
    if (worker_.joinable()) worker_.join();
  }

 private:
  using CloudEvent = ros::MessageEvent<const sensor_msgs::PointCloud2>;
  static constexpr const char* kCloudTopic = "velodyne_points";
  static constexpr const char* kImuTopic = "imu/data";

  void onInit() override;
  void advertise();
  void update_subscription();
  void on_cloud(const CloudEvent& event);
  void process(const sensor_msgs::PointCloud2& cloud);
  Result<void> flatten(const sensor_msgs::PointCloud2& message);
  void publish(const std_msgs::Header& header);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);
  void report_sweep(diagnostic_updater::DiagnosticStatusWrapper& status) const;
  void report_points(diagnostic_updater::DiagnosticStatusWrapper& status) const;

  ros_params::CloudToScanNodeletParams params_;
  std::optional<scan::CloudToScan> converter_;  ///< of the worker, as are these
  scan::SelfFilter robot_;
  scan::PlanarScans scans_;
  std::optional<SweepPoses> poses_;
  std::optional<ros_health::Reporter> reporter_;
  ros_health::InputHealth cloud_health_{"cloud"};
  ros_health::WorkHealth work_health_;

  std::mutex subscription_mutex_;
  std::atomic<bool> closing_{false};
  ros::Publisher supported_, nearest_;
  ros::Subscriber subscriber_, imu_subscriber_;

  mutable std::mutex statistics_mutex_;
  scan::ScanStatistics statistics_;  ///< of the latest cloud
  SweepGeometry sweep_;              ///< of the latest cloud

  LatestSlot<sensor_msgs::PointCloud2ConstPtr> clouds_;
  std::thread worker_;
};

void CloudToScanNodelet::onInit() {
  auto params = ros_params::load_cloud_to_scan_params(getPrivateNodeHandle());
  if (!params) {
    NODELET_FATAL("%s", params.error().message.c_str());
    throw std::runtime_error(params.error().message);
  }
  params_ = *params;
  converter_ = scan::CloudToScan::make(params_.scan).value();  // the parameters are checked
  robot_ = scan::SelfFilter::make(params_.self_volumes, params_.self_padding).value();
  poses_.emplace(params_);
  reporter_.emplace(getNodeHandle(), getPrivateNodeHandle(), getName());
  reporter_->add("cloud_to_scan", [this](auto& status) { report(status); });
  reporter_->start();
  worker_ = std::thread([this] {
    while (const auto cloud = clouds_.take()) process(**cloud);
  });
  advertise();
}

void CloudToScanNodelet::advertise() {
  const std::lock_guard lock(subscription_mutex_);  // the callbacks must not run before the publisher exists
  const auto changed = [this](const ros::SingleSubscriberPublisher&) { update_subscription(); };
  supported_ = getNodeHandle().advertise<sensor_msgs::LaserScan>("scan", 5, changed, changed);
  nearest_ = getNodeHandle().advertise<sensor_msgs::LaserScan>("scan_nearest", 5, changed, changed);
}

void CloudToScanNodelet::update_subscription() {
  const std::lock_guard lock(subscription_mutex_);
  if (closing_) return;
  const bool wanted = supported_.getNumSubscribers() > 0 || nearest_.getNumSubscribers() > 0;
  cloud_health_.listening(wanted);
  if (!wanted) {
    subscriber_.shutdown();
    imu_subscriber_.shutdown();
    return;
  }
  if (!imu_subscriber_ && params_.level == ros_params::LevelFrom::kImu)
    imu_subscriber_ = getNodeHandle().subscribe<sensor_msgs::Imu>(
        kImuTopic, 100, [this](const sensor_msgs::Imu::ConstPtr& message) { poses_->imu().add(*message); });
  if (!subscriber_)
    subscriber_ = getNodeHandle().subscribe(kCloudTopic, 2, &CloudToScanNodelet::on_cloud, this);
}

void CloudToScanNodelet::on_cloud(const CloudEvent& event) {
  const auto& message = event.getConstMessage();
  cloud_health_.received(message->header.stamp, message->data.data(), ros_health::came_by_pointer(event));
  clouds_.put(message);
}

void CloudToScanNodelet::process(const sensor_msgs::PointCloud2& cloud) {
  const auto done = flatten(cloud);
  if (done) return publish(cloud.header);
  if (work_health_.failed(done.error().message)) NODELET_ERROR("%s", done.error().message.c_str());
}

Result<void> CloudToScanNodelet::flatten(const sensor_msgs::PointCloud2& message) {
  const auto cloud = ros_convert::to_cloud_view(message);
  if (!cloud) return tl::unexpected(cloud.error());
  if (auto valid = scan::validate(*cloud); !valid) return valid;
  const auto span = scan::time_span(*cloud, params_.scan.azimuth_times, params_.scan.scan_time);
  auto sweep = poses_->find(message.header, span, robot_, closing_);
  if (!sweep) return tl::unexpected(sweep.error());
  const Stopwatch watch;
  const auto statistics = converter_->convert(*cloud, sweep->track, robot_, scans_);
  if (!statistics) return tl::unexpected(statistics.error());
  work_health_.done(watch.milliseconds(), ros_health::age_ms(message.header.stamp));
  if (sweep->track.size() > 1 && !statistics->deskewed && statistics->points > 0)
    sweep->not_deskewed = "the cloud's points are not in the order of their firing";
  const std::lock_guard lock(statistics_mutex_);
  statistics_ = *statistics;
  sweep_ = std::move(*sweep);
  return {};
}

void CloudToScanNodelet::publish(const std_msgs::Header& cloud) {
  auto header = cloud;
  if (!params_.target_frame.empty()) header.frame_id = params_.target_frame;
  const ros_convert::ScanFacts facts{params_.scan.scan_time, params_.scan.range_min, params_.scan.range_max};
  if (supported_.getNumSubscribers() > 0)
    supported_.publish(
        boost::make_shared<sensor_msgs::LaserScan>(ros_convert::to_message(scans_.supported, facts, header)));
  if (nearest_.getNumSubscribers() > 0)
    nearest_.publish(
        boost::make_shared<sensor_msgs::LaserScan>(ros_convert::to_message(scans_.nearest, facts, header)));
}

void CloudToScanNodelet::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  status.summary(diagnostic_msgs::DiagnosticStatus::OK, "running");
  status.add("dropped", clouds_.dropped());
  cloud_health_.report(status, getNodeHandle().resolveName(kCloudTopic), params_.timeout_s);
  work_health_.report(status);
  const std::lock_guard lock(statistics_mutex_);
  report_sweep(status);
  report_points(status);
}

void CloudToScanNodelet::report_sweep(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  using diagnostic_msgs::DiagnosticStatus;
  const bool deskewed = sweep_.track.size() > 1 && sweep_.not_deskewed.empty();
  status.add("deskewed", deskewed);
  status.addf("rotation during the sweep [rad]", "%.4f", sweep_.rotation_rad);
  status.add("level", to_string(params_.level));
  status.addf("tilt [rad]", "%.4f", sweep_.tilt_rad);
  std::string unseen;
  for (const auto& frame : sweep_.unseen) unseen += (unseen.empty() ? "" : ", ") + frame;
  status.add("robot frames without a transform", unseen.empty() ? "none" : unseen);
  if (!sweep_.not_deskewed.empty())
    status.mergeSummary(DiagnosticStatus::WARN, "clouds are not deskewed: " + sweep_.not_deskewed);
  if (!sweep_.not_levelled.empty())
    status.mergeSummary(DiagnosticStatus::WARN, "clouds are not levelled: " + sweep_.not_levelled);
  if (!unseen.empty())
    status.mergeSummary(DiagnosticStatus::WARN,
                        "the robot itself may be in the scan: no transform of " + unseen);
}

void CloudToScanNodelet::report_points(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  status.add("ground method", scan::to_string(params_.scan.ground.method));
  status.addf("ground slope [rad]", "%.4f", statistics_.ground.slope_rad());
  status.add("points", statistics_.points);
  status.add("points on the ground", statistics_.on_ground);
  status.add("points on the robot", statistics_.on_robot);
  status.add("points used", statistics_.used);
  status.add("rays that met something", statistics_.rays_met);
  status.add("rays that two rings support", statistics_.rays_supported);
  status.add("rays seen to be free", statistics_.rays_free);
  status.add("rays unknown", statistics_.rays_unknown);
  status.add("intensities", statistics_.intensity_missing ? "wanted, but the cloud has none"
                                                          : scan::to_string(params_.scan.intensity));
  if (!statistics_.ground_found)
    status.mergeSummaryf(diagnostic_msgs::DiagnosticStatus::WARN,
                         "no ground plane found within %.2f m of z = %.2f m: assuming a level floor; is "
                         "target_frame on the floor?",
                         params_.scan.ground.band_m, params_.scan.ground.z_m);
}

}  // namespace extperfc::ros_scan

PLUGINLIB_EXPORT_CLASS(extperfc::ros_scan::CloudToScanNodelet, nodelet::Nodelet)
