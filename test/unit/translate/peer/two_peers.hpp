#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/translate/peer.hpp"

#include "test/unit/translate/peer/graph_master.hpp"

namespace extperfc::translate::testing {

constexpr auto kDeadline = std::chrono::seconds(10);

inline FramePtr frame_of(const std::string& text) {
  auto frame = std::make_shared<Frame>();
  frame->buffer().append(text.data(), text.size());
  frame->seal();
  return frame;
}

inline std::string text_of(const FramePtr& frame) {
  const auto payload = frame->payload();
  return {reinterpret_cast<const char*>(payload.data), payload.size};
}

/// Two nodes at one master, all on one loop. They carry no mark of a translator for each other: `plain` nodes
/// are what a test makes by hand.
class TwoPeers : public ::testing::Test {
 protected:
  EventLoop loop;
  FramePool frames;
  GraphMaster master{loop};
  std::vector<std::string> log;

  /// Runs the loop until the condition holds; false after the deadline.
  [[nodiscard]] bool until(const std::function<bool()>& condition,
                           std::chrono::nanoseconds at_most = kDeadline) {
    const auto end = EventLoop::now() + at_most;
    while (!condition()) {
      if (EventLoop::now() > end) return false;
      loop.run_once(std::chrono::milliseconds(5));
    }
    return true;
  }
  /// Runs the loop for a while, to see that something does not happen.
  void for_a_while(std::chrono::milliseconds time) {
    (void)until([] { return false; }, time);
  }

  [[nodiscard]] PeerParams params(const std::string& name) const {
    PeerParams made;
    made.name = name;
    made.master_uri = master.uri();
    made.advertised_host = "127.0.0.1";
    made.bind_address = "127.0.0.1";
    made.master_period = std::chrono::milliseconds(50);
    made.tcpros.retry_first = std::chrono::milliseconds(20);
    made.tcpros.retry_last = std::chrono::milliseconds(200);
    return made;
  }
  [[nodiscard]] std::unique_ptr<Peer> make(PeerParams with) {
    Peer::Handlers handlers;
    handlers.on_log = [this](const std::string& line) { log.push_back(line); };
    auto peer = Peer::make(loop, frames, std::move(with), handlers);
    if (!peer) throw std::runtime_error(peer.error().message);
    return std::move(*peer);
  }
  [[nodiscard]] std::unique_ptr<Peer> make(const std::string& name) { return make(params(name)); }
};

}  // namespace extperfc::translate::testing
