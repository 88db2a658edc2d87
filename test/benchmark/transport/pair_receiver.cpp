#include "test/benchmark/transport/pair_receiver.hpp"

#include <chrono>
#include <utility>

namespace extperfc::benchmark {

PairReceiver::PairReceiver(const std::string& ns, nodelet::detail::CallbackQueueManager& manager)
    : manager_(manager), queue_(boost::make_shared<nodelet::detail::CallbackQueue>(&manager)), handle_(ns) {
  constexpr std::uint32_t kQueue = 10;
  manager_.addQueue(queue_, false);
  handle_.setCallbackQueue(queue_.get());
  synchronizer_.connectInput(color_, depth_);
  synchronizer_.registerCallback(&PairReceiver::on_pair, this);
  color_.subscribe(handle_, "color", kQueue);
  depth_.subscribe(handle_, "depth", kQueue);
}

PairReceiver::~PairReceiver() {
  color_.unsubscribe();
  depth_.unsubscribe();
  queue_->disable();
  manager_.removeQueue(queue_);
}

void PairReceiver::clear() {
  const std::lock_guard lock(mutex_);
  arrival_.reset();
}

std::optional<Arrival> PairReceiver::wait(double deadline_s) {
  std::unique_lock lock(mutex_);
  came_.wait_for(lock, std::chrono::duration<double>(deadline_s), [this] { return arrival_.has_value(); });
  return std::exchange(arrival_, std::nullopt);
}

void PairReceiver::on_pair(const sensor_msgs::ImageConstPtr& color, const sensor_msgs::ImageConstPtr& depth) {
  const double latency_us = 1e6 * (ros::Time::now() - color->header.stamp).toSec();
  {
    const std::lock_guard lock(mutex_);
    arrival_ = Arrival{latency_us, color->data.data(), depth->data.data()};
  }
  came_.notify_one();
}

}  // namespace extperfc::benchmark
