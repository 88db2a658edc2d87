#pragma once

#include <functional>
#include <string>
#include <vector>

#include "extperfc/translate/event_loop.hpp"

#include "translate/peer/tcpros_socket.hpp"

namespace extperfc::translate {

/// Reports network interfaces that lose their carrier (a cable is pulled, a radio link ends) or are switched
/// off. From then on the kernel keeps packets for up to 3 s in the queue of a neighbour whose address it asks
/// for, and sends them when the carrier is back: closing their connection does not recall them. Without a
/// netlink socket nothing is ever reported. Of the loop's thread. Source: rtnetlink(7), arp(7).
class CarrierMonitor {
 public:
  /// `on_loss` gets the numeric addresses of the interface.
  CarrierMonitor(EventLoop& loop, std::function<void(const std::vector<std::string>& addresses)> on_loss);

 private:
  void read();

  std::function<void(const std::vector<std::string>&)> on_loss_;
  LoopSocket socket_;
};

}  // namespace extperfc::translate
