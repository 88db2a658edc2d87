#include "ros/simulate/sensor_worker.hpp"

#include <algorithm>
#include <ctime>
#include <utility>

#include <ros/console.h>

#include "extperfc/base/stopwatch.hpp"

namespace extperfc::ros_simulate {

namespace {

double thread_cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// A snapshot of one period ago; empty when time went back, or there were no subscribers meanwhile.
std::shared_ptr<const simulate::Snapshot> if_recent(std::shared_ptr<const simulate::Snapshot> before,
                                                    double time_s, double rate_hz) {
  if (!before || before->time_s >= time_s || time_s - before->time_s > 1.5 / rate_hz) return nullptr;
  return before;
}

}  // namespace

SensorWorker::SensorWorker(std::unique_ptr<simulate::SensorRig> rig,
                           std::vector<std::unique_ptr<Sensor>> sensors)
    : rig_(std::move(rig)) {
  for (auto& sensor : sensors) stations_.push_back(std::make_unique<Station>(std::move(sensor)));
  thread_ = std::thread([this] { run(); });
}

SensorWorker::~SensorWorker() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  work_.notify_all();
  thread_.join();
}

void SensorWorker::after_step(const simulate::Simulator& simulator, const ros::Time& stamp) {
  std::shared_ptr<const simulate::Snapshot> now;  // one for all sensors that are due in this step
  for (auto& station : stations_) {
    const double time_s = simulator.time_s();
    if (!station->ticker.due(time_s) || !station->sensor->wanted()) continue;
    if (!now) now = std::make_shared<simulate::Snapshot>(simulator.snapshot());
    auto before = if_recent(std::exchange(station->before, now), time_s, station->ticker.rate_hz());
    put(*station, {stamp, std::move(before), now, simulator.faults()});
  }
}

void SensorWorker::put(Station& station, SensorJob job) {
  std::optional<SensorJob> replaced;  // destroyed without the lock
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) return;
    replaced.swap(station.waiting);
    if (replaced) ++station.replaced;
    if (!replaced) station.order = next_order_++;  // a replaced job keeps its place
    station.waiting = std::move(job);
  }
  work_.notify_one();
}

void SensorWorker::wait_until_idle() {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return stopping_ || (!busy_ && !next_locked()); });
}

SensorWorker::Station* SensorWorker::next_locked() const {
  Station* next = nullptr;
  for (const auto& station : stations_)
    if (station->waiting && (!next || station->order < next->order)) next = station.get();
  return next;
}

void SensorWorker::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    work_.wait(lock, [this] { return stopping_ || next_locked(); });
    if (stopping_) break;
    Station& station = *next_locked();
    const SensorJob job = *std::exchange(station.waiting, std::nullopt);
    busy_ = true;
    lock.unlock();
    measure(station, job);
    lock.lock();
    busy_ = false;
    if (!next_locked()) idle_.notify_all();
  }
  idle_.notify_all();
}

void SensorWorker::measure(Station& station, const SensorJob& job) {
  const Stopwatch watch;
  const double cpu_before_s = thread_cpu_seconds();
  bool published = false;
  try {
    if (posed_ != job.now) rig_->pose(*job.now);
    posed_ = job.now;
    published = station.sensor->measure(*rig_, job);
    station.health.done(watch.milliseconds(), ros_health::age_ms(job.stamp));
  } catch (const std::exception& error) {
    if (station.health.failed(error.what())) ROS_ERROR("%s: %s", station.sensor->name(), error.what());
  }
  const std::lock_guard lock(mutex_);
  station.cpu_s += thread_cpu_seconds() - cpu_before_s;
  ++station.measured;
  if (!published) ++station.lost;
}

void SensorWorker::report(std::size_t index, diagnostic_updater::DiagnosticStatusWrapper& status) {
  Station& station = *stations_[index];
  const bool wanted = station.sensor->wanted();
  status.summary(diagnostic_msgs::DiagnosticStatus::OK, wanted ? "running" : "no subscribers");
  status.addf("wanted rate [Hz]", "%.1f", station.ticker.rate_hz());
  {
    const std::lock_guard lock(mutex_);
    status.add("replaced by newer", station.replaced);
    status.add("lost by a fault", station.lost);
    status.addf("CPU mean [ms]", "%.2f",
                1e3 * station.cpu_s / static_cast<double>(std::max<std::uint64_t>(station.measured, 1)));
  }
  for (const auto& [key, value] : station.sensor->details()) status.add(key, value);
  station.health.report(status);
}

}  // namespace extperfc::ros_simulate
