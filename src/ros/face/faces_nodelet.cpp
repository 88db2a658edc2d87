#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <boost/make_shared.hpp>
#include <extperfc/FaceArray.h>
#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>
#include <ros/package.h>
#include <visualization_msgs/MarkerArray.h>

#include "extperfc/base/latest_slot.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/face/recognizer.hpp"

#include "ros/convert/faces.hpp"
#include "ros/convert/image.hpp"
#include "ros/face/enroll_service.hpp"
#include "ros/face/face_locator.hpp"
#include "ros/face/shared_gallery.hpp"
#include "ros/health/reporter.hpp"
#include "ros/health/stream_health.hpp"
#include "ros/params/faces_params.hpp"

namespace extperfc::ros_face {

/// Finds faces in colour images, says where they are, and names those that were enrolled. The newest image
/// replaces one that waits for the networks.
///
/// Subscribes (only while one of the outputs has subscribers, or while enroll waits):
///   camera/color/image_raw                   sensor_msgs/Image: encodings as of the detector
///   camera/aligned_depth_to_color/image_raw  sensor_msgs/Image, 16UC1 [mm] or 32FC1 [m], aligned to colour; only with
///                                            use_depth
///   camera/color/camera_info                 sensor_msgs/CameraInfo of the colour camera; only with use_depth
/// Publishes:
///   faces          extperfc/FaceArray, one for each image that was processed, with its stamp
///   faces/markers  visualization_msgs/MarkerArray: names at the positions
///   faces/image    sensor_msgs/Image, bgr8: image with boxes and names, drawn only while it has subscribers
///   diagnostics    diagnostic_msgs/DiagnosticArray
/// Parameters: config/faces.yaml.
/// Parts: EnrollService.
/// Frames: needs optical frame -> target_frame at the image's stamp when target_frame is set.
/// Diagnostics: model, embedder, number of names, faces, rates, latency, drops, how images arrive; WARN while
/// positions
///   are missing and why, ERROR while images are refused.
/// Threads: callbacks only store messages; one worker runs the networks; one serves the requests.
class FacesNodelet : public nodelet::Nodelet {
 public:
  ~FacesNodelet() override {
    reporter_.reset();
    {
      const std::lock_guard lock(subscription_mutex_);
      closing_ = true;  // a listener that comes or goes now must not subscribe again
    }
    for (auto* subscriber : {&image_subscriber_, &depth_subscriber_, &info_subscriber_})
      subscriber->shutdown();
    images_.close();
    if (locator_) locator_->close();
    if (worker_.joinable()) worker_.join();
    enroll_.reset();
  }

 private:
  using ImageEvent = ros::MessageEvent<const sensor_msgs::Image>;
  using InfoEvent = ros::MessageEvent<const sensor_msgs::CameraInfo>;
  using Positions = std::vector<std::optional<Eigen::Vector3d>>;
  static constexpr const char* kImageTopic = "camera/color/image_raw";
  static constexpr const char* kDepthTopic = "camera/aligned_depth_to_color/image_raw";
  static constexpr const char* kInfoTopic = "camera/color/camera_info";
  static constexpr std::uint32_t kQueue = 5;

  void onInit() override;
  void load();
  [[nodiscard]] face::IdentifyParams identify_params() const;
  void advertise();
  void update_subscription();
  void subscribe();
  void on_image(const ImageEvent& event);
  void on_depth(const ImageEvent& event);
  void on_info(const InfoEvent& event);
  void process(const sensor_msgs::ImageConstPtr& message);
  [[nodiscard]] Positions positions_of(const std_msgs::Header& header,
                                       const std::vector<face::DescribedFace>& faces);
  [[nodiscard]] std::vector<ros_convert::NamedFace> named(const std::vector<face::DescribedFace>& faces,
                                                          const Positions& positions) const;
  void publish(const std_msgs::Header& header, const ros_convert::SharedImage& image,
               const std::vector<ros_convert::NamedFace>& faces);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros_params::FacesParams params_;
  std::optional<face::Recognizer> recognizer_;  ///< of the worker
  std::unique_ptr<SharedGallery> gallery_;
  std::optional<FaceLocator> locator_;  ///< only with use_depth
  std::optional<EnrollService> enroll_;
  std::optional<ros_health::Reporter> reporter_;
  ros_health::InputHealth image_health_{"image"};
  ros_health::InputHealth depth_health_{"depth"};
  ros_health::InputHealth info_health_{"camera info"};
  ros_health::WorkHealth work_health_;

  std::mutex subscription_mutex_;
  bool closing_{false};
  ros::Publisher faces_publisher_;
  ros::Publisher markers_publisher_;
  ros::Publisher image_publisher_;
  ros::Subscriber image_subscriber_;
  ros::Subscriber depth_subscriber_;
  ros::Subscriber info_subscriber_;
  ros::Time taken_;  ///< of the image callback: stamp of the latest image that was looked at

  std::mutex state_mutex_;  ///< guards what follows
  std::uint64_t faces_{0};
  std::uint64_t named_{0};
  std::uint64_t without_position_{0};
  std::string no_position_reason_;  ///< of the latest image; empty: there is none

  LatestSlot<sensor_msgs::ImageConstPtr> images_;
  std::thread worker_;
};

void FacesNodelet::onInit() {
  load();
  worker_ = std::thread([this] {
    while (const auto image = images_.take()) process(*image);
  });
  advertise();
  reporter_.emplace(getNodeHandle(), getPrivateNodeHandle(), getName());
  reporter_->add("faces", [this](auto& status) { report(status); });
  reporter_->start();
}

/// Everything that can be refused is refused here, before anything is advertised.
void FacesNodelet::load() {
  const auto give_up = [this](const Error& error) {
    NODELET_FATAL("%s", error.message.c_str());
    throw std::runtime_error(error.message);
  };
  auto params = ros_params::load_faces_params(getPrivateNodeHandle());
  if (!params) give_up(params.error());
  params_ = *params;
  auto spec = detect::load_model_spec(params_.model, ros::package::getPath("extperfc") + "/config/models");
  if (!spec) give_up(spec.error());
  auto& thresholds = spec->thresholds;
  if (params_.score_threshold >= 0.0) thresholds.score = static_cast<float>(params_.score_threshold);
  if (params_.nms_iou >= 0.0) thresholds.nms_iou = static_cast<float>(params_.nms_iou);
  if (params_.max_faces > 0) thresholds.max_detections = params_.max_faces;
  auto detector = face::FaceDetector::create(*spec, params_.inference);
  if (!detector) give_up(detector.error());
  Result<std::unique_ptr<face::FaceEmbedder>> embedder =
      params_.embedder == "lbp" ? face::make_lbp_embedder()
                                : face::make_network_embedder(params_.embedder, params_.inference);
  if (!embedder) give_up(embedder.error());
  auto gallery = SharedGallery::open(params_.gallery, {(*embedder)->identity(), (*embedder)->size(),
                                                       static_cast<std::size_t>(params_.max_features)});
  if (!gallery) give_up(gallery.error());
  gallery_ = std::move(*gallery);
  recognizer_.emplace(std::move(*detector), std::move(*embedder), static_cast<float>(params_.min_face_px));
  if (params_.use_depth) locator_.emplace(params_);
  NODELET_INFO("faces by %s, names by %s", recognizer_->detector().execution().c_str(),
               recognizer_->embedder().execution().c_str());
}

face::IdentifyParams FacesNodelet::identify_params() const {
  const auto& embedder = recognizer_->embedder();
  return {params_.threshold >= 0.0 ? static_cast<float>(params_.threshold) : embedder.default_threshold(),
          params_.margin >= 0.0 ? static_cast<float>(params_.margin) : embedder.default_margin()};
}

void FacesNodelet::advertise() {
  const std::lock_guard lock(subscription_mutex_);  // the callbacks must not run before all publishers exist
  const auto changed = [this](const ros::SingleSubscriberPublisher&) { update_subscription(); };
  auto& nh = getNodeHandle();
  faces_publisher_ = nh.advertise<FaceArray>("faces", 5, changed, changed);
  markers_publisher_ = nh.advertise<visualization_msgs::MarkerArray>("faces/markers", 2, changed, changed);
  image_publisher_ = nh.advertise<sensor_msgs::Image>("faces/image", 2, changed, changed);
  enroll_.emplace(
      getPrivateNodeHandle(), *gallery_,
      EnrollParams{params_.enroll_samples, params_.enroll_interval_s, identify_params().threshold},
      [this] { update_subscription(); });
}

void FacesNodelet::update_subscription() {
  const std::lock_guard lock(subscription_mutex_);
  if (closing_ || !enroll_) return;
  const bool wanted = faces_publisher_.getNumSubscribers() > 0 ||
                      markers_publisher_.getNumSubscribers() > 0 ||
                      image_publisher_.getNumSubscribers() > 0 || enroll_->is_waiting();
  image_health_.listening(wanted);
  depth_health_.listening(wanted && params_.use_depth);
  info_health_.listening(wanted && params_.use_depth);
  if (!wanted)
    for (auto* subscriber : {&image_subscriber_, &depth_subscriber_, &info_subscriber_})
      subscriber->shutdown();
  else if (!image_subscriber_)
    subscribe();
}

void FacesNodelet::subscribe() {
  auto& nh = getNodeHandle();
  if (params_.use_depth) {
    info_subscriber_ = nh.subscribe(kInfoTopic, 1, &FacesNodelet::on_info, this);
    depth_subscriber_ = nh.subscribe(kDepthTopic, kQueue, &FacesNodelet::on_depth, this);
  }
  image_subscriber_ = nh.subscribe(kImageTopic, kQueue, &FacesNodelet::on_image, this);
}

void FacesNodelet::on_image(const ImageEvent& event) {
  const auto& message = event.getConstMessage();
  image_health_.received(message->header.stamp, message->data.data(), ros_health::came_by_pointer(event));
  const double since_s = std::abs((message->header.stamp - taken_).toSec());
  if (params_.max_rate_hz > 0.0 && since_s * params_.max_rate_hz < 1.0) return;
  taken_ = message->header.stamp;
  images_.put(message);
}

void FacesNodelet::on_depth(const ImageEvent& event) {
  const auto& message = event.getConstMessage();
  depth_health_.received(message->header.stamp, message->data.data(), ros_health::came_by_pointer(event));
  locator_->on_depth(message);
}

void FacesNodelet::on_info(const InfoEvent& event) {
  const auto& message = event.getConstMessage();
  info_health_.received(message->header.stamp, message.get(), ros_health::came_by_pointer(event));
  locator_->on_info(message);
}

void FacesNodelet::process(const sensor_msgs::ImageConstPtr& message) {
  const Stopwatch watch;
  const auto image = ros_convert::share_image(message);
  const auto faces = image ? recognizer_->describe(image->view) : tl::unexpected(image.error());
  if (!faces) {
    if (work_health_.failed(faces.error().message))
      NODELET_ERROR("refused an image: %s", faces.error().message.c_str());
    return;
  }
  const auto positions = positions_of(message->header, *faces);
  enroll_->offer(message->header.stamp, *faces, positions);
  publish(message->header, *image, named(*faces, positions));
  work_health_.done(watch.milliseconds(), ros_health::age_ms(message->header.stamp));
}

/// Empty without use_depth, and while positions cannot be had.
FacesNodelet::Positions FacesNodelet::positions_of(const std_msgs::Header& header,
                                                   const std::vector<face::DescribedFace>& faces) {
  if (!locator_) return {};
  std::vector<Box2> boxes;
  boxes.reserve(faces.size());
  for (const auto& described : faces) boxes.push_back(described.face.box);
  const auto positions = boxes.empty() ? Positions{} : locator_->locate(header, boxes);
  const std::lock_guard lock(state_mutex_);
  no_position_reason_ = positions ? "" : positions.error().message;
  return positions.value_or(Positions{});
}

std::vector<ros_convert::NamedFace> FacesNodelet::named(const std::vector<face::DescribedFace>& faces,
                                                        const Positions& positions) const {
  std::vector<ros_convert::NamedFace> named;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    auto& one = named.emplace_back();
    one.face = faces[i].face;
    if (faces[i].feature) one.identity = gallery_->identify(*faces[i].feature, identify_params());
    if (i < positions.size()) one.position_m = positions[i];
  }
  return named;
}

void FacesNodelet::publish(const std_msgs::Header& header, const ros_convert::SharedImage& image,
                           const std::vector<ros_convert::NamedFace>& faces) {
  {
    const std::lock_guard lock(state_mutex_);
    for (const auto& one : faces) {
      ++faces_;
      named_ += one.identity.name.empty() ? 0 : 1;
      without_position_ += one.position_m ? 0 : 1;
    }
  }
  auto target = header;
  if (params_.use_depth && !params_.target_frame.empty()) target.frame_id = params_.target_frame;
  const auto message = ros_convert::to_message(faces, target);
  faces_publisher_.publish(message);
  if (markers_publisher_.getNumSubscribers() > 0)
    markers_publisher_.publish(boost::make_shared<visualization_msgs::MarkerArray>(
        ros_convert::to_markers(*message, params_.marker_lifetime_s)));
  if (image_publisher_.getNumSubscribers() == 0) return;
  if (const auto annotated = ros_convert::annotate(image, faces))
    image_publisher_.publish(*annotated);
  else
    NODELET_WARN_THROTTLE(10.0, "%s", annotated.error().message.c_str());
}

void FacesNodelet::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  status.summary(DiagnosticStatus::OK, "running");
  status.add("model", recognizer_->detector().spec().name);
  status.add("executes", recognizer_->detector().execution());
  status.add("embedder", recognizer_->embedder().execution());
  status.add("names", gallery_->names().size());
  status.add("dropped", images_.dropped());
  auto& nh = getNodeHandle();
  image_health_.report(status, nh.resolveName(kImageTopic), params_.timeout_s);
  if (params_.use_depth) {
    depth_health_.report(status, nh.resolveName(kDepthTopic), params_.timeout_s);
    info_health_.report(status, nh.resolveName(kInfoTopic), params_.timeout_s);
  }
  work_health_.report(status);
  const std::lock_guard lock(state_mutex_);
  status.add("faces", faces_);
  status.add("faces with a name", named_);
  status.add("faces without a position", without_position_);
  if (!no_position_reason_.empty())
    status.mergeSummary(DiagnosticStatus::WARN, "no positions: " + no_position_reason_);
}

}  // namespace extperfc::ros_face

PLUGINLIB_EXPORT_CLASS(extperfc::ros_face::FacesNodelet, nodelet::Nodelet)
