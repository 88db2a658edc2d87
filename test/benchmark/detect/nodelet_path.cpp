#include "test/benchmark/detect/nodelet_path.hpp"

#include "extperfc/base/stopwatch.hpp"

namespace extperfc::benchmark {

namespace {

constexpr double kConnectDeadlineS = 20.0;
constexpr double kResultDeadlineS = 20.0;

void set_detector_params(const std::string& name, const NodeletPath::Settings& settings) {
  ros::NodeHandle params(name);
  params.setParam("model", settings.model.string());
  params.setParam("backend", settings.inference.backend);
  params.setParam("device", settings.inference.device);
  params.setParam("threads", settings.inference.threads);
  params.setParam("precision", detect::to_string(settings.inference.precision));
  params.setParam("score_threshold", settings.score_threshold);
}

}  // namespace

Result<void> NodeletPath::start(const std::string& ns, const Settings& settings) {
  connect(ns);
  if (auto loaded = load(ns, settings); !loaded) return loaded;
  return wait_for_subscribers();
}

NodeletPath::~NodeletPath() {
  objects_.shutdown();
  if (loader_) loader_->clear();
}

void NodeletPath::connect(const std::string& ns) {
  handle_.emplace(ns);
  handle_->setCallbackQueue(&queue_);
  color_ = handle_->advertise<sensor_msgs::Image>("camera/color/image_raw", 2);
  depth_ = handle_->advertise<sensor_msgs::Image>("camera/aligned_depth_to_color/image_raw", 2);
  info_ = handle_->advertise<sensor_msgs::CameraInfo>("camera/color/camera_info", 2);
  const boost::function<void(const vision_msgs::Detection3DArrayConstPtr&)> keep =
      [this](const vision_msgs::Detection3DArrayConstPtr& message) { newest_ = message; };
  objects_ = handle_->subscribe<vision_msgs::Detection3DArray>("detections_3d", 5, keep);
}

Result<void> NodeletPath::load(const std::string& ns, const Settings& settings) {
  set_detector_params(ns + "/detector", settings);
  loader_.emplace(false);
  for (const char* name : {"detector", "box_depth"})
    if (!loader_->load(ns + "/" + name, std::string("extperfc/") + name, {}, {}))
      return fail(ErrorCode::kFailed,
                  std::string("the nodelet ") + name + " does not start; its message is above");
  return {};
}

Result<void> NodeletPath::wait_for_subscribers() {
  const Stopwatch watch;
  const auto connected = [this] {
    return color_.getNumSubscribers() > 0 && depth_.getNumSubscribers() > 0 && info_.getNumSubscribers() > 0;
  };
  while (!connected()) {
    if (!ros::ok() || watch.seconds() > kConnectDeadlineS)
      return fail(ErrorCode::kFailed, "the nodelets do not subscribe to the camera's topics");
    ros::WallDuration(0.005).sleep();
  }
  return {};
}

Result<PathCost> NodeletPath::run(const CameraMessages& messages) {
  CostWatch cost_watch;
  const Stopwatch watch;
  const ros::Time stamp = ros::Time::now();
  messages.info->header.stamp = messages.depth->header.stamp = messages.color->header.stamp = stamp;
  info_.publish(messages.info);
  depth_.publish(messages.depth);
  color_.publish(messages.color);
  while (!newest_ || newest_->header.stamp != stamp) {
    queue_.callOne(ros::WallDuration(0.1));
    if (!ros::ok() || watch.seconds() > kResultDeadlineS)
      return fail(ErrorCode::kFailed, "no 3D detections came for an image; the nodelets' messages are above");
  }
  return PathCost{cost_watch.lap(), newest_->detections.size()};
}

}  // namespace extperfc::benchmark
