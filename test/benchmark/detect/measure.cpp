#include "test/benchmark/detect/measure.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <cv_bridge/cv_bridge.h>
#include <opencv2/core/utility.hpp>
#include <ros/this_node.h>
#include <sensor_msgs/image_encodings.h>

#include "extperfc/base/running_stats.hpp"

#include "ros/convert/image.hpp"
#include "test/benchmark/detect/core_chain.hpp"

namespace extperfc::benchmark {

namespace {

constexpr int kRoundFrames = 10;  // frames
constexpr int kWarmUps = 3;

void pause() {
  ros::WallDuration(0.005).sleep();
}

CameraMessages to_messages(const ImagePair& image, const CameraModel& camera) {
  namespace enc = sensor_msgs::image_encodings;
  std_msgs::Header header;
  header.frame_id = "camera_color_optical_frame";
  return {cv_bridge::CvImage(header, enc::BGR8, image.color).toImageMsg(),
          cv_bridge::CvImage(header, enc::TYPE_16UC1, image.depth).toImageMsg(),
          boost::make_shared<sensor_msgs::CameraInfo>(ros_convert::to_camera_info(camera, header))};
}

struct Samples {
  std::vector<PathCost> path;
  std::vector<Cost> bare;
  std::vector<ChainCosts> core;
};

/// Quantile of what `value` takes out of every sample.
template <typename T, typename Value>
double quantile(const std::vector<T>& samples, double fraction, const Value& value) {
  std::vector<double> values;
  for (const auto& sample : samples) values.push_back(value(sample));
  return percentile(values, fraction);
}

template <typename T, typename CostOf>
Cost median(const std::vector<T>& samples, const CostOf& cost_of) {
  return {quantile(samples, 0.5, [&](const T& sample) { return cost_of(sample).wall_ms; }),
          quantile(samples, 0.5, [&](const T& sample) { return cost_of(sample).cpu_ms; })};
}

Cost median(const std::vector<ChainCosts>& samples, Cost ChainCosts::*part) {
  return median(samples, [part](const ChainCosts& sample) { return sample.*part; });
}

template <typename T>
double mean(const std::vector<T>& samples, std::size_t T::*member) {
  double sum = 0.0;
  for (const auto& sample : samples) sum += static_cast<double>(sample.*member);
  return sum / static_cast<double>(samples.size());
}

/// Runs the three kinds of work and keeps their times.
class Rounds {
 public:
  Rounds(NodeletPath& path, CoreChain& core, const Footage& footage)
      : path_(path), core_(core), footage_(footage) {}

  [[nodiscard]] Result<void> round(int frames) {
    for (const auto step : {&Rounds::one_path, &Rounds::one_core, &Rounds::one_bare})
      for (int i = 0; i < frames; ++i)
        if (auto done = (this->*step)(i); !done) return done;
    shown_ += static_cast<std::size_t>(frames);
    return {};
  }

  [[nodiscard]] Samples& samples() { return samples_; }

 private:
  /// A fresh copy, as from a driver; made before the clock starts.
  [[nodiscard]] CameraMessages messages(int i) const {
    const auto index = (shown_ + static_cast<std::size_t>(i)) % footage_.images.size();
    return to_messages(footage_.images[index], footage_.camera);
  }

  Result<void> one_path(int i) {
    const auto given = messages(i);
    pause();
    auto cost = path_.run(given);
    if (!cost) return tl::unexpected(cost.error());
    samples_.path.push_back(*cost);
    return {};
  }

  Result<void> one_core(int i) {
    const auto given = messages(i);
    pause();
    auto cost = core_.run(given.color, given.depth);
    if (!cost) return tl::unexpected(cost.error());
    samples_.core.push_back(*cost);
    return {};
  }

  Result<void> one_bare(int /*i*/) {
    pause();
    auto cost = core_.infer();
    if (!cost) return tl::unexpected(cost.error());
    samples_.bare.push_back(*cost);
    return {};
  }

  NodeletPath& path_;
  CoreChain& core_;
  const Footage& footage_;
  std::size_t shown_{0};
  Samples samples_;
};

DetectFigures figures_of(const Samples& samples) {
  DetectFigures figures;
  figures.bare = median(samples.bare, [](const Cost& cost) { return cost; });
  figures.path = median(samples.path, [](const PathCost& sample) { return sample.cost; });
  figures.path_p95_ms =
      quantile(samples.path, 0.95, [](const PathCost& sample) { return sample.cost.wall_ms; });
  figures.bare_undisturbed_ms = quantile(samples.bare, 0.1, [](const Cost& cost) { return cost.wall_ms; });
  figures.path_undisturbed_ms =
      quantile(samples.path, 0.1, [](const PathCost& sample) { return sample.cost.wall_ms; });
  figures.prepare = median(samples.core, &ChainCosts::prepare);
  figures.inference = median(samples.core, &ChainCosts::inference);
  figures.decode = median(samples.core, &ChainCosts::decode);
  figures.depth = median(samples.core, &ChainCosts::depth);
  figures.mean_boxes = mean(samples.core, &ChainCosts::boxes);
  figures.mean_objects = mean(samples.path, &PathCost::objects);
  return figures;
}

Result<CoreChain> make_core(const DetectCase& what, const CameraModel& camera) {
  auto spec = what.spec;
  if (what.settings.score_threshold >= 0.0)
    spec.thresholds.score = static_cast<float>(what.settings.score_threshold);
  auto backend = detect::make_backend(spec, what.settings.inference);
  if (!backend) return tl::unexpected(backend.error());
  return CoreChain(std::move(spec), std::move(*backend), ros_convert::to_camera_info(camera, {}));
}

}  // namespace

Cost DetectFigures::transport() const {
  Cost left = path;
  for (const Cost& part : {prepare, inference, decode, depth}) {
    left.wall_ms -= part.wall_ms;
    left.cpu_ms -= part.cpu_ms;
  }
  return left;
}

std::string DetectCase::name() const {
  const int threads = settings.inference.threads;
  return spec.name + " " + settings.inference.backend + " " + std::to_string(threads) +
         (threads == 1 ? " thread" : " threads");
}

Result<DetectFigures> measure(const DetectCase& what, const Footage& footage, int frames, int number) {
  cv::setNumThreads(what.settings.inference.threads);  // also for the images' preparation
  auto core = make_core(what, footage.camera);
  if (!core) return tl::unexpected(core.error());
  NodeletPath path;
  const std::string ns = ros::this_node::getName() + "/case" + std::to_string(number);
  if (auto started = path.start(ns, what.settings); !started) return tl::unexpected(started.error());

  Rounds warm_up(path, *core, footage);
  if (auto done = warm_up.round(kWarmUps); !done) return tl::unexpected(done.error());
  Rounds rounds(path, *core, footage);
  for (int left = frames; left > 0; left -= kRoundFrames)
    if (auto done = rounds.round(std::min(left, kRoundFrames)); !done) return tl::unexpected(done.error());
  DetectFigures figures = figures_of(rounds.samples());
  figures.execution = core->execution();
  return figures;
}

}  // namespace extperfc::benchmark
