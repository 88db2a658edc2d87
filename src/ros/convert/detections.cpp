#include "ros/convert/detections.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "ros/convert/geometry.hpp"

namespace extperfc::ros_convert {

namespace {

/// A class keeps its colour: hues apart by the golden ratio.
std_msgs::ColorRGBA color_of(std::int64_t class_index, float alpha) {
  const double hue = 6.0 * (0.05 + 0.618034 * static_cast<double>(std::max<std::int64_t>(class_index, 0)));
  const auto channel = [&](double offset) {
    const double x = std::fmod(hue + offset, 6.0);
    return static_cast<float>(std::clamp(std::abs(x - 3.0) - 1.0, 0.0, 1.0));
  };
  std_msgs::ColorRGBA color;
  color.r = channel(0.0);
  color.g = channel(4.0);
  color.b = channel(2.0);
  color.a = alpha;
  return color;
}

visualization_msgs::Marker base_marker(const std_msgs::Header& header, const char* ns, int id,
                                       double lifetime_s) {
  visualization_msgs::Marker marker;
  marker.header = header;
  marker.ns = ns;
  marker.id = id;
  marker.action = visualization_msgs::Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.lifetime = ros::Duration(lifetime_s);
  return marker;
}

/// A point over the box as the camera sees it (the optical frame's y points down), clear of it by `gap_m`.
geometry_msgs::Point above(const vision_msgs::BoundingBox3D& box, double gap_m) {
  const auto& q = box.center.orientation;
  const Eigen::Vector3d up(0.0, -(0.5 * box.size.y + gap_m), 0.0);
  const Eigen::Vector3d offset = Eigen::Quaterniond(q.w, q.x, q.y, q.z) * up;
  geometry_msgs::Point point = box.center.position;
  point.x += offset.x();
  point.y += offset.y();
  point.z += offset.z();
  return point;
}

visualization_msgs::Marker label_marker(const vision_msgs::Detection3D& object, const std::string& name,
                                        int id, double lifetime_s) {
  constexpr double kTextHeightM = 0.06;
  auto marker = base_marker(object.header, "labels", id, lifetime_s);
  marker.type = visualization_msgs::Marker::TEXT_VIEW_FACING;
  marker.pose.position = above(object.bbox, kTextHeightM);
  marker.scale.z = kTextHeightM;
  marker.color.r = marker.color.g = marker.color.b = marker.color.a = 1.0F;
  const auto& result = object.results.front();
  const auto& center = result.pose.pose.position;
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(), "%s %.0f %%\n%.2f  %.2f  %.2f m", name.c_str(),
                100.0 * result.score, center.x, center.y, center.z);
  marker.text = text.data();
  return marker;
}

/// Where something is in the optical frame.
struct Placed {
  Eigen::Isometry3d optical_T_body;
  Eigen::Vector3d size_m;
  Eigen::Matrix3d covariance;  ///< of the body's origin [m^2]
};

Eigen::Isometry3d with_axes_of_camera(const Eigen::Vector3d& position) {
  return Eigen::Isometry3d(Eigen::Translation3d(position));
}

vision_msgs::Detection3D detection_of(const Detection& detection, const Placed& placed,
                                      const Eigen::Isometry3d& target_T_optical,
                                      const std_msgs::Header& header) {
  vision_msgs::Detection3D message;
  message.header = header;
  message.bbox.center = to_message(Eigen::Isometry3d(target_T_optical * placed.optical_T_body));
  message.bbox.size = to_vector(placed.size_m);
  message.results.resize(1);
  auto& result = message.results[0];
  result.id = detection.class_index;
  result.score = detection.score;
  result.pose.pose = message.bbox.center;
  const Eigen::Matrix3d rotation = target_T_optical.linear();
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> covariance(result.pose.covariance.data());
  covariance.topLeftCorner<3, 3>() = rotation * placed.covariance * rotation.transpose();
  return message;
}

}  // namespace

vision_msgs::Detection2DArray to_message(const Detections& detections, const std_msgs::Header& header) {
  vision_msgs::Detection2DArray message;
  message.header = header;
  message.detections.resize(detections.size());
  for (std::size_t i = 0; i < detections.size(); ++i) {
    auto& out = message.detections[i];
    out.header = header;
    out.results.resize(1);
    out.results[0].id = detections[i].class_index;
    out.results[0].score = detections[i].score;
    out.results[0].pose.pose.orientation.w = 1.0;
    out.bbox.center.x = detections[i].box.center_x();
    out.bbox.center.y = detections[i].box.center_y();
    out.bbox.size_x = detections[i].box.width();
    out.bbox.size_y = detections[i].box.height();
  }
  return message;
}

Detections from_message(const vision_msgs::Detection2DArray& message) {
  Detections detections;
  detections.reserve(message.detections.size());
  for (const auto& in : message.detections) {
    const auto best = std::max_element(in.results.begin(), in.results.end(),
                                       [](const auto& a, const auto& b) { return a.score < b.score; });
    const auto half_width = static_cast<float>(0.5 * in.bbox.size_x);
    const auto half_height = static_cast<float>(0.5 * in.bbox.size_y);
    const auto x = static_cast<float>(in.bbox.center.x);
    const auto y = static_cast<float>(in.bbox.center.y);
    Detection out{-1, 0.0F, {x - half_width, y - half_height, x + half_width, y + half_height}};
    if (best != in.results.end()) {
      out.class_index = static_cast<int>(best->id);
      out.score = static_cast<float>(best->score);
    }
    detections.push_back(out);
  }
  return detections;
}

vision_msgs::Detection3D to_message(const Detection& detection, const depth::Object3& object,
                                    const Eigen::Isometry3d& target_T_optical,
                                    const std_msgs::Header& header) {
  const Placed placed{with_axes_of_camera(object.center), object.size, object.center_covariance};
  return detection_of(detection, placed, target_T_optical, header);
}

vision_msgs::Detection3D to_message(const Detection& detection, const depth::ObjectFit& object,
                                    const Eigen::Isometry3d& target_T_optical,
                                    const std_msgs::Header& header) {
  const Placed placed{object.camera_T_object, object.size_m, object.covariance};
  return detection_of(detection, placed, target_T_optical, header);
}

vision_msgs::Detection3D to_surface_message(const Detection& detection, const depth::Object3& object,
                                            const Eigen::Isometry3d& target_T_optical,
                                            const std_msgs::Header& header) {
  const Placed placed{with_axes_of_camera(object.surface), Eigen::Vector3d::Zero(),
                      object.surface_covariance};
  return detection_of(detection, placed, target_T_optical, header);
}

visualization_msgs::MarkerArray to_markers(const vision_msgs::Detection3DArray& objects,
                                           const std::vector<std::string>& class_names, double lifetime_s) {
  constexpr float kSeeThrough = 0.3F;
  visualization_msgs::MarkerArray array;
  visualization_msgs::Marker clear;
  clear.header = objects.header;
  clear.action = visualization_msgs::Marker::DELETEALL;
  array.markers.push_back(clear);
  int id = 0;
  for (const auto& object : objects.detections) {
    const auto class_index = object.results.front().id;
    auto body = base_marker(object.header, "objects", id, lifetime_s);
    body.type = visualization_msgs::Marker::CUBE;
    body.pose = object.bbox.center;
    body.scale = object.bbox.size;
    body.color = color_of(class_index, kSeeThrough);
    array.markers.push_back(body);
    array.markers.push_back(label_marker(object, class_name(class_names, class_index), id, lifetime_s));
    ++id;
  }
  return array;
}

std::string class_name(const std::vector<std::string>& names, std::int64_t index) {
  if (index >= 0 && static_cast<std::size_t>(index) < names.size())
    return names[static_cast<std::size_t>(index)];
  return "class " + std::to_string(index);
}

}  // namespace extperfc::ros_convert
