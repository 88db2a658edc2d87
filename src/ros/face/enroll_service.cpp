#include "ros/face/enroll_service.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "extperfc/base/number_reader.hpp"

namespace extperfc::ros_face {

namespace {

constexpr double kDefaultTimeoutS = 10.0;
constexpr int kMaxSamples = 1000;

/// Nearest first where all positions are known, else largest first. Null: no face has a feature.
const face::DescribedFace* chosen_face(const std::vector<face::DescribedFace>& faces,
                                       const std::vector<std::optional<Eigen::Vector3d>>& distances) {
  const bool are_placed = distances.size() == faces.size() &&
                          std::all_of(distances.begin(), distances.end(), [](const auto& d) { return d; });
  const face::DescribedFace* best = nullptr;
  double best_rank = 0.0;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const double rank = are_placed ? -distances[i]->norm() : faces[i].face.box.area();
    if (!faces[i].feature || (best != nullptr && rank <= best_rank)) continue;
    best = &faces[i];
    best_rank = rank;
  }
  return best;
}

}  // namespace

/// What a request gathers.
struct EnrollService::Sampling {
  Sampling(std::size_t count, const EnrollParams& sampling_params) : wanted(count), params(sampling_params) {}

  void offer(const ros::Time& stamp, const face::DescribedFace* face) {
    {
      const std::lock_guard lock(mutex);
      ++images;
      if (face == nullptr || features.size() >= wanted) return;
      if (!features.empty() && std::abs((stamp - last).toSec()) < params.interval_s) return;
      if (!features.empty() && face::similarity(features.front(), *face->feature) < params.threshold) {
        ++others;
        return;
      }
      features.push_back(*face->feature);
      last = stamp;
      if (features.size() < wanted) return;
    }
    done.put(true);
  }

  const std::size_t wanted;
  const EnrollParams params;
  LatestSlot<bool> done;
  mutable std::mutex mutex;  ///< guards what follows
  std::vector<face::Feature> features;
  ros::Time last;  ///< of the latest feature
  int images{0};
  int others{0};  ///< images whose face does not resemble the first one
};

EnrollService::EnrollService(ros::NodeHandle private_handle, SharedGallery& gallery,
                             const EnrollParams& params, std::function<void()> waiting_changed)
    : gallery_(gallery), params_(params), waiting_changed_(std::move(waiting_changed)) {
  private_handle.setCallbackQueue(&queue_);
  enroll_server_ = private_handle.advertiseService("enroll", &EnrollService::enroll, this);
  forget_server_ = private_handle.advertiseService("forget", &EnrollService::forget, this);
  spinner_.start();
}

EnrollService::~EnrollService() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
    if (current_) current_->done.close();
  }
  enroll_server_.shutdown();
  forget_server_.shutdown();
  spinner_.stop();
}

std::shared_ptr<EnrollService::Sampling> EnrollService::current() const {
  const std::lock_guard lock(mutex_);
  return current_;
}

bool EnrollService::is_closing() const {
  const std::lock_guard lock(mutex_);
  return closing_;
}

bool EnrollService::is_waiting() const {
  return current() != nullptr;
}

void EnrollService::offer(const ros::Time& stamp, const std::vector<face::DescribedFace>& faces,
                          const std::vector<std::optional<Eigen::Vector3d>>& positions) {
  if (const auto sampling = current()) sampling->offer(stamp, chosen_face(faces, positions));
}

bool EnrollService::begin(const std::shared_ptr<Sampling>& sampling) {
  {
    const std::lock_guard lock(mutex_);
    if (closing_) return false;
    current_ = sampling;
  }
  waiting_changed_();
  return true;
}

void EnrollService::end() {
  {
    const std::lock_guard lock(mutex_);
    current_.reset();
  }
  waiting_changed_();
}

bool EnrollService::enroll(EnrollFace::Request& request, EnrollFace::Response& response) {
  if (const auto checked = face::check_name(request.name); !checked) {
    response.message = checked.error().message;
    return true;
  }
  const int wanted = std::min(request.samples > 0 ? request.samples : params_.samples, kMaxSamples);
  const double asked_s = request.timeout.toSec();
  const double timeout_s = asked_s > 0.0 ? asked_s : kDefaultTimeoutS;
  const auto sampling = std::make_shared<Sampling>(static_cast<std::size_t>(wanted), params_);
  if (!begin(sampling)) return false;
  (void)sampling->done.take_for(std::chrono::duration<double>(timeout_s));
  end();
  if (is_closing()) return false;
  finish(request, *sampling, timeout_s, response);
  return true;
}

void EnrollService::finish(const EnrollFace::Request& request, const Sampling& sampling, double timeout_s,
                           EnrollFace::Response& response) {
  const std::lock_guard lock(sampling.mutex);
  const std::string within = " within " + number_text(timeout_s) + " s";
  if (sampling.images == 0) {
    response.message =
        "no image came" + within + ": is the camera running, and does its topic have this name?";
    return;
  }
  if (sampling.features.empty()) {
    response.message =
        "no face that is large enough was seen" + within + ": come nearer, or lower min_face_px";
    return;
  }
  const auto known = gallery_.identify(sampling.features.front(), {params_.threshold, 0.0F});
  const auto total = gallery_.enroll(request.name, sampling.features);
  if (!total) {
    response.message = total.error().message;
    return;
  }
  response.success = static_cast<unsigned char>(true);
  response.samples = static_cast<int>(sampling.features.size());
  response.total = static_cast<int>(*total);
  if (sampling.features.size() < sampling.wanted)
    response.message = "only " + std::to_string(response.samples) + " of " + std::to_string(sampling.wanted) +
                       " samples" + within + ", " + std::to_string(sampling.others) +
                       " images with a face unlike the first one; ";
  if (!known.name.empty() && known.name != request.name)
    response.message += "this face resembles " + known.name + ", too: both may stay unknown";
}

bool EnrollService::forget(ForgetFace::Request& request, ForgetFace::Response& response) {
  const auto forgotten = gallery_.forget(request.name);
  response.success = static_cast<unsigned char>(forgotten.has_value());
  if (!forgotten) response.message = forgotten.error().message;
  return true;
}

}  // namespace extperfc::ros_face
