#include "ros/convert/tracks.hpp"

#include <algorithm>
#include <limits>

#include "ros/convert/geometry.hpp"

namespace extperfc::ros_convert {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

track::Observation observation_of(const vision_msgs::Detection3D& detection,
                                  const Eigen::Isometry3d& target_T_source) {
  track::Observation observation;
  const auto& results = detection.results;
  const auto best = std::max_element(results.begin(), results.end(),
                                     [](const auto& a, const auto& b) { return a.score < b.score; });
  if (best == results.end()) {
    observation.position_m.setConstant(std::numeric_limits<double>::quiet_NaN());
    return observation;
  }
  observation.class_index = static_cast<int>(best->id);
  observation.score = best->score;
  const auto& position = best->pose.pose.position;
  observation.position_m = target_T_source * Eigen::Vector3d(position.x, position.y, position.z);
  const Eigen::Map<const Matrix6> covariance(best->pose.covariance.data());
  const Eigen::Matrix3d rotation = target_T_source.linear();
  observation.covariance_m2 = rotation * covariance.topLeftCorner<3, 3>() * rotation.transpose();
  return observation;
}

}  // namespace

std::vector<track::Observation> to_observations(const vision_msgs::Detection3DArray& message,
                                                const Eigen::Isometry3d& target_T_source) {
  std::vector<track::Observation> observations;
  observations.reserve(message.detections.size());
  for (const auto& detection : message.detections)
    observations.push_back(observation_of(detection, target_T_source));
  return observations;
}

TrackedBody body_of(const vision_msgs::Detection3D& detection, const Eigen::Isometry3d& target_T_source) {
  const auto& q = detection.bbox.center.orientation;
  Pose pose(Eigen::Quaterniond(q.w, q.x, q.y, q.z));
  pose.linear() = target_T_source.linear() * pose.linear();
  return {to_quaternion(pose), detection.bbox.size};
}

Track to_message(const track::Track& track, const TrackedBody& body) {
  Track message;
  message.id = track.id;
  message.class_id = track.class_index();
  message.score = track.score;
  message.pose.pose.position = to_point(track.point.position_m());
  message.pose.pose.orientation = body.orientation;
  Eigen::Map<Matrix6> covariance(message.pose.covariance.data());
  covariance.topLeftCorner<3, 3>() = track.point.covariance().topLeftCorner<3, 3>();
  message.velocity = to_vector(track.point.velocity_m_s());
  message.size = body.size;
  message.confirmed = static_cast<std::uint8_t>(track.confirmed ? 1 : 0);
  message.hits = static_cast<std::uint32_t>(track.hits);
  message.first_seen = ros::Time(track.first_seen_s);
  message.last_seen = ros::Time(track.last_seen_s);
  message.detection = track.observation ? static_cast<std::int32_t>(*track.observation) : -1;
  return message;
}

}  // namespace extperfc::ros_convert
