#include "ros/navigate/display.hpp"

#include <array>
#include <cmath>
#include <utility>

#include <geometry_msgs/PolygonStamped.h>
#include <geometry_msgs/PoseStamped.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Path.h>
#include <visualization_msgs/MarkerArray.h>

#include "extperfc/base/math.hpp"

#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_navigate {

namespace {

using navigate::CellBox;
using navigate::CostGrid;

std::array<std::int8_t, 256> make_table() {
  std::array<std::int8_t, 256> table{};
  for (int cost = 1; cost < navigate::kInscribedCost; ++cost)
    table[static_cast<std::size_t>(cost)] = static_cast<std::int8_t>(1 + 97 * (cost - 1) / 251);
  table[navigate::kInscribedCost] = 99;
  table[navigate::kLethalCost] = 100;
  table[navigate::kUnknownCost] = -1;
  return table;
}

std::int8_t shown(navigate::Cost cost) {
  static const auto table = make_table();
  return table[cost];
}

bool same_place(const CostGrid& a, const CostGrid& b) {
  return a.width == b.width && a.height == b.height && a.resolution_m == b.resolution_m &&
         a.origin_m == b.origin_m;
}

/// The smallest box around cells that differ.
CellBox changed_box(const CostGrid& a, const CostGrid& b) {
  CellBox box;
  for (int row = 0; row < a.height; ++row)
    for (int column = 0; column < a.width; ++column) {
      const auto index = a.index({column, row});
      if (a.cells[index] != b.cells[index]) box = box.joined({{column, row}, {column + 1, row + 1}});
    }
  return box;
}

nav_msgs::Path to_message(const std::vector<Pose2>& poses, const std::string& frame, const ros::Time& stamp) {
  nav_msgs::Path message;
  message.header.frame_id = frame;
  message.header.stamp = stamp;
  message.poses.reserve(poses.size());
  for (const auto& pose : poses) {
    geometry_msgs::PoseStamped one;
    one.header = message.header;
    one.pose = ros_convert::to_pose_message(pose);
    message.poses.push_back(one);
  }
  return message;
}

visualization_msgs::Marker marker(const std::string& frame, const ros::Time& stamp, const char* ns, int id) {
  visualization_msgs::Marker one;
  one.header.frame_id = frame;
  one.header.stamp = stamp;
  one.ns = ns;
  one.id = id;
  one.pose.orientation.w = 1;
  return one;
}

void colour(visualization_msgs::Marker& one, float red, float green, float blue, float alpha) {
  one.color.r = red;
  one.color.g = green;
  one.color.b = blue;
  one.color.a = alpha;
}

}  // namespace

CostMapPublisher::CostMapPublisher(ros::NodeHandle handle, const std::string& topic, std::string frame)
    : frame_(std::move(frame)),
      whole_(handle.advertise<nav_msgs::OccupancyGrid>(topic, 1, true)),
      changes_(handle.advertise<map_msgs::OccupancyGridUpdate>(topic + "_updates", 5)) {}

void CostMapPublisher::publish(const GridPtr& grid, const ros::Time& stamp) {
  if (!grid) return;
  const unsigned subscribers = whole_.getNumSubscribers();
  const auto before = std::exchange(grid_, grid);
  const bool more = subscribers > std::exchange(subscribers_, subscribers);
  if (!before || more || !same_place(*before, *grid)) {
    if (!before || subscribers > 0) publish_whole(stamp);
  } else if (before != grid && changes_.getNumSubscribers() > 0) {
    publish_changes(*before, stamp);
  }
}

void CostMapPublisher::publish_whole(const ros::Time& stamp) {
  nav_msgs::OccupancyGrid message;
  message.header.frame_id = frame_;
  message.header.stamp = stamp;
  message.info.map_load_time = stamp;
  message.info.resolution = static_cast<float>(grid_->resolution_m);
  message.info.width = static_cast<std::uint32_t>(grid_->width);
  message.info.height = static_cast<std::uint32_t>(grid_->height);
  message.info.origin = ros_convert::to_pose_message({grid_->origin_m.x(), grid_->origin_m.y(), 0});
  message.data.reserve(grid_->cells.size());
  for (const auto cost : grid_->cells) message.data.push_back(shown(cost));
  whole_.publish(message);
}

void CostMapPublisher::publish_changes(const CostGrid& before, const ros::Time& stamp) {
  const auto box = changed_box(before, *grid_);
  if (box.empty()) return;
  map_msgs::OccupancyGridUpdate message;
  message.header.frame_id = frame_;
  message.header.stamp = stamp;
  message.x = box.min.column;
  message.y = box.min.row;
  message.width = static_cast<std::uint32_t>(box.max.column - box.min.column);
  message.height = static_cast<std::uint32_t>(box.max.row - box.min.row);
  message.data.reserve(static_cast<std::size_t>(message.width) * message.height);
  for (int row = box.min.row; row < box.max.row; ++row)
    for (int column = box.min.column; column < box.max.column; ++column)
      message.data.push_back(shown(grid_->at({column, row})));
  changes_.publish(message);
}

Display::Display(ros::NodeHandle handle, std::string global_frame, std::string odom_frame)
    : global_frame_(std::move(global_frame)),
      odom_frame_(std::move(odom_frame)),
      global_plan_(handle.advertise<nav_msgs::Path>("global_plan", 1, true)),
      local_plan_(handle.advertise<nav_msgs::Path>("local_plan", 1)),
      candidates_(handle.advertise<visualization_msgs::MarkerArray>("candidates", 1)),
      footprint_(handle.advertise<geometry_msgs::PolygonStamped>("local_costmap/footprint", 1)),
      people_(handle.advertise<visualization_msgs::MarkerArray>("people", 1)),
      goal_(handle.advertise<geometry_msgs::PoseStamped>("current_goal", 1, true)) {}

void Display::global_plan(const navigate::Path& path, const ros::Time& stamp) {
  global_plan_.publish(to_message(path.poses, global_frame_, stamp));
}

void Display::local_plan(const std::vector<Pose2>& trajectory, const ros::Time& stamp) {
  if (local_plan_.getNumSubscribers() > 0) local_plan_.publish(to_message(trajectory, odom_frame_, stamp));
}

void Display::candidates(const std::vector<std::vector<Pose2>>& trajectories, const ros::Time& stamp) {
  if (!wants_candidates()) return;
  constexpr double kLineM = 0.01;
  visualization_msgs::MarkerArray message;
  auto lines = marker(odom_frame_, stamp, "candidates", 0);
  lines.type = visualization_msgs::Marker::LINE_LIST;
  lines.scale.x = kLineM;
  colour(lines, 0.2F, 0.7F, 0.9F, 0.5F);
  for (const auto& trajectory : trajectories)
    for (std::size_t i = 1; i < trajectory.size(); ++i)
      for (const auto* pose : {&trajectory[i - 1], &trajectory[i]}) {
        geometry_msgs::Point point;
        point.x = pose->x;
        point.y = pose->y;
        point.z = 0.02;
        lines.points.push_back(point);
      }
  if (lines.points.empty()) lines.action = visualization_msgs::Marker::DELETE;
  message.markers.push_back(lines);
  candidates_.publish(message);
}

void Display::footprint(const navigate::Footprint& footprint, const Pose2& odom_T_base,
                        const ros::Time& stamp) {
  if (footprint_.getNumSubscribers() == 0) return;
  geometry_msgs::PolygonStamped message;
  message.header.frame_id = odom_frame_;
  message.header.stamp = stamp;
  for (const auto& corner : footprint.corners_m()) {
    const Pose2 place = compose(odom_T_base, {corner.x(), corner.y(), 0});
    geometry_msgs::Point32 point;
    point.x = static_cast<float>(place.x);
    point.y = static_cast<float>(place.y);
    message.polygon.points.push_back(point);
  }
  footprint_.publish(message);
}

void Display::people(const std::vector<navigate::MovingObstacle>& people, const ros::Time& stamp) {
  if (people_.getNumSubscribers() == 0) return;
  constexpr double kHeightM = 1.7;
  constexpr double kArrowS = 1.0;
  visualization_msgs::MarkerArray message;
  auto clear = marker(odom_frame_, stamp, "people", 0);
  clear.action = visualization_msgs::Marker::DELETEALL;
  message.markers.push_back(clear);
  int id = 0;
  for (const auto& person : people) {
    auto body = marker(odom_frame_, stamp, "people", ++id);
    body.type = visualization_msgs::Marker::CYLINDER;
    body.pose.position.x = person.position_m.x();
    body.pose.position.y = person.position_m.y();
    body.pose.position.z = kHeightM / 2;
    body.scale.x = body.scale.y = 2 * person.radius_m;
    body.scale.z = kHeightM;
    colour(body, 0.95F, 0.5F, 0.1F, 0.5F);
    message.markers.push_back(body);
    auto arrow = marker(odom_frame_, stamp, "velocities", id);
    arrow.type = visualization_msgs::Marker::ARROW;
    arrow.points.resize(2);
    arrow.points[0].x = person.position_m.x();
    arrow.points[0].y = person.position_m.y();
    arrow.points[1].x = person.position_m.x() + kArrowS * person.velocity_m_s.x();
    arrow.points[1].y = person.position_m.y() + kArrowS * person.velocity_m_s.y();
    arrow.points[0].z = arrow.points[1].z = kHeightM;
    arrow.scale.x = 0.05;
    arrow.scale.y = 0.12;
    colour(arrow, 0.95F, 0.3F, 0.1F, 0.9F);
    message.markers.push_back(arrow);
  }
  people_.publish(message);
}

void Display::goal(const Pose2& goal, const ros::Time& stamp) {
  geometry_msgs::PoseStamped message;
  message.header.frame_id = global_frame_;
  message.header.stamp = stamp;
  message.pose = ros_convert::to_pose_message(goal);
  goal_.publish(message);
}

}  // namespace extperfc::ros_navigate
