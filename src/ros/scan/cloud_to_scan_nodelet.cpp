#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include <diagnostic_updater/diagnostic_updater.h>
#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include "extperfc/base/latest_slot.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/scan/cloud_to_scan.hpp"

#include "ros/convert/scan.hpp"
#include "ros/health/stream_health.hpp"
#include "ros/params/cloud_to_scan_params.hpp"

namespace extperfc {

/// Flattens a lidar's point cloud to a planar scan: floor removed, the nearest return per direction.
///
/// Subscribes (only while somebody listens to the scan):
///   velodyne_points   sensor_msgs/PointCloud2 with x, y, z; intensity and ring where they are there; any
///                     number type, byte order and padding, organised or not
/// Publishes:
///   scan              sensor_msgs/LaserScan, stamp of the cloud, frame target_frame
///   diagnostics       diagnostic_msgs/DiagnosticArray
/// Parameters (private; unknown keys are refused; names as in pointcloud_to_laserscan):
///   target_frame           frame of the scan, of heights and of ranges          "": the cloud's
///   transform_tolerance    wait for the transform at the cloud's stamp [s]      0.1, [0, 5]
///   min_height, max_height points outside do not count [m]                      0.1, 1.5
///   angle_min, angle_max   first and last ray [rad]                             -pi, pi; [-2 pi, 2 pi]
///   angle_increment        from ray to ray [rad]                                0.5 degrees, [0.0001, 1]
///   scan_time              from scan to scan [s]                                0.1, [0, 60]
///   range_min, range_max   points outside do not count [m]                      0.6, 30; >= 0
///   use_inf, inf_epsilon   a ray that meets nothing: infinity, or range_max + inf_epsilon [m]   true, 1
///   intensity              none | nearest | maximum of the points of a ray      nearest
///   rings                  lasers that count: "7", "4-11", "1,3,8-15"           "": all
///   ground_method          none | height (level floor) | plane (RANSAC)         height
///   ground_z_m             where the floor is in the target frame [m]           0, [-10, 10]
///   ground_clearance_m     lower points above the floor belong to it [m]        0.05, [0, 1]
///   ground_band_m, ground_max_slope_rad, ground_inlier_m, ground_max_iterations, ground_min_points,
///   ground_seed            of the plane, see extperfc/scan/ground.hpp           0.3, 0.1, 0.03, 100, 100, 1
///   timeout_s              silence after which diagnostics warn [s]             5, [0.1, 3600]
/// Frames: needs cloud frame -> target_frame at the cloud's stamp when target_frame is set.
/// Diagnostics: rates, latency, how clouds arrive, what became of the points; WARN while no ground plane is
///   found; ERROR while clouds cannot be used (fields, layout, transforms).
/// Threads: the callback only stores; one worker waits for transforms and computes. The newest cloud replaces
/// a waiting one.
class CloudToScanNodelet : public nodelet::Nodelet {
 public:
  ~CloudToScanNodelet() override {
    diagnostics_timer_.stop();
    {
      const std::lock_guard lock(subscription_mutex_);
      closing_ = true;  // a listener that comes or goes now must not subscribe again
    }
    subscriber_.shutdown();
    clouds_.close();
    if (worker_.joinable()) worker_.join();
  }

 private:
  using CloudEvent = ros::MessageEvent<const sensor_msgs::PointCloud2>;
  static constexpr const char* kCloudTopic = "velodyne_points";

  void onInit() override;
  void advertise();
  void update_subscription();
  void on_cloud(const CloudEvent& event);
  void process(const sensor_msgs::PointCloud2& cloud);
  Result<sensor_msgs::LaserScanPtr> flatten(const sensor_msgs::PointCloud2& message);
  Result<Pose> transform_at(const std_msgs::Header& header);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros_params::CloudToScanNodeletParams params_;
  std::optional<scan::CloudToScan> converter_;  ///< of the worker
  scan::PlanarScan scan_;                       ///< of the worker
  std::unique_ptr<tf2_ros::Buffer> tf_buffer_;
  std::unique_ptr<tf2_ros::TransformListener> tf_listener_;
  std::unique_ptr<diagnostic_updater::Updater> updater_;
  ros::WallTimer diagnostics_timer_;
  health::InputHealth cloud_health_{"cloud"};
  health::WorkHealth work_health_;

  std::mutex subscription_mutex_;
  std::atomic<bool> closing_{false};
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;

  std::mutex statistics_mutex_;
  scan::ScanStatistics statistics_;  ///< of the latest cloud

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
  if (!params_.target_frame.empty()) {
    tf_buffer_ = std::make_unique<tf2_ros::Buffer>();
    tf_listener_ = std::make_unique<tf2_ros::TransformListener>(*tf_buffer_);
  }
  updater_ =
      std::make_unique<diagnostic_updater::Updater>(getNodeHandle(), getPrivateNodeHandle(), getName());
  updater_->setHardwareID("none");
  updater_->add("cloud_to_scan", this, &CloudToScanNodelet::report);
  diagnostics_timer_ =
      getNodeHandle().createWallTimer(ros::WallDuration(0.2), [this](const auto&) { updater_->update(); });
  worker_ = std::thread([this] {
    while (const auto cloud = clouds_.take()) process(**cloud);
  });
  advertise();
}

void CloudToScanNodelet::advertise() {
  const std::lock_guard lock(subscription_mutex_);  // the callbacks must not run before the publisher exists
  const auto changed = [this](const ros::SingleSubscriberPublisher&) { update_subscription(); };
  publisher_ = getNodeHandle().advertise<sensor_msgs::LaserScan>("scan", 5, changed, changed);
}

void CloudToScanNodelet::update_subscription() {
  const std::lock_guard lock(subscription_mutex_);
  if (closing_) return;
  const bool wanted = publisher_.getNumSubscribers() > 0;
  cloud_health_.listening(wanted);
  if (!wanted)
    subscriber_.shutdown();
  else if (!subscriber_)
    subscriber_ = getNodeHandle().subscribe(kCloudTopic, 2, &CloudToScanNodelet::on_cloud, this);
}

void CloudToScanNodelet::on_cloud(const CloudEvent& event) {
  const auto& message = event.getConstMessage();
  cloud_health_.received(message->header.stamp, message->data.data(), health::came_by_pointer(event));
  clouds_.put(message);
}

void CloudToScanNodelet::process(const sensor_msgs::PointCloud2& cloud) {
  auto message = flatten(cloud);
  if (!message) {
    if (work_health_.failed(message.error().message)) NODELET_ERROR("%s", message.error().message.c_str());
    return;
  }
  publisher_.publish(*message);
}

Result<sensor_msgs::LaserScanPtr> CloudToScanNodelet::flatten(const sensor_msgs::PointCloud2& message) {
  const auto cloud = convert::to_cloud_view(message);
  if (!cloud) return tl::unexpected(cloud.error());
  const auto target_T_cloud = transform_at(message.header);
  if (!target_T_cloud) return tl::unexpected(target_T_cloud.error());
  const Stopwatch watch;
  const auto statistics = converter_->convert(*cloud, *target_T_cloud, scan_);
  if (!statistics) return tl::unexpected(statistics.error());
  {
    const std::lock_guard lock(statistics_mutex_);
    statistics_ = *statistics;
  }
  auto header = message.header;
  if (!params_.target_frame.empty()) header.frame_id = params_.target_frame;
  const convert::ScanFacts facts{params_.scan_time, params_.scan.range_min, params_.scan.range_max};
  auto scan = boost::make_shared<sensor_msgs::LaserScan>(convert::to_message(scan_, facts, header));
  work_health_.done(watch.milliseconds(), health::age_ms(header.stamp));
  return scan;
}

/// Polls in wall time: tf2's own wait would not end while simulated time stands still.
Result<Pose> CloudToScanNodelet::transform_at(const std_msgs::Header& header) {
  if (params_.target_frame.empty() || params_.target_frame == header.frame_id) return Pose::Identity();
  const auto deadline = ros::WallTime::now() + ros::WallDuration(params_.transform_tolerance);
  while (!tf_buffer_->canTransform(params_.target_frame, header.frame_id, header.stamp) && !closing_ &&
         ros::WallTime::now() < deadline)
    ros::WallDuration(0.002).sleep();
  try {
    return tf2::transformToEigen(
        tf_buffer_->lookupTransform(params_.target_frame, header.frame_id, header.stamp));
  } catch (const tf2::TransformException&) {
    return fail(ErrorCode::kNotFound, "no transform from " + header.frame_id + " to " + params_.target_frame +
                                          " at the cloud's stamp; is tf published?");
  }
}

void CloudToScanNodelet::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  status.summary(diagnostic_msgs::DiagnosticStatus::OK, "running");
  status.add("dropped", clouds_.dropped());
  cloud_health_.report(status, getNodeHandle().resolveName(kCloudTopic), params_.timeout_s);
  work_health_.report(status);
  const std::lock_guard lock(statistics_mutex_);
  status.add("ground method", scan::to_string(params_.scan.ground.method));
  status.addf("ground slope [rad]", "%.4f", statistics_.ground.slope_rad());
  status.add("points", statistics_.points);
  status.add("points on the ground", statistics_.on_ground);
  status.add("points used", statistics_.used);
  status.add("intensities", statistics_.intensity_missing ? "wanted, but the cloud has none"
                                                          : scan::to_string(params_.scan.intensity));
  if (!statistics_.ground_found)
    status.mergeSummaryf(
        diagnostic_msgs::DiagnosticStatus::WARN,
        "no ground plane found within %.2f m of z = %.2f m: the floor is taken for level; is "
        "target_frame on the floor?",
        params_.scan.ground.band_m, params_.scan.ground.z_m);
}

}  // namespace extperfc

PLUGINLIB_EXPORT_CLASS(extperfc::CloudToScanNodelet, nodelet::Nodelet)
