#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <diagnostic_updater/diagnostic_updater.h>
#include <nodelet/nodelet.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/MultiEchoLaserScan.h>

#include "ros/health/stream_health.hpp"
#include "ros/mapping/frame_publisher.hpp"
#include "ros/mapping/imu_yaw.hpp"
#include "ros/mapping/map_publisher.hpp"
#include "ros/mapping/mapper_services.hpp"
#include "ros/mapping/mapping_health.hpp"
#include "ros/mapping/odometry_chain.hpp"
#include "ros/mapping/people_filter.hpp"
#include "ros/mapping/pose_publisher.hpp"
#include "ros/mapping/robot_frames.hpp"
#include "ros/mapping/scan_queue.hpp"
#include "ros/mapping/shared_mapper.hpp"
#include "ros/params/mapper_params.hpp"

namespace extperfc::ros_mapping {

/// Maps a floor from planar scans and odometry, and publishes the robot's pose in the map (SLAM by a
/// Rao-Blackwellised particle filter). Names as in gmapping's slam_gmapping where the meaning is the same.
///
/// Subscribes:
///   scan             sensor_msgs/LaserScan, or sensor_msgs/MultiEchoLaserScan with multi_echo (its strongest
///                    echoes)
///   imu              sensor_msgs/Imu, with use_imu
///   initialpose      geometry_msgs/PoseWithCovarianceStamped in map_frame: the robot stands about here (within
///                    1.2 m and 0.6 rad), in a session that is resumed or after it was carried
///   people_tracks    extperfc/TrackArray in odom_frame, by the navigator: who walks (score 1) is left
///                    out of the map
///   /tf, /tf_static  tf2_msgs/TFMessage
/// Publishes:
///   map            nav_msgs/OccupancyGrid, latched, when changed, at most every map_update_interval
///   map_metadata   nav_msgs/MapMetaData, latched, with the map
///   pose           geometry_msgs/PoseWithCovarianceStamped of base_frame in map_frame, for every used scan
///   particlecloud  geometry_msgs/PoseArray, after key frames, while it has subscribers
///   trajectory     nav_msgs/Path of at most 10,000 poses, while it has subscribers
///   ~entropy       std_msgs/Float64 of the particles' weights [nat], after key frames
///   /tf            tf2_msgs/TFMessage: map_frame -> odom_frame
///   diagnostics    diagnostic_msgs/DiagnosticArray
/// Services:
///   dynamic_map      nav_msgs/GetMap
///   ~save_map        extperfc/SaveMap: PGM and YAML as map_server has them, and a session to resume from;
///                    with the suffix .gridmap or .gridmap.gz MRPT's grid map alone; searches the whole map
///                    for loops first
///   ~optimize        std_srvs/Trigger: searches the whole map for loops; mapping goes on meanwhile
///   ~load_session    extperfc/LoadSession: resumes a session; a file that cannot be read changes nothing
///   ~set_localization  std_srvs/SetBool: true: the map stays as it is, and scans give the robot's pose in it;
///                    false: mapping goes on from there
///   ~pause, ~resume  std_srvs/Trigger: scans are skipped meanwhile, tf continues; the robot may be carried
///   ~reset           std_srvs/Trigger: a new map
/// Parameters: config/mapper.yaml. Those of GMapping's own matcher are accepted without effect, and a warning
///   names them.
/// Frames: needs base_frame -> the scan's frame, and odom_frame -> base_frame (not with `odometry: none`), at
///   the scan's stamp. Publishes map_frame -> odom_frame periodically from the first used scan on; without any
///   odometry map_frame -> base_frame.
/// Diagnostics: rates, latency, scan counts by status, effective particles and entropy; WARN while paused,
///   without scans, without odometry, after jumps and contradictions of odometry, after time ran back, while
///   scans are dropped; ERROR while scans cannot be used, with the missing transform.
/// Threads: callbacks only store; one worker adds scans; one thread builds and sends maps, one sends tf, one
///   serves services, which hold the worker up only while the mapper itself saves.
class MapperNodelet : public nodelet::Nodelet {
 public:
  ~MapperNodelet() override;

 private:
  static constexpr const char* kScanTopic = "scan";
  static constexpr const char* kImuTopic = "imu";

  /// A scan that waits for the worker; one of both messages.
  struct Waiting {
    sensor_msgs::LaserScanConstPtr scan;
    sensor_msgs::MultiEchoLaserScanConstPtr echoes;
    std::uint64_t epoch{0};  ///< number of backward time jumps before it came
  };

  void onInit() override;
  [[nodiscard]] mapping::Mapper make_mapper() const;
  void make_parts();
  void start_diagnostics();
  void subscribe();
  void on_scan(const ros::MessageEvent<const sensor_msgs::LaserScan>& event);
  void on_echoes(const ros::MessageEvent<const sensor_msgs::MultiEchoLaserScan>& event);
  void accept(Waiting waiting, const std_msgs::Header& header);
  void notice_time(const std_msgs::Header& header);

  // The worker's.
  void work();
  void process(const Waiting& waiting);
  void restart_odometry_if_needed(std::uint64_t epoch);
  Result<void> add(const sensor_msgs::LaserScan& message, double timeout_s);
  Result<std::optional<Pose2>> odometry_at(const ros::Time& stamp, double timeout_s);
  std::optional<double> imu_yaw_at(const ros::Time& stamp, double timeout_s);
  void publish(const mapping::MapperUpdate& update, const ros::Time& stamp,
               const std::optional<Pose2>& odometry);
  void complain(const Error& error);

  void set_paused(bool paused);
  void on_other_map();
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);
  void report_map(diagnostic_updater::DiagnosticStatusWrapper& status) const;

  ros_params::MapperNodeletParams params_;
  std::unique_ptr<SharedMapper> mapper_;
  std::unique_ptr<RobotFrames> frames_;
  std::unique_ptr<PeopleFilter> people_;
  std::unique_ptr<FramePublisher> frame_publisher_;
  std::unique_ptr<MapPublisher> maps_;
  std::unique_ptr<PosePublisher> poses_;
  std::unique_ptr<MapperServices> services_;
  std::unique_ptr<ScanQueue<Waiting>> queue_;
  std::unique_ptr<diagnostic_updater::Updater> updater_;
  ros::WallTimer diagnostics_timer_;
  ImuYaw imu_;
  ros_health::InputHealth scan_health_{"scan"};
  ros_health::WorkHealth work_health_;
  std::unique_ptr<MappingHealth> health_;

  std::atomic<bool> paused_{false};
  std::atomic<bool> closing_{false};
  std::atomic<std::uint64_t> epoch_{0};         ///< number of backward time jumps
  std::atomic<bool> odometry_is_stale_{false};  ///< the map was replaced: odometry restarts

  std::mutex intake_mutex_;  ///< of what follows
  ros::Time newest_stamp_;
  std::uint64_t throttle_count_{0};

  // The worker's.
  std::optional<OdometryChain> chain_;
  std::uint64_t worked_epoch_{0};
  bool had_odometry_{false};
  bool odometry_is_missed_{false};
  ros::WallTime last_complaint_;

  ros::Subscriber scan_subscriber_;
  ros::Subscriber imu_subscriber_;
  ros::Subscriber people_subscriber_;
  std::thread worker_;
};

}  // namespace extperfc::ros_mapping
