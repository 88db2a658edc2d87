// A node whose message classes are one era's: the same sources are compiled against each era's headers.
#include <atomic>
#include <chrono>
#include <cstdio>
#include <exception>
#include <iostream>
#include <iterator>
#include <mutex>
#include <sstream>
#include <stdexcept>

#include <ros/console.h>
#include <ros/init.h>
#include <ros/spinner.h>
#include <std_msgs/Float64.h>

#include "test/translator/puppet.hpp"
#include "test/translator/puppet_bytes.hpp"

namespace puppet {

std::string to_hex(const Bytes& bytes) {
  static const char* digits = "0123456789abcdef";
  std::string text = "x";
  text.reserve(1 + 2 * bytes.size());
  for (const auto byte : bytes) {
    text += digits[byte >> 4U];
    text += digits[byte & 15U];
  }
  return text;
}

Bytes from_hex(const std::string& text) {
  if (text.empty() || text[0] != 'x' || text.size() % 2 == 0)
    throw std::invalid_argument("not bytes: " + text);
  const auto value = [](char digit) { return digit <= '9' ? digit - '0' : digit - 'a' + 10; };
  Bytes bytes;
  for (std::size_t i = 1; i < text.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(value(text[i]) * 16 + value(text[i + 1])));
  return bytes;
}

void report(const std::string& line) {
  static std::mutex mutex;
  const std::lock_guard<std::mutex> lock(mutex);
  std::fwrite(line.data(), 1, line.size(), stdout);
  std::fputc('\n', stdout);
  std::fflush(stdout);
}

namespace {

class Puppet {
 public:
  explicit Puppet(const Kinds& kinds) : kinds_(kinds) { add_commands(); }
  ~Puppet() {
    ending_ = true;
    for (auto& thread : threads_) thread.join();
  }
  void obey(const std::string& line) {
    std::istringstream stream(line);
    const std::vector<std::string> tokens{std::istream_iterator<std::string>(stream), {}};
    if (tokens.empty()) return;
    try {
      commands_.at(tokens[0])(tokens);
      report("ok " + tokens[0]);
    } catch (const std::exception& error) {
      report("error " + line.substr(0, 200) + ": " + error.what());
    }
  }

 private:
  using Tokens = std::vector<std::string>;

  void add_commands() {
    add_topic_commands();
    add_service_commands();
    add_action_commands();
  }

  void add_topic_commands() {
    commands_["advertise"] = [this](const Tokens& w) {
      const auto& kind = kinds_.messages.at(w.at(2));
      publishers_[w.at(1)] = {kind.advertise(node_, w[1], w.at(3) == "1"), kind};
    };
    commands_["unadvertise"] = [this](const Tokens& w) { publishers_.erase(w.at(1)); };
    commands_["publish"] = [this](const Tokens& w) {
      const auto& [publisher, kind] = publishers_.at(w.at(1));
      kind.publish(publisher, from_hex(w.at(2)));
    };
    commands_["repeat"] = [this](const Tokens& w) {  // TOPIC RATE COUNT BYTES
      const auto& out = publishers_.at(w.at(1));
      repeat(w.at(1), std::stod(w.at(2)), std::stoul(w.at(3)),
             [out, bytes = from_hex(w.at(4))] { out.second.publish(out.first, bytes); });
    };
    commands_["stream"] =
        [this](const Tokens& w) {  // TOPIC RATE COUNT: std_msgs/Float64, the time of sending
          const auto& out = publishers_.at(w.at(1));
          repeat(w.at(1), std::stod(w.at(2)), std::stoul(w.at(3)), [publisher = out.first] {
            std_msgs::Float64 now;
            now.data = ros::WallTime::now().toSec();
            publisher.publish(now);
          });
        };
    commands_["stop"] = [this](const Tokens& w) { *repeating_.at(w.at(1)) = false; };
    commands_["subscribe"] = [this](const Tokens& w) {
      subscribers_[w.at(1)] = kinds_.messages.at(w.at(2)).subscribe(node_, w[1]);
    };
    commands_["unsubscribe"] = [this](const Tokens& w) { subscribers_.erase(w.at(1)); };
    commands_["log"] = [](const Tokens& w) {
      if (w.at(1) == "error") ROS_ERROR("%s", w.at(2).c_str());
      if (w.at(1) == "warn") ROS_WARN("%s", w.at(2).c_str());
      if (w.at(1) == "info") ROS_INFO("%s", w.at(2).c_str());
    };
  }

  void add_service_commands() {
    commands_["serve"] = [this](const Tokens& w) {
      const auto response = w.at(3) == "-" ? nullptr : std::make_shared<Bytes>(from_hex(w[3]));
      servers_[w.at(1)] = kinds_.services.at(w.at(2)).serve(node_, w[1], response);
    };
    commands_["unserve"] = [this](const Tokens& w) { servers_.erase(w.at(1)); };
    commands_["call"] = [this](const Tokens& w) {
      threads_.emplace_back(
          [this, kind = kinds_.services.at(w.at(2)), name = w[1], request = from_hex(w.at(3))] {
            Bytes response;
            const bool good = kind.call(node_, name, request, response);
            report("response " + name + (good ? " ok " + to_hex(response) : " failed x"));
          });
    };
  }

  void add_action_commands() {
    commands_["action_server"] = [this](const Tokens& w) {
      action_servers_[w.at(1)] = kinds_.actions.at(w.at(2)).serve(node_, w[1]);
    };
    for (const auto* how : {"succeed", "abort", "preempted"})
      commands_[how] = [this](const Tokens& w) {
        action_servers_.at(w.at(1))->finish(w[0], from_hex(w.at(2)), w.size() > 3 ? w[3] : "");
      };
    commands_["feedback"] = [this](const Tokens& w) {
      action_servers_.at(w.at(1))->feedback(from_hex(w.at(2)));
    };
    commands_["action_client"] = [this](const Tokens& w) {
      action_clients_[w.at(1)] = kinds_.actions.at(w.at(2)).connect(w[1]);
    };
    commands_["wait_server"] = [this](const Tokens& w) {
      threads_.emplace_back(
          [name = w.at(1), client = action_clients_.at(w[1]).get(), seconds = std::stod(w.at(2))] {
            report("connected " + name + " " + (client->wait_for_server(seconds) ? "1" : "0"));
          });
    };
    commands_["send_goal"] = [this](const Tokens& w) {
      action_clients_.at(w.at(1))->send_goal(from_hex(w.at(2)));
    };
    commands_["cancel"] = [this](const Tokens& w) { action_clients_.at(w.at(1))->cancel(); };
  }

  void repeat(const std::string& topic, double rate, std::size_t count, const std::function<void()>& once) {
    const auto going_on = repeating_[topic] = std::make_shared<std::atomic<bool>>(true);
    threads_.emplace_back([this, topic, rate, count, once, going_on] {
      auto next = std::chrono::steady_clock::now();
      std::size_t sent = 0;
      for (; sent < count && *going_on && !ending_; ++sent) {
        once();
        next += std::chrono::microseconds(static_cast<std::int64_t>(1e6 / rate));
        std::this_thread::sleep_until(next);
      }
      report("repeated " + topic + " " + std::to_string(sent));
    });
  }

  const Kinds& kinds_;
  ros::NodeHandle node_;
  std::atomic<bool> ending_{false};
  std::map<std::string, std::function<void(const Tokens&)>> commands_;
  std::map<std::string, std::pair<ros::Publisher, MessageKind>> publishers_;
  std::map<std::string, ros::Subscriber> subscribers_;
  std::map<std::string, ros::ServiceServer> servers_;
  std::map<std::string, std::unique_ptr<ActionServer>> action_servers_;
  std::map<std::string, std::unique_ptr<ActionClient>> action_clients_;
  std::map<std::string, std::shared_ptr<std::atomic<bool>>> repeating_;
  std::vector<std::thread> threads_;
};

}  // namespace
}  // namespace puppet

int main(int argc, char** argv) {
  ros::init(argc, argv, "puppet", ros::init_options::NoSigintHandler);
  puppet::Kinds kinds;
  puppet::add_messages(kinds);
  puppet::add_services(kinds);
  puppet::add_actions(kinds);
  ros::AsyncSpinner spinner(2);
  spinner.start();
  puppet::Puppet puppet(kinds);
  puppet::report("ready");
  for (std::string line; std::getline(std::cin, line);) puppet.obey(line);
  return 0;
}
