#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>
#include <vision_msgs/VisionInfo.h>

#include "extperfc/base/latest_slot.hpp"
#include "extperfc/base/stamp_matcher.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/depth/locate_boxes.hpp"
#include "extperfc/world/class_filter.hpp"

#include "ros/convert/detections.hpp"
#include "ros/convert/geometry.hpp"
#include "ros/convert/image.hpp"
#include "ros/depth/detect_and_locate_service.hpp"
#include "ros/depth/object_clouds.hpp"
#include "ros/health/reporter.hpp"
#include "ros/health/stream_health.hpp"
#include "ros/params/box_depth_params.hpp"
#include "ros/params/detector_params.hpp"
#include "ros/params/reconfigure.hpp"

namespace extperfc::ros_depth {

/// Computes a 3D position for every detected box from the depth image of the same stamp. Boxes without a
/// valid depth are left out and counted in diagnostics.
///
/// Subscribes (only while enabled and one of the outputs has subscribers, or while detect_once waits):
///   detections                               vision_msgs/Detection2DArray
///   camera/aligned_depth_to_color/image_raw  sensor_msgs/Image, 16UC1 [mm] or 32FC1 [m], aligned to colour
///   camera/color/camera_info                 sensor_msgs/CameraInfo of the colour camera
///   vision_info                              vision_msgs/VisionInfo: class names for the markers
/// Publishes:
///   detections_3d          vision_msgs/Detection3DArray, stamp of the detections: results[0].pose and
///                          bbox.center are both the estimated centre of the object, the first with its
///                          covariance; bbox.size is the estimated extent
///   detections_3d/surface  vision_msgs/Detection3DArray, the same objects in the same order with the same
///                          header: results[0].pose and bbox.center are both the measured point of the
///                          visible surface behind the middle of the box (the paper's result), the first with
///                          its covariance; bbox.size is 0
///   objects/markers        visualization_msgs/MarkerArray
///   diagnostics            diagnostic_msgs/DiagnosticArray
///   ~parameter_descriptions, ~parameter_updates  dynamic_reconfigure/ConfigDescription and Config, latched
/// Services:
///   detect_once      extperfc/DetectOnce: boxes and positions in the given image with its depth, or in the
///                    next image of the camera; also while continuous work is disabled here or in the detector
///   object_cloud     extperfc/ObjectCloud: points of one of the latest objects, without background; with a
///                    target_frame also without what the object stands on
///   ~set_parameters  dynamic_reconfigure/Reconfigure: changes enabled, min_score, class_filter, estimator,
///                    window_px, central_fraction, min_depth_m, max_depth_m and min_valid_px; wrong values are
///                    refused with a message in the log and in diagnostics
/// Calls:
///   detector/detect_once  extperfc/DetectOnce: for boxes of detect_once
/// Parameters: config/box_depth.yaml.
/// Frames: needs optical frame -> target_frame at the image's stamp when target_frame is set.
/// Diagnostics: rates, latency, how images arrive, boxes without depth, results without a matching image;
///   WARN when a change of parameters was refused, ERROR while inputs do not fit together (sizes, encodings,
///   stamps, transforms); says when it is disabled.
/// Threads: callbacks only match stamps; one worker computes, one serves detect_once. The newest matched pair
///   replaces a waiting one.
class BoxDepthNodelet : public nodelet::Nodelet {
 public:
  ~BoxDepthNodelet() override {
    reporter_.reset();
    reconfigure_.reset();
    cloud_server_.shutdown();
    {
      const std::lock_guard lock(subscription_mutex_);
      closing_ = true;  // a listener that comes or goes now must not subscribe again
    }
    for (auto* subscriber :
         {&detections_subscriber_, &depth_subscriber_, &info_subscriber_, &names_subscriber_})
      subscriber->shutdown();
    once_.reset();
    pairs_.close();
    if (worker_.joinable()) worker_.join();
  }

 private:
  // Events instead of plain messages, because they know their publisher.
  using DetectionsEvent = ros::MessageEvent<const vision_msgs::Detection2DArray>;
  using DepthEvent = ros::MessageEvent<const sensor_msgs::Image>;
  using InfoEvent = ros::MessageEvent<const sensor_msgs::CameraInfo>;
  using Matcher = StampMatcher<vision_msgs::Detection2DArrayConstPtr, sensor_msgs::ImageConstPtr>;
  static constexpr const char* kDetectionsTopic = "detections";
  static constexpr const char* kDepthTopic = "camera/aligned_depth_to_color/image_raw";
  static constexpr const char* kInfoTopic = "camera/color/camera_info";

  struct Objects {
    vision_msgs::Detection3DArray centers;
    vision_msgs::Detection3DArray surface;  ///< in the same order
  };

  /// What may change at run time.
  struct Settings {
    bool enabled{true};
    double min_score{0};
    std::string class_filter;
    depth::BoxDepthParams estimate;
  };

  void onInit() override;
  void advertise();
  void offer_services();
  Result<void> apply(const ros_params::BoxDepthNodeletParams& params);
  Result<void> reconfigure();
  [[nodiscard]] Settings settings();
  bool serve_cloud(ObjectCloud::Request& request, ObjectCloud::Response& response);
  void update_subscription();
  void subscribe_to_camera();
  void on_detections(const DetectionsEvent& event);
  void on_depth(const DepthEvent& event);
  void on_info(const InfoEvent& event);
  void on_names(const vision_msgs::VisionInfoConstPtr& message);
  void process(const Matcher::Pair& pair);
  Result<Objects> locate_all(const Matcher::Pair& pair, const sensor_msgs::CameraInfoConstPtr& info);
  Result<Detections> of_interest(const vision_msgs::Detection2DArray& message, const Settings& settings);
  [[nodiscard]] sensor_msgs::CameraInfoConstPtr latest_info();
  [[nodiscard]] depth::ShapesToFit shapes_to_fit(const Eigen::Isometry3d& target_T_optical);
  [[nodiscard]] std::vector<std::string> class_names();
  Result<CameraModel> camera_for(const ImageView& depth, const sensor_msgs::CameraInfoConstPtr& info);
  Result<Eigen::Isometry3d> transform_at(const std_msgs::Header& header);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);
  [[nodiscard]] Matcher::Limits limits() const;

  ros_params::BoxDepthNodeletParams params_;  ///< of the start
  std::unique_ptr<tf2_ros::Buffer> tf_buffer_;
  std::unique_ptr<tf2_ros::TransformListener> tf_listener_;
  std::optional<ros_health::Reporter> reporter_;
  ros_health::InputHealth detections_health_{"detections"};
  ros_health::InputHealth depth_health_{"depth"};
  ros_health::InputHealth info_health_{"camera info"};
  ros_health::WorkHealth work_health_;

  std::mutex subscription_mutex_;
  bool closing_{false};
  ros::Publisher objects_publisher_;
  ros::Publisher surface_publisher_;
  ros::Publisher markers_publisher_;
  ros::Subscriber detections_subscriber_;
  ros::Subscriber depth_subscriber_;
  ros::Subscriber info_subscriber_;
  ros::Subscriber names_subscriber_;

  std::mutex state_mutex_;  ///< guards what follows, never held over work or a publish
  Settings settings_;
  std::optional<Matcher> matcher_;
  sensor_msgs::CameraInfoConstPtr info_;
  std::vector<std::string> class_names_;
  std::uint64_t without_depth_{0};
  std::uint64_t not_fitted_{0};
  std::uint64_t unmatched_at_report_{0};

  LatestSlot<Matcher::Pair> pairs_;
  std::thread worker_;
  std::optional<ObjectClouds> clouds_;
  ros::ServiceServer cloud_server_;
  std::optional<DetectAndLocateService> once_;
  std::optional<ros_params::Reconfigure> reconfigure_;
};

void BoxDepthNodelet::onInit() {
  auto params = ros_params::load_box_depth_params(getPrivateNodeHandle());
  if (!params) {
    NODELET_FATAL("%s", params.error().message.c_str());
    throw std::runtime_error(params.error().message);
  }
  params_ = *params;
  if (auto applied = apply(params_); !applied) throw std::runtime_error(applied.error().message);
  matcher_.emplace(limits());
  clouds_.emplace(static_cast<std::size_t>(params_.cloud_history));
  if (!params_.target_frame.empty()) {
    tf_buffer_ = std::make_unique<tf2_ros::Buffer>();
    tf_listener_ = std::make_unique<tf2_ros::TransformListener>(*tf_buffer_);
  }
  worker_ = std::thread([this] {
    while (const auto pair = pairs_.take()) process(*pair);
  });
  offer_services();
  advertise();
  reporter_.emplace(getNodeHandle(), getPrivateNodeHandle(), getName());
  reporter_->add("box_depth", [this](auto& status) { report(status); });
  reporter_->start();
}

BoxDepthNodelet::Matcher::Limits BoxDepthNodelet::limits() const {
  Matcher::Limits limits;
  limits.tolerance_ns = static_cast<std::int64_t>(1e9 * params_.stamp_tolerance_s);
  limits.fast_kept = static_cast<std::size_t>(params_.depth_queue);
  return limits;
}

void BoxDepthNodelet::offer_services() {
  cloud_server_ = getNodeHandle().advertiseService("object_cloud", &BoxDepthNodelet::serve_cloud, this);
  once_.emplace(getNodeHandle(), limits(),
                DetectAndLocateService::Callbacks{
                    [this] { update_subscription(); },
                    [this](const Matcher::Pair& pair, const sensor_msgs::CameraInfoConstPtr& info) {
                      return locate_all(pair, info ? info : latest_info()).map([](Objects&& objects) {
                        return std::move(objects.centers);
                      });
                    }});
  reconfigure_.emplace(
      getPrivateNodeHandle(), params_.read,
      std::vector<ros_params::DynamicParam>{
          {"enabled", "compute continuously while there are subscribers", {}},
          {"min_score", "boxes with a lower score are left out", {}},
          {"class_filter", "names or indices of classes, between commas; empty: all", {}},
          {"estimator", "of the depth of a box", {"nearest_mode", "median", "trimmed_mean", "mean"}},
          {"window_px", "side of the window of mean, median and trimmed_mean [px]", {}},
          {"central_fraction", "part of the box that nearest_mode looks at", {}},
          {"min_depth_m", "nearer values are ignored [m]", {}},
          {"max_depth_m", "farther values are ignored [m]", {}},
          {"min_valid_px", "with fewer valid pixels there is no estimate", {}}},
      [this] { return reconfigure(); });
}

/// Takes over what may change at run time. The names of a class filter can be checked only when the detector
/// has published them.
Result<void> BoxDepthNodelet::apply(const ros_params::BoxDepthNodeletParams& params) {
  if (const auto names = class_names(); !names.empty())
    if (auto classes = ClassFilter::make(params.class_filter, names); !classes)
      return tl::unexpected(classes.error());
  const std::lock_guard lock(state_mutex_);
  settings_ = {params.enabled, params.min_score, params.class_filter, params.estimate};
  return {};
}

Result<void> BoxDepthNodelet::reconfigure() {
  const auto params = ros_params::load_box_depth_params(getPrivateNodeHandle());
  if (!params) return tl::unexpected(params.error());
  if (auto applied = apply(*params); !applied) return applied;
  update_subscription();
  return {};
}

BoxDepthNodelet::Settings BoxDepthNodelet::settings() {
  const std::lock_guard lock(state_mutex_);
  return settings_;
}

bool BoxDepthNodelet::serve_cloud(ObjectCloud::Request& request, ObjectCloud::Response& response) {
  auto cloud = clouds_->cloud_of(request);
  response.success = cloud.has_value();
  if (cloud)
    response.cloud = std::move(*cloud);
  else
    response.message = cloud.error().message;
  return true;
}

void BoxDepthNodelet::advertise() {
  const std::lock_guard lock(subscription_mutex_);  // the callbacks must not run before all publishers exist
  const auto changed = [this](const ros::SingleSubscriberPublisher&) { update_subscription(); };
  auto& nh = getNodeHandle();
  objects_publisher_ = nh.advertise<vision_msgs::Detection3DArray>("detections_3d", 5, changed, changed);
  surface_publisher_ =
      nh.advertise<vision_msgs::Detection3DArray>("detections_3d/surface", 5, changed, changed);
  markers_publisher_ = nh.advertise<visualization_msgs::MarkerArray>("objects/markers", 2, changed, changed);
}

void BoxDepthNodelet::update_subscription() {
  const std::lock_guard lock(subscription_mutex_);
  if (closing_) return;
  const bool streams = settings().enabled && (objects_publisher_.getNumSubscribers() > 0 ||
                                              surface_publisher_.getNumSubscribers() > 0 ||
                                              markers_publisher_.getNumSubscribers() > 0);
  for (auto* input : {&detections_health_, &depth_health_, &info_health_}) input->listening(streams);
  if (!streams) detections_subscriber_.shutdown();
  if (!streams && !once_->is_waiting())
    for (auto* subscriber : {&depth_subscriber_, &info_subscriber_, &names_subscriber_})
      subscriber->shutdown();
  else if (!depth_subscriber_)
    subscribe_to_camera();
  if (streams && !detections_subscriber_)
    detections_subscriber_ =
        getNodeHandle().subscribe(kDetectionsTopic, 5, &BoxDepthNodelet::on_detections, this);
}

void BoxDepthNodelet::subscribe_to_camera() {
  auto& nh = getNodeHandle();
  names_subscriber_ = nh.subscribe("vision_info", 1, &BoxDepthNodelet::on_names, this);
  info_subscriber_ = nh.subscribe(kInfoTopic, 1, &BoxDepthNodelet::on_info, this);
  depth_subscriber_ = nh.subscribe(kDepthTopic, 5, &BoxDepthNodelet::on_depth, this);
}

void BoxDepthNodelet::on_detections(const DetectionsEvent& event) {
  const auto& message = event.getConstMessage();
  detections_health_.received(message->header.stamp, message.get(), ros_health::came_by_pointer(event));
  std::optional<Matcher::Pair> pair;
  {
    const std::lock_guard lock(state_mutex_);
    pair = matcher_->add_slow(static_cast<std::int64_t>(message->header.stamp.toNSec()), message);
  }
  if (pair) pairs_.put(std::move(*pair));
}

void BoxDepthNodelet::on_depth(const DepthEvent& event) {
  const auto& message = event.getConstMessage();
  depth_health_.received(message->header.stamp, message->data.data(), ros_health::came_by_pointer(event));
  once_->on_depth(message);
  std::optional<Matcher::Pair> pair;
  {
    const std::lock_guard lock(state_mutex_);
    pair = matcher_->add_fast(static_cast<std::int64_t>(message->header.stamp.toNSec()), message);
  }
  if (pair) pairs_.put(std::move(*pair));
}

void BoxDepthNodelet::on_info(const InfoEvent& event) {
  const auto& message = event.getConstMessage();
  info_health_.received(message->header.stamp, message.get(), ros_health::came_by_pointer(event));
  {
    const std::lock_guard lock(state_mutex_);
    info_ = message;
  }
  once_->on_info();
}

void BoxDepthNodelet::on_names(const vision_msgs::VisionInfoConstPtr& message) {
  auto names = ros_params::load_class_names(message->database_location);
  const std::lock_guard lock(state_mutex_);
  class_names_ = std::move(names);
}

void BoxDepthNodelet::process(const Matcher::Pair& pair) {
  const Stopwatch watch;
  auto objects = locate_all(pair, latest_info());
  if (!objects) {
    if (work_health_.failed(objects.error().message)) NODELET_ERROR("%s", objects.error().message.c_str());
    return;
  }
  const double work_ms = watch.milliseconds();
  const auto message = boost::make_shared<vision_msgs::Detection3DArray>(std::move(objects->centers));
  surface_publisher_.publish(boost::make_shared<vision_msgs::Detection3DArray>(std::move(objects->surface)));
  objects_publisher_.publish(message);
  work_health_.done(work_ms, ros_health::age_ms(message->header.stamp));
  if (markers_publisher_.getNumSubscribers() > 0)
    markers_publisher_.publish(boost::make_shared<visualization_msgs::MarkerArray>(
        ros_convert::to_markers(*message, class_names(), params_.marker_lifetime_s)));
}

Result<BoxDepthNodelet::Objects> BoxDepthNodelet::locate_all(const Matcher::Pair& pair,
                                                             const sensor_msgs::CameraInfoConstPtr& info) {
  const auto& [detections, depth_message] = pair;
  const auto depth = ros_convert::share_image(depth_message);
  if (!depth) return tl::unexpected(Error{depth.error().code, "depth: " + depth.error().message});
  if (!is_depth(depth->view.format))
    return fail(ErrorCode::kUnsupported, "depth: encoding '" + depth_message->encoding +
                                             "' is not depth; use 16UC1 [mm] or 32FC1 [m]");
  const auto camera = camera_for(depth->view, info);
  if (!camera) return tl::unexpected(camera.error());
  const auto target_T_optical = transform_at(depth_message->header);
  if (!target_T_optical) return tl::unexpected(target_T_optical.error());
  const auto now = settings();
  const auto boxes = of_interest(*detections, now);
  if (!boxes) return tl::unexpected(boxes.error());
  const auto located =
      depth::locate_boxes(*boxes, depth->view, *camera, now.estimate, shapes_to_fit(*target_T_optical));
  {
    const std::lock_guard lock(state_mutex_);
    without_depth_ += static_cast<std::uint64_t>(located.without_depth);
    not_fitted_ += static_cast<std::uint64_t>(located.not_fitted);
  }
  Objects objects;
  auto header = detections->header;
  if (!params_.target_frame.empty()) header.frame_id = params_.target_frame;
  objects.centers.header = objects.surface.header = header;
  LocatedImage image{header, depth_message, *camera, *target_T_optical, !params_.target_frame.empty(),
                     {},     now.estimate};
  for (const auto& [detection, object, fit] : located.boxes) {
    image.boxes.push_back(detection.box);
    objects.surface.detections.push_back(
        ros_convert::to_surface_message(detection, object, *target_T_optical, header));
    objects.centers.detections.push_back(
        fit ? ros_convert::to_message(detection, *fit, *target_T_optical, header)
            : ros_convert::to_message(detection, object, *target_T_optical, header));
  }
  clouds_->remember(std::move(image));
  return objects;
}

/// The boxes with the scores and classes that the parameters ask for.
Result<Detections> BoxDepthNodelet::of_interest(const vision_msgs::Detection2DArray& message,
                                                const Settings& settings) {
  const auto classes = ClassFilter::make(settings.class_filter, class_names());
  if (!classes) return tl::unexpected(classes.error());
  Detections boxes;
  for (const auto& detection : ros_convert::from_message(message))
    if (detection.score >= settings.min_score && classes->allows(detection.class_index))
      boxes.push_back(detection);
  return boxes;
}

depth::ShapesToFit BoxDepthNodelet::shapes_to_fit(const Eigen::Isometry3d& target_T_optical) {
  depth::ShapesToFit shapes;
  if (!params_.fit_objects) return shapes;
  shapes.up = target_T_optical.linear().transpose() * Eigen::Vector3d::UnitZ();
  for (const auto& name : class_names()) {
    const auto known = params_.shapes.find(name);
    shapes.of_class.push_back(known == params_.shapes.end() ? std::nullopt : std::optional(known->second));
  }
  return shapes;
}

std::vector<std::string> BoxDepthNodelet::class_names() {
  const std::lock_guard lock(state_mutex_);
  return class_names_;
}

sensor_msgs::CameraInfoConstPtr BoxDepthNodelet::latest_info() {
  const std::lock_guard lock(state_mutex_);
  return info_;
}

Result<CameraModel> BoxDepthNodelet::camera_for(const ImageView& depth,
                                                const sensor_msgs::CameraInfoConstPtr& info) {
  if (!info)
    return fail(ErrorCode::kNotFound, "no camera info on " + getNodeHandle().resolveName(kInfoTopic) +
                                          " yet: positions need intrinsics");
  auto camera = ros_convert::to_camera_model(*info);
  if (camera && (camera->width != depth.width || camera->height != depth.height))
    return fail(ErrorCode::kInvalidArgument,
                "camera info is for " + std::to_string(camera->width) + " x " +
                    std::to_string(camera->height) + " pixels, but the depth image has " +
                    std::to_string(depth.width) + " x " + std::to_string(depth.height) +
                    ": use depth aligned to colour, and the colour camera's info");
  return camera;
}

Result<Eigen::Isometry3d> BoxDepthNodelet::transform_at(const std_msgs::Header& header) {
  if (params_.target_frame.empty()) return Eigen::Isometry3d::Identity();
  try {
    return tf2::transformToEigen(tf_buffer_->lookupTransform(
        params_.target_frame, header.frame_id, header.stamp, ros::Duration(params_.transform_timeout_s)));
  } catch (const tf2::TransformException& error) {
    return fail(ErrorCode::kNotFound, "no transform from " + header.frame_id + " to " + params_.target_frame +
                                          " at the image's stamp; is tf published?");
  }
}

void BoxDepthNodelet::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const auto now = settings();
  status.summary(diagnostic_msgs::DiagnosticStatus::OK,
                 now.enabled ? "running" : "disabled: parameter enabled is false");
  status.add("enabled", now.enabled);
  status.add("estimator", depth::to_string(now.estimate.estimator));
  status.add("dropped", pairs_.dropped());
  auto& nh = getNodeHandle();
  detections_health_.report(status, nh.resolveName(kDetectionsTopic), params_.timeout_s);
  depth_health_.report(status, nh.resolveName(kDepthTopic), params_.timeout_s);
  info_health_.report(status, nh.resolveName(kInfoTopic), params_.timeout_s);
  work_health_.report(status);
  if (const auto refused = reconfigure_->last_refusal(); !refused.empty())
    status.mergeSummary(diagnostic_msgs::DiagnosticStatus::WARN,
                        "refused a change of parameters: " + refused);
  const std::lock_guard lock(state_mutex_);
  status.add("boxes without depth", without_depth_);
  if (params_.fit_objects) status.add("shapes that do not fit", not_fitted_);
  status.add("detections without a depth image", matcher_->unmatched());
  if (matcher_->unmatched() > unmatched_at_report_)
    status.mergeSummaryf(
        diagnostic_msgs::DiagnosticStatus::WARN,
        "%s has no image within %.3f s of the stamp of some detections: are both stamped by the same "
        "camera driver? raise stamp_tolerance_s if so",
        nh.resolveName(kDepthTopic).c_str(), params_.stamp_tolerance_s);
  unmatched_at_report_ = matcher_->unmatched();
}

}  // namespace extperfc::ros_depth

PLUGINLIB_EXPORT_CLASS(extperfc::ros_depth::BoxDepthNodelet, nodelet::Nodelet)
