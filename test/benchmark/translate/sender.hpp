#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include "test/benchmark/translate/blob.hpp"
#include "test/benchmark/translate/parts.hpp"
#include "test/benchmark/translate/process.hpp"

namespace extperfc::benchmark {

/// A roscpp publisher of messages of one size.
class Sender {
 public:
  Sender(ros::NodeHandle& handle, const std::string& topic, const Definition& definition, std::uint32_t size);

  /// Stamps and publishes the next message; returns its number.
  std::uint32_t send();
  [[nodiscard]] std::string topic() const { return publisher_.getTopic(); }
  [[nodiscard]] std::uint32_t size() const { return size_; }
  [[nodiscard]] std::uint32_t sent() const { return number_; }
  [[nodiscard]] bool connected() const { return publisher_.getNumSubscribers() > 0; }

 private:
  ros::Publisher publisher_;
  std::uint32_t size_;
  std::uint32_t number_{0};
};

/// Reads what a receiver writes.
class ArrivalReader {
 public:
  explicit ArrivalReader(const Process& receiver) : descriptor_(receiver.records()) {}

  /// Everything that is there now.
  [[nodiscard]] std::vector<Arrival> read_all();
  /// The next one; nothing after `seconds`.
  [[nodiscard]] std::optional<Arrival> wait(double seconds);

 private:
  int descriptor_;
};

}  // namespace extperfc::benchmark
