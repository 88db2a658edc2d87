#include "test/benchmark/translate/sender.hpp"

#include <array>

#include <poll.h>
#include <unistd.h>

namespace extperfc::benchmark {

namespace {

constexpr std::uint32_t kQueue = 1000;  // nothing is lost on this side

ros::Publisher advertise(ros::NodeHandle& handle, const std::string& topic, const Definition& definition) {
  ros::AdvertiseOptions options(topic, kQueue, definition.md5, definition.type, definition.text);
  return handle.advertise(options);
}

}  // namespace

Sender::Sender(ros::NodeHandle& handle, const std::string& topic, const Definition& definition,
               std::uint32_t size)
    : publisher_(advertise(handle, topic, definition)), size_(size) {}

// A message of its own each time: roscpp serialises it later, in another thread.
std::uint32_t Sender::send() {
  const auto blob = make_blob(size_);
  stamp_blob(*blob, ++number_, monotonic_ns());
  publisher_.publish(boost::shared_ptr<const RawMessage>(blob));
  return number_;
}

std::vector<Arrival> ArrivalReader::read_all() {
  std::vector<Arrival> arrivals;
  std::array<Arrival, 128> block{};  // the receiver writes whole ones, each at once
  for (;;) {
    const auto count = read(descriptor_, block.data(), sizeof block);
    if (count <= 0) return arrivals;
    const auto whole = static_cast<std::ptrdiff_t>(static_cast<std::size_t>(count) / sizeof(Arrival));
    arrivals.insert(arrivals.end(), block.begin(), block.begin() + whole);
  }
}

std::optional<Arrival> ArrivalReader::wait(double seconds) {
  pollfd event{descriptor_, POLLIN, 0};
  if (poll(&event, 1, static_cast<int>(1e3 * seconds)) <= 0) return std::nullopt;
  Arrival arrival;
  if (read(descriptor_, &arrival, sizeof arrival) != sizeof arrival) return std::nullopt;
  return arrival;
}

}  // namespace extperfc::benchmark
