#include "ros/arm/scene_monitor.hpp"

namespace extperfc::ros_arm {

namespace {

constexpr double kRetry_s = 5.0;

}  // namespace

Result<std::optional<Pose>> WorldFrame::world_T_root(const ros::Time& stamp) {
  if (!missing_since_.isZero() && (ros::WallTime::now() - missing_since_).toSec() < kRetry_s)
    return std::nullopt;
  const auto root_T_world = transforms_.root_T_frame(name_, stamp);
  if (!root_T_world && transforms_.root_T_frame(name_, ros::Time()))
    return fail(ErrorCode::kNotFound, root_T_world.error().message);
  missing_since_ = root_T_world ? ros::WallTime() : ros::WallTime::now();
  if (!root_T_world) return std::nullopt;
  return root_T_world->inverse();
}

Result<Pose> root_T_header(const TransformLookup& transforms, const std_msgs::Header& header,
                           const char* topic) {
  if (header.frame_id.empty() || header.stamp.isZero())
    return fail(
        ErrorCode::kInvalidArgument,
        std::string(topic) + " has no frame_id or no stamp in its header: the publisher must set both");
  const auto root_T_frame = transforms.root_T_frame(header.frame_id, header.stamp);
  if (!root_T_frame)
    return fail(ErrorCode::kNotFound, std::string(topic) + ": " + root_T_frame.error().message +
                                          "; publish it, or use another frame_id");
  return *root_T_frame;
}

}  // namespace extperfc::ros_arm
