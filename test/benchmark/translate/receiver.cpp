#include <cstdlib>
#include <deque>
#include <string>
#include <thread>

#include <ros/init.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <unistd.h>

#include "test/benchmark/ros_log.hpp"
#include "test/benchmark/translate/blob.hpp"
#include "test/benchmark/translate/parts.hpp"
#include "test/benchmark/translate/process.hpp"

namespace extperfc::benchmark {

namespace {

constexpr std::uint32_t kQueue = 1000;  // nothing is lost on this side

struct Stream {
  std::uint32_t index{0};
  std::uint32_t sent_size{0};

  void on_message(const boost::shared_ptr<const RawMessage>& message) const {
    const auto now = monotonic_ns();
    const auto stamp = stamp_of(*message);
    const std::uint32_t sent = sent_size == 0 ? message->size : sent_size;
    const Arrival arrival{index, stamp.number,  stamp.monotonic_ns,
                          now,   message->size, blob_is_whole(*message, sent) ? 1U : 0U};
    if (write(kRecordDescriptor, &arrival, sizeof arrival) != sizeof arrival) ros::requestShutdown();
  }
};

ros::SubscribeOptions options_of(const std::string& topic, const std::string& type, const std::string& md5,
                                 const Stream& stream) {
  ros::SubscribeOptions options;
  options.initByFullCallbackType<const boost::shared_ptr<const RawMessage>&>(
      topic, kQueue,
      [&stream](const boost::shared_ptr<const RawMessage>& message) { stream.on_message(message); });
  options.md5sum = md5;
  options.datatype = type;
  options.transport_hints = ros::TransportHints().tcpNoDelay();
  return options;
}

}  // namespace

void start_ros(const std::string& master_uri, const std::string& name) {
  ros::init(ros::M_string{{"__master", master_uri}}, name,
            ros::init_options::AnonymousName | ros::init_options::NoSigintHandler);
  log_warnings_only();
}

int run_receiver(const std::vector<std::string>& arguments) {
  start_ros(arguments.at(0), "bench_receiver");
  ros::NodeHandle handle;
  std::deque<Stream> streams;
  std::vector<ros::Subscriber> subscribers;
  for (std::size_t i = 1; i + 3 < arguments.size(); i += 4) {
    streams.push_back({static_cast<std::uint32_t>(streams.size()),
                       static_cast<std::uint32_t>(std::strtoul(arguments[i + 3].c_str(), nullptr, 10))});
    auto options = options_of(arguments[i], arguments[i + 1], arguments[i + 2], streams.back());
    subscribers.push_back(handle.subscribe(options));
    std::this_thread::sleep_for(kRegistrationPause);
  }
  ros::AsyncSpinner spinner(1);
  spinner.start();
  wait_for_end_of_input();
  return 0;
}

}  // namespace extperfc::benchmark
