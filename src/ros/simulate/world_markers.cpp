#include "ros/simulate/world_markers.hpp"

#include <utility>

#include "extperfc/base/math.hpp"

#include "ros/convert/geometry.hpp"
#include "ros/convert/shape_marker.hpp"
#include "ros/simulate/frames.hpp"

namespace extperfc::ros_simulate {

namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

std_msgs::ColorRGBA to_color(const Eigen::Vector3f& rgb) {
  std_msgs::ColorRGBA color;
  color.r = rgb.x();
  color.g = rgb.y();
  color.b = rgb.z();
  color.a = 1.0F;
  return color;
}

Marker solid(const Geometry& geometry, const Eigen::Vector3f& rgb) {
  Marker marker = ros_convert::to_marker(geometry);
  marker.color = to_color(rgb);
  return marker;
}

bool has_moved(const Pose& from, const Pose& to) {
  constexpr double kMinM = 1e-3;
  constexpr double kMinRad = 0.1 * kPi / 180;
  return (to.translation() - from.translation()).norm() > kMinM ||
         Eigen::AngleAxisd(from.linear().transpose() * to.linear()).angle() > kMinRad;
}

}  // namespace

WorldMarkers::WorldMarkers(const simulate::WorldSpec& world) {
  for (const auto& body : world.bodies) add_body(body);
  for (const auto& person : world.people) add_person(person);
}

void WorldMarkers::add_body(const simulate::BodySpec& body) {
  Carrier carrier;
  carrier.shown = body.world_T_body;
  for (const auto& shape : body.shapes)
    add_part(carrier, solid(shape.geometry, shape.material.colour), shape.body_T_shape, body.name);
  carriers_.push_back(std::move(carrier));
}

/// Legs, body and head of a person 1.75 m tall.
void WorldMarkers::add_person(const simulate::PersonSpec& person) {
  const Eigen::Vector3f skin(0.85F, 0.68F, 0.55F);
  const Eigen::Vector3f trousers(0.18F, 0.18F, 0.22F);
  Carrier carrier;
  const auto add = [&](const Geometry& geometry, const Eigen::Vector3f& rgb, double y, double z) {
    add_part(carrier, solid(geometry, rgb), make_pose({0, y, z}), person.name);
  };
  for (const double side : {-1.0, 1.0}) add(Cylinder{0.08, 0.85}, trousers, 0.1 * side, 0.425);
  add(Cylinder{0.2, 0.65}, person.colour, 0, 1.17);
  add(Sphere{0.12}, skin, 0, 1.63);
  carriers_.push_back(std::move(carrier));
}

void WorldMarkers::add_part(Carrier& carrier, Marker marker, const Pose& carrier_T_part,
                            const std::string& ns) {
  marker.header.frame_id = kMapFrame;
  marker.ns = ns;
  marker.id = next_id_++;
  carrier.parts.push_back({std::move(marker), carrier_T_part});
}

std::vector<Pose> WorldMarkers::poses(const simulate::Snapshot& snapshot) const {
  std::vector<Pose> all = snapshot.world_T_body;
  for (const auto& person : snapshot.world_T_person) all.push_back(to_pose(person));
  return all;
}

void WorldMarkers::append(const Carrier& carrier, const Pose& map_T_carrier, const ros::Time& stamp,
                          MarkerArray& array) {
  for (const auto& part : carrier.parts) {
    array.markers.push_back(part.marker);
    array.markers.back().header.stamp = stamp;
    array.markers.back().pose = ros_convert::to_message(map_T_carrier * part.carrier_T_part);
  }
}

MarkerArray WorldMarkers::all(const simulate::Snapshot& snapshot, const ros::Time& stamp) const {
  MarkerArray array;
  const auto where = poses(snapshot);
  for (std::size_t i = 0; i < carriers_.size() && i < where.size(); ++i)
    append(carriers_[i], where[i], stamp, array);
  return array;
}

MarkerArray WorldMarkers::moved(const simulate::Snapshot& snapshot, const ros::Time& stamp) {
  MarkerArray array;
  const auto where = poses(snapshot);
  for (std::size_t i = 0; i < carriers_.size() && i < where.size(); ++i) {
    if (!has_moved(carriers_[i].shown, where[i])) continue;
    carriers_[i].shown = where[i];
    append(carriers_[i], where[i], stamp, array);
  }
  return array;
}

}  // namespace extperfc::ros_simulate
