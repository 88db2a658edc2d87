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
#include "extperfc/base/latest_slot.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/detect/detector.hpp"

#include "ros/convert/annotate.hpp"
#include "ros/convert/detections.hpp"
#include "ros/convert/image.hpp"
#include "ros/health/reporter.hpp"
#include "ros/health/stream_health.hpp"
#include "ros/params/detector_params.hpp"

namespace extperfc::ros_detect {

/// Finds objects in a colour image with a neural network. The newest image replaces one that waits for the
/// network.
///
/// Subscribes (only while one of the outputs has subscribers):
///   camera/color/image_raw  sensor_msgs/Image: rgb8, bgr8, rgba8, bgra8, mono8, mono16, bayer_*8, yuv422,
///                           yuv422_yuy2
/// Publishes:
///   detections        vision_msgs/Detection2DArray: stamp and frame of the image; id is the index of the
///                     class
///   detections/image  sensor_msgs/Image, bgr8: image with boxes, drawn only while it has subscribers
///   vision_info       vision_msgs/VisionInfo, latched: names the parameter that holds the class names
///   diagnostics       diagnostic_msgs/DiagnosticArray
/// Parameters: config/detector.yaml. The nodelet writes the class names to the parameter `classes`.
/// Frames: none; boxes are in pixels.
/// Diagnostics: model, back end, rates, percentiles of work and latency, drops, how images arrive; WARN when
///   the topic is silent, ERROR while images are refused.
/// Threads: the callback only stores the image; one worker per back-end slot.
class DetectorNodelet : public nodelet::Nodelet {
 public:
  ~DetectorNodelet() override {
    reporter_.reset();
    {
      const std::lock_guard lock(subscription_mutex_);
      closing_ = true;  // a listener that comes or goes now must not subscribe again
    }
    raw_subscriber_.shutdown();
    decoding_subscriber_.shutdown();
    images_.close();
    for (auto& worker : workers_) worker.join();
  }

 private:
  using ImageEvent = ros::MessageEvent<const sensor_msgs::Image>;
  static constexpr const char* kImageTopic = "camera/color/image_raw";
  /// More than ever wait, because the callback only stores a pointer: images are dropped, and counted, in
  /// one place.
  static constexpr std::uint32_t kQueue = 20;

  struct Job {
    sensor_msgs::ImageConstPtr message;
    std::uint64_t ticket{0};
  };

  void onInit() override;
  void load();
  void advertise();
  void update_subscription();
  void on_image(const sensor_msgs::ImageConstPtr& message, bool by_pointer);
  void work(int slot);
  std::optional<Job> next_job();
  void process(const Job& job, int slot);
  void publish(const std_msgs::Header& header, const ros_convert::SharedImage& image,
               const detect::DetectorOutput& output, double work_ms);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros_params::DetectorParams params_;
  std::optional<detect::Detector> detector_;
  ros_health::InputHealth input_{"image"};
  ros_health::WorkHealth work_health_;
  std::optional<ros_health::Reporter> reporter_;

  std::mutex subscription_mutex_;
  bool closing_{false};
  std::unique_ptr<image_transport::ImageTransport> transport_;
  ros::Subscriber raw_subscriber_;                   ///< raw images: pointers inside one manager
  image_transport::Subscriber decoding_subscriber_;  ///< any other transport
  image_transport::Publisher annotated_publisher_;
  ros::Publisher detections_publisher_;
  ros::Publisher info_publisher_;

  LatestSlot<sensor_msgs::ImageConstPtr> images_;
  std::mutex take_mutex_;  ///< an image and its ticket are taken together
  InOrder order_;
  std::vector<std::thread> workers_;
};

void DetectorNodelet::onInit() {
  load();
  reporter_.emplace(getNodeHandle(), getPrivateNodeHandle(), getName());
  reporter_->add("detector", [this](auto& status) { report(status); });
  reporter_->start();
  for (int slot = 0; slot < detector_->slots(); ++slot) workers_.emplace_back([this, slot] { work(slot); });
  advertise();
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
  if (params_.score_threshold >= 0.0) spec->thresholds.score = static_cast<float>(params_.score_threshold);
  auto detector = detect::Detector::create(*spec, params_.inference);
  if (!detector) give_up(detector.error());
  detector_.emplace(std::move(*detector));
  NODELET_INFO("model %s, %zu classes, runs on %s", detector_->spec().name.c_str(),
               detector_->spec().classes.size(), detector_->execution().c_str());
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
  const std::lock_guard lock(
      subscription_mutex_);  // the callbacks below must not run before all of this is set
  const auto changed = [this](const auto&) { update_subscription(); };
  detections_publisher_ = nh.advertise<vision_msgs::Detection2DArray>("detections", 5, changed, changed);
  annotated_publisher_ = transport_->advertise("detections/image", 5, changed, changed);
}

void DetectorNodelet::update_subscription() {
  const std::lock_guard lock(subscription_mutex_);
  if (closing_) return;
  const bool wanted =
      detections_publisher_.getNumSubscribers() > 0 || annotated_publisher_.getNumSubscribers() > 0;
  input_.listening(wanted);
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
  images_.put(message);
}

void DetectorNodelet::work(int slot) {
  while (const auto job = next_job()) process(*job, slot);
}

std::optional<DetectorNodelet::Job> DetectorNodelet::next_job() {
  const std::lock_guard lock(take_mutex_);
  auto message = images_.take();
  if (!message) return std::nullopt;
  return Job{std::move(*message), order_.begin()};
}

void DetectorNodelet::process(const Job& job, int slot) {
  const Stopwatch watch;
  const auto image = ros_convert::share_image(job.message);
  auto output = image ? detector_->detect(image->view, slot) : tl::unexpected(image.error());
  const double work_ms = watch.milliseconds();
  order_.finish(job.ticket, [&] {
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
  status.summary(diagnostic_msgs::DiagnosticStatus::OK, "running");
  status.add("model", detector_->spec().name);
  status.add("executes", detector_->execution());
  status.add("dropped", images_.dropped());
  input_.report(status, getNodeHandle().resolveName(kImageTopic), params_.timeout_s);
  work_health_.report(status);
}

}  // namespace extperfc::ros_detect

PLUGINLIB_EXPORT_CLASS(extperfc::ros_detect::DetectorNodelet, nodelet::Nodelet)
