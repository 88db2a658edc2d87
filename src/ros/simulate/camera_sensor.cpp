#include "ros/simulate/camera_sensor.hpp"

#include <cmath>
#include <cstring>
#include <limits>

#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/image_encodings.h>
#include <vision_msgs/Detection2DArray.h>

#include "ros/convert/detections.hpp"
#include "ros/convert/image.hpp"
#include "ros/simulate/frames.hpp"

namespace extperfc::ros_simulate {

namespace {

namespace encodings = sensor_msgs::image_encodings;

sensor_msgs::ImagePtr empty_image(const std_msgs::Header& header, const simulate::CameraImages& images,
                                  const char* encoding, int bytes_per_pixel) {
  auto message = boost::make_shared<sensor_msgs::Image>();
  message->header = header;
  message->width = static_cast<std::uint32_t>(images.width);
  message->height = static_cast<std::uint32_t>(images.height);
  message->encoding = encoding;
  message->step = static_cast<std::uint32_t>(images.width * bytes_per_pixel);
  return message;
}

sensor_msgs::ImagePtr to_image(const std_msgs::Header& header, const simulate::CameraImages& images,
                               const std::vector<std::uint16_t>& pixels) {
  auto message = empty_image(header, images, encodings::TYPE_16UC1.c_str(), 2);
  message->data.resize(2 * pixels.size());
  std::memcpy(message->data.data(), pixels.data(), message->data.size());
  return message;
}

std::string place_of(const sensor_msgs::ImageConstPtr& image) {
  if (!image) return "none yet";
  char text[64];
  std::snprintf(text, sizeof text, "%u.%09u @ %p", image->header.stamp.sec, image->header.stamp.nsec,
                static_cast<const void*>(image->data.data()));
  return text;
}

}  // namespace

Result<std::unique_ptr<CameraSensor>> CameraSensor::make(const ros::NodeHandle& handle,
                                                         const ros_params::CameraInterfaceParams& params,
                                                         const RobotModel& robot, std::uint64_t seed,
                                                         const TruthClasses& classes) {
  const auto link = robot.link(kCameraFrame);
  if (!link)
    return fail(ErrorCode::kNotFound, std::string("the robot has no link ") + kCameraFrame +
                                          ": add it to the URDF, or set camera/enabled to false");
  return std::unique_ptr<CameraSensor>(new CameraSensor(handle, params, *link, seed, classes));
}

CameraSensor::CameraSensor(const ros::NodeHandle& handle, const ros_params::CameraInterfaceParams& params,
                           int link, std::uint64_t seed, const TruthClasses& classes)
    : params_(params), link_(link), classes_(classes), transport_(handle), faults_(seed) {
  ros::NodeHandle nh = handle;
  color_publisher_ = transport_.advertise("camera/color/image_raw", 2);
  depth_publisher_ = transport_.advertise("camera/aligned_depth_to_color/image_raw", 2);
  labels_publisher_ = transport_.advertise("sim/truth/labels", 2);
  color_info_publisher_ = nh.advertise<sensor_msgs::CameraInfo>("camera/color/camera_info", 2);
  depth_info_publisher_ =
      nh.advertise<sensor_msgs::CameraInfo>("camera/aligned_depth_to_color/camera_info", 2);
  detections_publisher_ = nh.advertise<vision_msgs::Detection2DArray>("sim/truth/detections", 2);
}

bool CameraSensor::images_wanted() const {
  return color_publisher_.getNumSubscribers() > 0 || depth_publisher_.getNumSubscribers() > 0 ||
         labels_publisher_.getNumSubscribers() > 0 || detections_publisher_.getNumSubscribers() > 0;
}

bool CameraSensor::wanted() const {
  return images_wanted() || color_info_publisher_.getNumSubscribers() > 0 ||
         depth_info_publisher_.getNumSubscribers() > 0;
}

bool CameraSensor::measure(simulate::SensorRig& rig, const SensorJob& job) {
  std_msgs::Header header;
  header.stamp = job.stamp;
  header.frame_id = kCameraFrame;
  const bool wanted = images_wanted();
  if (wanted && !faults_.frozen(job.faults)) {
    rig.camera(params_.camera, job.now->world_T_link[static_cast<std::size_t>(link_)], images_);
    const std::lock_guard lock(last_mutex_);
    ++rendered_;
  }
  if (wanted) publish_truth(rig, header);
  if (wanted && faults_.apply(job.faults, job.now->time_s, images_) == Fate::kLost) return false;
  const auto info =
      boost::make_shared<sensor_msgs::CameraInfo>(ros_convert::to_camera_info(params_.camera.model, header));
  color_info_publisher_.publish(info);
  depth_info_publisher_.publish(info);
  if (wanted) publish_images(header);
  return true;
}

void CameraSensor::publish_truth(simulate::SensorRig& rig, const std_msgs::Header& header) {
  if (labels_publisher_.getNumSubscribers() > 0)
    labels_publisher_.publish(to_image(header, images_, images_.instance));
  if (detections_publisher_.getNumSubscribers() == 0) return;
  Detections boxes;
  for (const auto& box : visible_boxes(images_, rig.instances(), params_.min_visible_px)) {
    const int id = classes_.id(rig.instances()[static_cast<std::size_t>(box.instance)].label);
    if (id < 0) continue;
    boxes.push_back({id,
                     1.0F,
                     {static_cast<float>(box.x_min), static_cast<float>(box.y_min),
                      static_cast<float>(box.x_max + 1), static_cast<float>(box.y_max + 1)}});
  }
  detections_publisher_.publish(
      boost::make_shared<vision_msgs::Detection2DArray>(ros_convert::to_message(boxes, header)));
}

sensor_msgs::ImagePtr CameraSensor::depth_message(const std_msgs::Header& header) const {
  if (params_.depth_encoding == encodings::TYPE_16UC1) return to_image(header, images_, images_.depth_mm);
  auto message = empty_image(header, images_, encodings::TYPE_32FC1.c_str(), 4);
  std::vector<float> metres(images_.depth_mm.size());
  for (std::size_t i = 0; i < metres.size(); ++i)
    metres[i] = images_.depth_mm[i] == 0 ? std::numeric_limits<float>::quiet_NaN()
                                         : 1e-3F * static_cast<float>(images_.depth_mm[i]);
  message->data.resize(sizeof(float) * metres.size());
  std::memcpy(message->data.data(), metres.data(), message->data.size());
  return message;
}

/// Depth before colour, so that it waits for the detections and not they for it.
void CameraSensor::publish_images(const std_msgs::Header& header) {
  sensor_msgs::ImagePtr depth;
  sensor_msgs::ImagePtr color;
  if (depth_publisher_.getNumSubscribers() > 0) depth_publisher_.publish(depth = depth_message(header));
  if (color_publisher_.getNumSubscribers() > 0) {
    color = empty_image(header, images_, encodings::RGB8.c_str(), 3);
    color->data = images_.rgb;
    color_publisher_.publish(color);
  }
  const std::lock_guard lock(last_mutex_);
  if (color) last_color_ = color;
  if (depth) last_depth_ = depth;
}

std::vector<std::pair<std::string, std::string>> CameraSensor::details() const {
  const std::lock_guard lock(last_mutex_);
  return {{"images rendered", std::to_string(rendered_)},
          {"color last", place_of(last_color_)},
          {"depth last", place_of(last_depth_)}};
}

}  // namespace extperfc::ros_simulate
