#include <algorithm>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/MultiEchoLaserScan.h>

#include "extperfc/offline/recording.hpp"
#include "extperfc/sources/scan_pairing.hpp"

#include "ros/convert/laser_scan.hpp"
#include "ros/convert/planar_pose.hpp"
#include "ros/offline/bag_topics.hpp"
#include "ros/offline/bag_transforms.hpp"

namespace extperfc::ros_offline {

namespace {

namespace fs = std::filesystem;
using offline::RecordingOptions;
using sources::ScanRecord;

constexpr std::size_t kMaxComplaints = 10;

/// The laser scan of a message of either type; no value for other types.
std::optional<sensor_msgs::LaserScan> scan_of(const rosbag::MessageInstance& message) {
  if (const auto scan = message.instantiate<sensor_msgs::LaserScan>()) return *scan;
  if (const auto echoes = message.instantiate<sensor_msgs::MultiEchoLaserScan>())
    return ros_convert::to_single_echo(*echoes);
  return std::nullopt;
}

class ScanBag : public sources::ScanLog {
 public:
  ScanBag(fs::path file, RecordingOptions options) : file_(std::move(file)), options_(std::move(options)) {}

  /// Throws rosbag::BagException.
  [[nodiscard]] Result<void> open();
  Result<std::optional<ScanRecord>> next() override;
  [[nodiscard]] double progress() const override {
    return messages_ == 0 ? 1.0 : static_cast<double>(read_) / static_cast<double>(messages_);
  }
  [[nodiscard]] std::size_t damaged() const override { return damaged_; }
  [[nodiscard]] const std::vector<std::string>& complaints() const override { return complaints_; }

 private:
  [[nodiscard]] std::vector<std::string> transform_topics() const;
  /// Reads transforms until the scanner's place and odometry are known.
  [[nodiscard]] Result<void> look_ahead();
  [[nodiscard]] Result<std::string> scanner_frame();
  void step();
  void use(const rosbag::MessageInstance& message);
  void use_transforms(const tf2_msgs::TFMessage& message, bool is_static);
  void use_scan(const sensor_msgs::LaserScan& message);
  [[nodiscard]] bool is_static(const std::string& topic) const;
  void complain(const std::string& what);

  fs::path file_;
  RecordingOptions options_;
  rosbag::Bag bag_;
  BagTopics topics_;
  Pose base_T_scanner_{Pose::Identity()};
  bool odometry_of_tf_{false};
  std::unique_ptr<BagTransforms> transforms_;
  std::unique_ptr<rosbag::View> view_;
  rosbag::View::iterator at_;
  std::size_t messages_{0};
  std::size_t read_{0};
  sources::ScanPairing pairing_;
  std::size_t scans_{0};
  std::size_t damaged_{0};
  std::string broken_;
  std::vector<std::string> complaints_;
};

Result<void> ScanBag::open() {
  bag_.open(file_.string(), rosbag::bagmode::Read);
  auto topics = choose_topics(bag_, options_);
  if (!topics) return fail(topics.error().code, file_.string() + ": " + topics.error().message);
  topics_ = *std::move(topics);
  if (const auto looked = look_ahead(); !looked)
    return fail(looked.error().code, file_.string() + ": " + looked.error().message);
  std::vector<std::string> wanted{topics_.scan};
  if (odometry_of_tf_) {
    const auto transforms = transform_topics();
    wanted.insert(wanted.end(), transforms.begin(), transforms.end());
  } else if (!topics_.odometry.empty()) {
    wanted.push_back(topics_.odometry);
  }
  transforms_ = std::make_unique<BagTransforms>();
  view_ = std::make_unique<rosbag::View>(bag_, rosbag::TopicQuery(wanted));
  messages_ = view_->size();
  at_ = view_->begin();
  return {};
}

std::vector<std::string> ScanBag::transform_topics() const {
  std::vector<std::string> topics = topics_.fixed;
  topics.insert(topics.end(), topics_.moving.begin(), topics_.moving.end());
  return topics;
}

bool ScanBag::is_static(const std::string& topic) const {
  return std::find(topics_.fixed.begin(), topics_.fixed.end(), topic) != topics_.fixed.end();
}

Result<std::string> ScanBag::scanner_frame() {
  rosbag::View view(bag_, rosbag::TopicQuery(topics_.scan));
  for (const auto& message : view)
    if (const auto scan = scan_of(message)) return ros_convert::without_slash(scan->header.frame_id);
  return fail(ErrorCode::kCorrupt, topics_.scan + " holds no laser scan that can be read");
}

Result<void> ScanBag::look_ahead() {
  const auto scanner = scanner_frame();
  if (!scanner) return tl::unexpected(scanner.error());
  const auto& given = options_.log.base_T_sensor;
  if (given) base_T_scanner_ = to_pose(*given);
  bool placed = given.has_value() || *scanner == options_.base_frame;
  const bool want_tf = options_.odom_topic.empty();
  BagTransforms transforms;
  const auto topics = transform_topics();
  if (!topics.empty()) {
    rosbag::View view(bag_, rosbag::TopicQuery(topics));
    for (const auto& message : view) {
      if (placed && (odometry_of_tf_ || !want_tf)) break;
      const auto transform = message.instantiate<tf2_msgs::TFMessage>();
      if (!transform) continue;
      transforms.add(*transform, is_static(message.getTopic()));
      const auto found = placed ? std::nullopt : transforms.newest(options_.base_frame, *scanner);
      if (found) base_T_scanner_ = found->pose;
      placed = placed || found;
      odometry_of_tf_ =
          odometry_of_tf_ || (want_tf && transforms.newest(options_.odom_frame, options_.base_frame));
    }
  }
  if (placed) return {};
  return fail(ErrorCode::kInvalidArgument,
              "tf has no transform of the scanner '" + *scanner + "' on '" + options_.base_frame +
                  "'; give --laser-pose x,y,yaw or the right --base-frame (frames: " + transforms.frames() +
                  ")");
}

Result<std::optional<ScanRecord>> ScanBag::next() {
  while (true) {
    if (auto record = pairing_.take()) return record;
    if (!broken_.empty()) return fail(ErrorCode::kCorrupt, broken_);
    if (at_ == view_->end()) {
      pairing_.finish();
      return pairing_.take();
    }
    try {
      step();
    } catch (const std::exception& e) {
      broken_ = file_.string() + " is damaged after message " + std::to_string(read_) + ": " + e.what();
      pairing_.finish();
    }
  }
}

void ScanBag::step() {
  try {
    use(*at_);
  } catch (const ros::serialization::StreamOverrunException& e) {
    complain(at_->getTopic() + " message is damaged");
  }
  ++read_;
  ++at_;
}

void ScanBag::use(const rosbag::MessageInstance& message) {
  const auto& topic = message.getTopic();
  if (topic == topics_.scan) {
    if (const auto scan = scan_of(message))
      use_scan(*scan);
    else
      complain(topic + " message is of another definition");
  } else if (const auto transforms = message.instantiate<tf2_msgs::TFMessage>()) {
    use_transforms(*transforms, is_static(topic));
  } else if (const auto odometry = message.instantiate<nav_msgs::Odometry>()) {
    const auto pose = ros_convert::to_pose2(odometry->pose.pose);
    if (pose)
      pairing_.add_odometry(odometry->header.stamp.toSec(), *pose);
    else
      complain(topic + ": " + pose.error().message);
  }
}

void ScanBag::use_transforms(const tf2_msgs::TFMessage& message, bool is_static) {
  transforms_->add(message, is_static);
  const auto odometry = transforms_->newest(options_.odom_frame, options_.base_frame);
  if (odometry && odometry->stamp_s > 0) pairing_.add_odometry(odometry->stamp_s, to_pose2(odometry->pose));
}

void ScanBag::use_scan(const sensor_msgs::LaserScan& message) {
  const std::size_t index = scans_++;
  auto scan = ros_convert::to_laser_scan(message, base_T_scanner_);
  if (!scan) return complain(topics_.scan + ": " + scan.error().message);
  if (const double max_m = options_.log.max_range_m; max_m > 0) {
    for (auto& range : scan->ranges)
      if (range >= static_cast<float>(max_m)) range = std::numeric_limits<float>::infinity();
    scan->range_max = max_m;
  }
  pairing_.add_scan({*std::move(scan), std::nullopt, index});
}

void ScanBag::complain(const std::string& what) {
  ++damaged_;
  if (complaints_.size() < kMaxComplaints)
    complaints_.push_back(file_.filename().string() + " message " + std::to_string(read_) + ", " + what);
}

Result<std::unique_ptr<sources::ScanLog>> open_bag(const fs::path& file, const RecordingOptions& options) {
  try {
    auto bag = std::make_unique<ScanBag>(file, options);
    if (auto opened = bag->open(); !opened) return tl::unexpected(opened.error());
    return bag;
  } catch (const rosbag::BagUnindexedException&) {
    return fail(ErrorCode::kCorrupt,
                file.string() + " was not closed when it was recorded; run: rosbag reindex " + file.string());
  } catch (const std::exception& e) {
    return fail(ErrorCode::kCorrupt, file.string() + " is a damaged bag: " + e.what());
  }
}

}  // namespace

}  // namespace extperfc::ros_offline

extern "C" void extperfc_open_scan_bag(
    const std::filesystem::path& file, const extperfc::offline::RecordingOptions& options,
    extperfc::Result<std::unique_ptr<extperfc::sources::ScanLog>>& opened) {
  opened = extperfc::ros_offline::open_bag(file, options);
}
