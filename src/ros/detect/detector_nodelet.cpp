#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <image_transport/image_transport.h>
#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>
#include <ros/package.h>
#include <vision_msgs/Detection2DArray.h>
#include <vision_msgs/VisionInfo.h>

#include "extperfc/base/in_order.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/detect/detector.hpp"

#include "ros/convert/annotate.hpp"
#include "ros/convert/detections.hpp"
#include "ros/convert/image.hpp"
#include "ros/detect/detect_once_service.hpp"
#include "ros/detect/job_queue.hpp"
#include "ros/health/reporter.hpp"
#include "ros/health/stream_health.hpp"
#include "ros/params/detector_params.hpp"
#include "ros/params/reconfigure.hpp"

namespace extperfc::ros_detect {

/// Finds objects in a colour image with a neural network. The newest image replaces one that waits for the
/// network.
///
/// Subscribes (only while enabled and one of the outputs has subscribers, or while detect_once waits):
///   camera/color/image_raw  sensor_msgs/Image: rgb8, bgr8, rgba8, bgra8, mono8, mono16, bayer_*8, yuv422,
///                           yuv422_yuy2
/// Publishes:
///   detections        vision_msgs/Detection2DArray: stamp and frame of the image; id is the index of the
///                     class
///   detections/image  sensor_msgs/Image, bgr8: image with boxes, drawn only while it has subscribers
///   vision_info       vision_msgs/VisionInfo, latched: names the parameter that holds the class names
///   diagnostics       diagnostic_msgs/DiagnosticArray
///   ~parameter_descriptions, ~parameter_updates  dynamic_reconfigure/ConfigDescription and Config, latched
/// Services:
///   ~detect_once     extperfc/DetectOnce: boxes in the given image, or in the next one of the camera; also
///                    while continuous detection is disabled; without 3D results: for those see box_depth
///   ~set_parameters  dynamic_reconfigure/Reconfigure: changes enabled, score_threshold, nms_iou,
///                    max_detections and class_filter; wrong values are refused with a message in the log and
///                    in diagnostics
/// Parameters: config/detector.yaml. The nodelet writes the class names to the parameter `classes`.
/// Frames: none; boxes are in pixels.
/// Diagnostics: model, back end, rates, percentiles of work and latency, drops, how images arrive; WARN when
///   the topic is silent or a change of parameters was refused, ERROR while images are refused; says when
///   detection is disabled.
/// Threads: the callback only stores the image; one worker per back-end slot; one for detect_once.
class DetectorNodelet : public nodelet::Nodelet {
 public:
  ~DetectorNodelet() override {
    reporter_.reset();
    reconfigure_.reset();
    {
      const std::lock_guard lock(subscription_mutex_);
      closing_ = true;  // a listener that comes or goes now must not subscribe again
    }
    raw_subscriber_.shutdown();
    decoding_subscriber_.shutdown();
    jobs_.close();
    once_.reset();
    for (auto& worker : workers_) worker.join();
  }

 private:
  using ImageEvent = ros::MessageEvent<const sensor_msgs::Image>;
  static constexpr const char* kImageTopic = "camera/color/image_raw";
  /// More than ever wait, because the callback only stores a pointer: images are dropped, and counted, in
  /// one place.
  static constexpr std::uint32_t kQueue = 20;

  struct Ticketed {
    Job job;
    std::uint64_t ticket{0};
  };

  void onInit() override;
  void load();
  Result<void> select(const ros_params::DetectorParams& params);
  Result<void> reconfigure();
  [[nodiscard]] detect::Selection selection() const;
  [[nodiscard]] bool enabled() const;
  void advertise();
  void update_subscription();
  void on_image(const sensor_msgs::ImageConstPtr& message, bool by_pointer);
  void work(int slot);
  std::optional<Ticketed> next_job();
  void process(const Ticketed& next, int slot);
  void publish(const std_msgs::Header& header, const ros_convert::SharedImage& image,
               const detect::DetectorOutput& output, double work_ms);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros_params::DetectorParams params_;  ///< of the start
  std::optional<detect::Detector> detector_;
  ros_health::InputHealth input_{"image"};
  ros_health::WorkHealth work_health_;
  std::optional<ros_health::Reporter> reporter_;

  mutable std::mutex selection_mutex_;  ///< guards what follows: parameters that change at run time
  bool enabled_{true};
  detect::Selection selection_;

  std::mutex subscription_mutex_;
  bool closing_{false};
  std::unique_ptr<image_transport::ImageTransport> transport_;
  ros::Subscriber raw_subscriber_;                   ///< raw images: pointers inside one manager
  image_transport::Subscriber decoding_subscriber_;  ///< any other transport
  image_transport::Publisher annotated_publisher_;
  ros::Publisher detections_publisher_;
  ros::Publisher info_publisher_;

  JobQueue jobs_;
  std::mutex take_mutex_;  ///< an image and its ticket are taken together
  InOrder order_;
  std::vector<std::thread> workers_;
  std::optional<DetectOnceService> once_;
  std::optional<ros_params::Reconfigure> reconfigure_;
};

void DetectorNodelet::onInit() {
  load();
  for (int slot = 0; slot < detector_->slots(); ++slot) workers_.emplace_back([this, slot] { work(slot); });
  advertise();
  reporter_.emplace(getNodeHandle(), getPrivateNodeHandle(), getName());
  reporter_->add("detector", [this](auto& status) { report(status); });
  reporter_->start();
}

/// Everything that can be refused is refused here, before anything is advertised.
void DetectorNodelet::load() {
  const auto give_up = [this](const Error& error) {
    NODELET_FATAL("%s", error.message.c_str());
    throw std::runtime_error(error.message);
  };
  auto params = ros_params::load_detector_params(getPrivateNodeHandle());
  if (!params) give_up(params.error());
  params_ = *params;
  auto spec = detect::load_model_spec(params_.model, ros::package::getPath("extperfc") + "/config/models");
  if (!spec) give_up(spec.error());
  auto detector = detect::Detector::create(*spec, params_.inference);
  if (!detector) give_up(detector.error());
  detector_.emplace(std::move(*detector));
  if (auto selected = select(params_); !selected) give_up(selected.error());
  NODELET_INFO("model %s, %zu classes, runs on %s", detector_->spec().name.c_str(),
               detector_->spec().classes.size(), detector_->execution().c_str());
}

/// Takes over what may change at run time.
Result<void> DetectorNodelet::select(const ros_params::DetectorParams& params) {
  detect::Selection selection{detector_->spec().thresholds, {}};
  auto classes = ClassFilter::make(params.class_filter, detector_->spec().classes);
  if (!classes) return tl::unexpected(classes.error());
  selection.classes = std::move(*classes);
  if (params.score_threshold >= 0.0) selection.thresholds.score = static_cast<float>(params.score_threshold);
  if (params.nms_iou >= 0.0) selection.thresholds.nms_iou = static_cast<float>(params.nms_iou);
  if (params.max_detections > 0) selection.thresholds.max_detections = params.max_detections;
  const std::lock_guard lock(selection_mutex_);
  enabled_ = params.enabled;
  selection_ = std::move(selection);
  return {};
}

Result<void> DetectorNodelet::reconfigure() {
  const auto params = ros_params::load_detector_params(getPrivateNodeHandle());
  if (!params) return tl::unexpected(params.error());
  if (auto selected = select(*params); !selected) return selected;
  update_subscription();
  return {};
}

detect::Selection DetectorNodelet::selection() const {
  const std::lock_guard lock(selection_mutex_);
  return selection_;
}

bool DetectorNodelet::enabled() const {
  const std::lock_guard lock(selection_mutex_);
  return enabled_;
}

void DetectorNodelet::advertise() {
  auto& nh = getNodeHandle();
  ros_params::store_class_names(getPrivateNodeHandle(), detector_->spec().classes);
  info_publisher_ = nh.advertise<vision_msgs::VisionInfo>("vision_info", 1, true);
  vision_msgs::VisionInfo info;
  info.header.stamp = ros::Time::now();
  info.method = detector_->spec().name + ", " + detector_->execution();
  info.database_location = getPrivateNodeHandle().resolveName("classes");
  info_publisher_.publish(info);

  transport_ = std::make_unique<image_transport::ImageTransport>(nh);
  once_.emplace(getPrivateNodeHandle(),
                DetectOnceService::Callbacks{[this] { update_subscription(); },
                                             [this](Job job) { jobs_.put(std::move(job)); }});
  {
    const std::lock_guard lock(
        subscription_mutex_);  // the callbacks below must not run before all of this is set
    const auto changed = [this](const auto&) { update_subscription(); };
    detections_publisher_ = nh.advertise<vision_msgs::Detection2DArray>("detections", 5, changed, changed);
    annotated_publisher_ = transport_->advertise("detections/image", 5, changed, changed);
  }
  reconfigure_.emplace(
      getPrivateNodeHandle(), params_.read,
      std::vector<ros_params::DynamicParam>{
          {"enabled", "detect continuously while there are subscribers", {}},
          {"score_threshold", "smallest score; below 0: the model's own", {}},
          {"nms_iou", "overlap above which the worse of two boxes is left out; below 0: the model's own", {}},
          {"max_detections", "boxes per image, best first; 0: the model's own", {}},
          {"class_filter", "names or indices of classes, between commas; empty: all", {}}},
      [this] { return reconfigure(); });
}

void DetectorNodelet::update_subscription() {
  const std::lock_guard lock(subscription_mutex_);
  if (closing_) return;
  const bool streams = enabled() && (detections_publisher_.getNumSubscribers() > 0 ||
                                     annotated_publisher_.getNumSubscribers() > 0);
  const bool wanted = streams || once_->is_waiting();
  input_.listening(streams);
  if (!wanted) {
    raw_subscriber_.shutdown();
    decoding_subscriber_.shutdown();
  } else if (params_.image_transport == "raw") {
    if (!raw_subscriber_)
      raw_subscriber_ = getNodeHandle().subscribe<sensor_msgs::Image>(
          kImageTopic, kQueue, boost::function<void(const ImageEvent&)>([this](const ImageEvent& event) {
            on_image(event.getConstMessage(), ros_health::came_by_pointer(event));
          }));
  } else if (!decoding_subscriber_) {
    decoding_subscriber_ = transport_->subscribe(
        kImageTopic, kQueue, [this](const sensor_msgs::ImageConstPtr& message) { on_image(message, false); },
        {}, image_transport::TransportHints(params_.image_transport));
  }
}

void DetectorNodelet::on_image(const sensor_msgs::ImageConstPtr& message, bool by_pointer) {
  input_.received(message->header.stamp, message->data.data(), by_pointer);
  jobs_.put({message, enabled(), once_->take_waiting()});
}

void DetectorNodelet::work(int slot) {
  while (const auto next = next_job()) process(*next, slot);
}

std::optional<DetectorNodelet::Ticketed> DetectorNodelet::next_job() {
  const std::lock_guard lock(take_mutex_);
  auto job = jobs_.take();
  if (!job) return std::nullopt;
  return Ticketed{std::move(*job), order_.begin()};
}

void DetectorNodelet::process(const Ticketed& next, int slot) {
  const Job& job = next.job;
  const Stopwatch watch;
  const auto image = ros_convert::share_image(job.message);
  auto output = image ? detector_->detect(image->view, selection(), slot) : tl::unexpected(image.error());
  const double work_ms = watch.milliseconds();
  if (job.mailbox) job.mailbox->put({job.message->header, output});
  order_.finish(next.ticket, [&] {
    if (!job.publish) return;
    if (output) {
      publish(job.message->header, *image, *output, work_ms);
    } else if (work_health_.failed(output.error().message)) {
      NODELET_ERROR("refused an image: %s", output.error().message.c_str());
    }
  });
}

void DetectorNodelet::publish(const std_msgs::Header& header, const ros_convert::SharedImage& image,
                              const detect::DetectorOutput& output, double work_ms) {
  detections_publisher_.publish(
      boost::make_shared<vision_msgs::Detection2DArray>(ros_convert::to_message(output.detections, header)));
  work_health_.done(work_ms, ros_health::age_ms(header.stamp));
  if (annotated_publisher_.getNumSubscribers() == 0) return;
  if (auto annotated = ros_convert::annotate(image, output.detections, detector_->spec().classes)) {
    annotated_publisher_.publish(*annotated);
  } else {
    NODELET_WARN_THROTTLE(10.0, "%s", annotated.error().message.c_str());
  }
}

void DetectorNodelet::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  status.summary(DiagnosticStatus::OK, enabled() ? "running" : "disabled: parameter enabled is false");
  status.add("model", detector_->spec().name);
  status.add("executes", detector_->execution());
  status.add("enabled", enabled());
  status.add("dropped", jobs_.dropped());
  input_.report(status, getNodeHandle().resolveName(kImageTopic), params_.timeout_s);
  work_health_.report(status);
  if (const auto refused = reconfigure_->last_refusal(); !refused.empty())
    status.mergeSummary(DiagnosticStatus::WARN, "refused a change of parameters: " + refused);
}

}  // namespace extperfc::ros_detect

PLUGINLIB_EXPORT_CLASS(extperfc::ros_detect::DetectorNodelet, nodelet::Nodelet)
