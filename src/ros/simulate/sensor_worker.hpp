#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include "extperfc/simulate/sensor_rig.hpp"

#include "ros/health/stream_health.hpp"
#include "ros/simulate/sensor.hpp"
#include "ros/simulate/ticker.hpp"

namespace extperfc::ros_simulate {

/// Lets sensors measure in one thread beside the simulation. Each has room for one job: a newer one replaces
/// one that waits, and is counted. The job that waits longest is next.
class SensorWorker {
 public:
  SensorWorker(std::unique_ptr<simulate::SensorRig> rig, std::vector<std::unique_ptr<Sensor>> sensors);
  ~SensorWorker();
  SensorWorker(const SensorWorker&) = delete;
  SensorWorker& operator=(const SensorWorker&) = delete;

  /// In the simulation thread after every step: hands out jobs to the sensors that are due and listened to.
  void after_step(const simulate::Simulator& simulator, const ros::Time& stamp);
  /// Returns when every job is done.
  void wait_until_idle();

  [[nodiscard]] std::size_t size() const { return stations_.size(); }
  [[nodiscard]] const char* name(std::size_t index) const { return stations_[index]->sensor->name(); }
  void report(std::size_t index, diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  struct Station {
    explicit Station(std::unique_ptr<Sensor> its_sensor)
        : sensor(std::move(its_sensor)), ticker(sensor->rate_hz()) {}
    const std::unique_ptr<Sensor> sensor;
    Ticker ticker;                                     ///< simulation thread
    std::shared_ptr<const simulate::Snapshot> before;  ///< simulation thread
    std::optional<SensorJob> waiting;                  ///< guarded by mutex_, as all below
    std::uint64_t order{0};
    std::uint64_t replaced{0};
    std::uint64_t lost{0};
    double cpu_s{0};
    std::uint64_t measured{0};
    ros_health::WorkHealth health;
  };

  void put(Station& station, SensorJob job);
  void run();
  void measure(Station& station, const SensorJob& job);
  [[nodiscard]] Station* next_locked() const;

  const std::unique_ptr<simulate::SensorRig> rig_;
  std::vector<std::unique_ptr<Station>> stations_;
  std::shared_ptr<const simulate::Snapshot> posed_;  ///< worker thread: how the rig's scene is now

  std::mutex mutex_;
  std::condition_variable work_;
  std::condition_variable idle_;
  std::uint64_t next_order_{0};
  bool busy_{false};
  bool stopping_{false};
  std::thread thread_;
};

}  // namespace extperfc::ros_simulate
