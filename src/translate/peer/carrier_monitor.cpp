#include "translate/peer/carrier_monitor.hpp"

#include <array>
#include <memory>
#include <utility>

#include <ifaddrs.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <netdb.h>
#include <sys/epoll.h>
#include <sys/socket.h>

namespace extperfc::translate {
namespace {

constexpr unsigned kLowerUp = 1U << 16U;  // IFF_LOWER_UP of linux/if.h, which cannot stand beside net/if.h

/// The number of the interface that this message reports as without a carrier; 0: none.
unsigned lost_interface(const nlmsghdr& message) {
  if (message.nlmsg_type != RTM_NEWLINK || message.nlmsg_len < NLMSG_LENGTH(sizeof(ifinfomsg))) return 0;
  const auto& link = *static_cast<const ifinfomsg*>(NLMSG_DATA(&message));
  const bool works = (link.ifi_flags & IFF_UP) != 0 && (link.ifi_flags & kLowerUp) != 0;
  return works ? 0 : static_cast<unsigned>(link.ifi_index);
}

std::vector<std::string> addresses_of(unsigned interface) {
  std::vector<std::string> addresses;
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return addresses;
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owned(list, ::freeifaddrs);
  for (const auto* one = list; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || ::if_nametoindex(one->ifa_name) != interface) continue;
    const auto family = one->ifa_addr->sa_family;
    if (family != AF_INET && family != AF_INET6) continue;
    const socklen_t size = family == AF_INET ? sizeof(sockaddr_in) : sizeof(sockaddr_in6);
    std::array<char, NI_MAXHOST> text{};
    if (::getnameinfo(one->ifa_addr, size, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST) == 0)
      addresses.emplace_back(text.data());
  }
  return addresses;
}

}  // namespace

CarrierMonitor::CarrierMonitor(EventLoop& loop,
                               std::function<void(const std::vector<std::string>& addresses)> on_loss)
    : on_loss_(std::move(on_loss)),
      socket_(::socket(AF_NETLINK, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, NETLINK_ROUTE)) {
  sockaddr_nl address{};
  address.nl_family = AF_NETLINK;
  address.nl_groups = RTMGRP_LINK;
  const bool bound =
      socket_ && ::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  if (bound) socket_.watch(loop, EPOLLIN, Priority::kControl, [this](std::uint32_t) { read(); });
}

void CarrierMonitor::read() {
  alignas(nlmsghdr) std::array<char, 32768> bytes{};
  const auto got = ::recv(socket_.get(), bytes.data(), bytes.size(), 0);
  if (got <= 0) return;
  auto left = static_cast<unsigned>(got);
  for (auto* message = reinterpret_cast<nlmsghdr*>(bytes.data()); NLMSG_OK(message, left);
       message = NLMSG_NEXT(message, left)) {
    const auto interface = lost_interface(*message);
    if (interface != 0) on_loss_(addresses_of(interface));
  }
}

}  // namespace extperfc::translate
