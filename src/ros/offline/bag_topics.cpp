#include "ros/offline/bag_topics.hpp"

#include <algorithm>
#include <map>
#include <set>

#include <rosbag/view.h>

#include "extperfc/base/text.hpp"

namespace extperfc::ros_offline {

namespace {

using Topics = std::map<std::string, std::string>;  // name -> type

constexpr const char* kScan = "sensor_msgs/LaserScan";
constexpr const char* kEchoes = "sensor_msgs/MultiEchoLaserScan";
constexpr const char* kOdometry = "nav_msgs/Odometry";

Topics topics_of(const rosbag::Bag& bag) {
  Topics topics;
  rosbag::View view(bag);
  for (const auto* connection : view.getConnections()) topics[connection->topic] = connection->datatype;
  return topics;
}

std::vector<std::string> of_types(const Topics& topics, const std::set<std::string>& types) {
  std::vector<std::string> names;
  for (const auto& [name, type] : topics)
    if (types.count(type) != 0) names.push_back(name);
  return names;
}

/// The topic that the user named, with or without its leading slash.
Result<std::string> named(const Topics& topics, const std::string& wanted, const std::set<std::string>& types,
                          const char* option) {
  for (const auto& name : {wanted, "/" + wanted}) {
    const auto found = topics.find(name);
    if (found == topics.end()) continue;
    if (types.count(found->second) != 0) return name;
    return fail(ErrorCode::kInvalidArgument, std::string(option) + ": " + name + " is of type " +
                                                 found->second + ", not " + *types.begin());
  }
  const auto known = joined(of_types(topics, types));
  return fail(ErrorCode::kNotFound, std::string(option) + ": the bag has no topic " + wanted +
                                        (known.empty() ? "" : "; there are: " + known));
}

Result<std::string> choose_scan(const Topics& topics, const std::string& wanted) {
  const std::set<std::string> types = {kScan, kEchoes};
  if (!wanted.empty()) return named(topics, wanted, types, "--scan-topic");
  const auto known = of_types(topics, types);
  if (known.size() == 1) return known.front();
  if (known.empty())
    return fail(ErrorCode::kNotFound, "the bag has no topic with planar laser scans (sensor_msgs/LaserScan)");
  return fail(ErrorCode::kInvalidArgument,
              "the bag has several topics with laser scans; give one with --scan-topic: " + joined(known));
}

bool ends_with_static(const std::string& name) {
  constexpr std::string_view kEnd = "tf_static";
  return name.size() >= kEnd.size() && name.compare(name.size() - kEnd.size(), kEnd.size(), kEnd) == 0;
}

}  // namespace

Result<BagTopics> choose_topics(const rosbag::Bag& bag, const offline::RecordingOptions& options) {
  const Topics topics = topics_of(bag);
  BagTopics chosen;
  const auto scan = choose_scan(topics, options.scan_topic);
  if (!scan) return tl::unexpected(scan.error());
  chosen.scan = *scan;
  if (!options.odom_topic.empty()) {
    const auto odometry = named(topics, options.odom_topic, {kOdometry}, "--odom-topic");
    if (!odometry) return tl::unexpected(odometry.error());
    chosen.odometry = *odometry;
  }
  for (const auto& name : of_types(topics, {"tf2_msgs/TFMessage", "tf/tfMessage"}))
    (ends_with_static(name) ? chosen.fixed : chosen.moving).push_back(name);
  if (chosen.odometry.empty()) {
    const auto known = of_types(topics, {kOdometry});
    if (known.size() == 1) chosen.odometry = known.front();
  }
  return chosen;
}

}  // namespace extperfc::ros_offline
