#include <deque>
#include <string>
#include <thread>

#include <ros/node_handle.h>
#include <ros/spinner.h>

#include "test/benchmark/translate/parts.hpp"
#include "test/benchmark/translate/process.hpp"
#include "test/benchmark/translate/raw_message.hpp"

namespace extperfc::benchmark {

namespace {

constexpr std::uint32_t kQueue = 10;

/// Advertises when the first message arrives with its type, then forwards all messages.
struct Relay {
  ros::NodeHandle* handle{nullptr};
  std::string to;
  ros::Publisher publisher{};
  ros::Subscriber subscriber{};

  void advertise(const ros::M_string& header) {
    const auto value = [&](const char* key) {
      const auto found = header.find(key);
      return found == header.end() ? std::string("*") : found->second;
    };
    ros::AdvertiseOptions options(to, kQueue, value("md5sum"), value("type"), value("message_definition"));
    publisher = handle->advertise(options);
  }

  void on_message(const ros::MessageEvent<const RawMessage>& event) {
    if (!publisher) advertise(event.getConnectionHeader());
    publisher.publish(event.getConstMessage());
  }

  void subscribe(const std::string& from) {
    ros::SubscribeOptions options;
    options.initByFullCallbackType<const ros::MessageEvent<const RawMessage>&>(
        from, kQueue, [this](const ros::MessageEvent<const RawMessage>& event) { on_message(event); });
    options.transport_hints = ros::TransportHints().tcpNoDelay();
    subscriber = handle->subscribe(options);
  }
};

}  // namespace

int run_relay(const std::vector<std::string>& arguments) {
  start_ros(arguments.at(0), "bench_relay");
  ros::NodeHandle handle;
  std::deque<Relay> relays;
  for (std::size_t i = 1; i + 1 < arguments.size(); i += 2) {
    relays.push_back({&handle, arguments[i + 1]});
    relays.back().subscribe(arguments[i]);
    std::this_thread::sleep_for(kRegistrationPause);
  }
  ros::AsyncSpinner spinner(1);
  spinner.start();
  wait_for_end_of_input();
  return 0;
}

}  // namespace extperfc::benchmark
