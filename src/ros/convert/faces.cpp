#include "ros/convert/faces.hpp"

#include <string>

#include <boost/make_shared.hpp>

#include "ros/convert/annotate.hpp"
#include "ros/convert/geometry.hpp"

namespace extperfc::ros_convert {

namespace {

constexpr double kBallM = 0.05;
constexpr double kNameM = 0.08;  // height of the letters
constexpr double kGapM = 0.12;   // from the middle of a face to its name

Face message_of(const NamedFace& named) {
  Face message;
  const auto& box = named.face.box;
  message.bbox.center.x = box.center_x();
  message.bbox.center.y = box.center_y();
  message.bbox.size_x = box.width();
  message.bbox.size_y = box.height();
  for (std::size_t i = 0; i < named.face.landmarks.size(); ++i) {
    message.landmarks[i].x = named.face.landmarks[i].x();
    message.landmarks[i].y = named.face.landmarks[i].y();
  }
  message.score = named.face.score;
  message.name = named.identity.name;
  message.similarity = named.identity.similarity;
  message.has_position = static_cast<unsigned char>(named.position_m.has_value());
  if (named.position_m) message.position = to_point(*named.position_m);
  return message;
}

std::string shown_name(const std::string& name) {
  return name.empty() ? "unknown" : name;
}

visualization_msgs::Marker face_marker(const FaceArray& array, const Face& face, int id, double lifetime_s) {
  visualization_msgs::Marker marker;
  marker.header = array.header;
  marker.id = id;
  marker.action = visualization_msgs::Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.pose.position = face.position;
  marker.lifetime = ros::Duration(lifetime_s);
  marker.color.r = face.name.empty() ? 1.0F : 0.2F;
  marker.color.g = face.name.empty() ? 0.6F : 0.9F;
  marker.color.b = 0.2F;
  marker.color.a = 1.0F;
  return marker;
}

}  // namespace

FaceArrayPtr to_message(const std::vector<NamedFace>& faces, const std_msgs::Header& header) {
  auto message = boost::make_shared<FaceArray>();
  message->header = header;
  for (const auto& named : faces) message->faces.push_back(message_of(named));
  return message;
}

visualization_msgs::MarkerArray to_markers(const FaceArray& faces, double lifetime_s) {
  visualization_msgs::MarkerArray array;
  auto& clear = array.markers.emplace_back();
  clear.header = faces.header;
  clear.action = visualization_msgs::Marker::DELETEALL;
  int id = 0;
  for (const auto& face : faces.faces) {
    if (face.has_position == 0U) continue;
    auto ball = face_marker(faces, face, id, lifetime_s);
    ball.ns = "faces";
    ball.type = visualization_msgs::Marker::SPHERE;
    ball.scale.x = ball.scale.y = ball.scale.z = kBallM;
    array.markers.push_back(ball);
    auto label = face_marker(faces, face, id++, lifetime_s);
    label.ns = "names";
    label.type = visualization_msgs::Marker::TEXT_VIEW_FACING;
    label.scale.z = kNameM;
    label.pose.position.z += kGapM;
    label.text = shown_name(face.name);
    array.markers.push_back(label);
  }
  return array;
}

Result<sensor_msgs::ImagePtr> annotate(const SharedImage& image, const std::vector<NamedFace>& faces) {
  Detections boxes;
  std::vector<std::string> names;
  for (const auto& [face, identity, position_m] : faces) {
    const bool known = !identity.name.empty();
    boxes.push_back({static_cast<int>(names.size()), known ? identity.similarity : face.score, face.box});
    names.push_back(shown_name(identity.name));
  }
  return annotate(image, boxes, names);
}

}  // namespace extperfc::ros_convert
