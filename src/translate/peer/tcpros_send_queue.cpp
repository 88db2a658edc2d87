#include "translate/peer/tcpros_send_queue.hpp"

#include <algorithm>
#include <cerrno>

#include <sys/socket.h>
#include <sys/uio.h>

#include "translate/peer/tcpros_socket.hpp"

namespace extperfc::translate {
namespace {

constexpr std::size_t kPartsAtOnce = 64;
/// Bytes of one call of write() before others have their turn.
constexpr std::size_t kWriteAtOnce = 1U << 20U;

}  // namespace

std::size_t SendQueue::begun() const {
  return !entries_.empty() && (offset_ > 0 || entries_.front().header) ? 1 : 0;
}

void SendQueue::push_header(FramePtr header) {
  waiting_bytes_ += header->wire().size;
  entries_.push_back({std::move(header), SteadyTime{}, true});
}

void SendQueue::push(FramePtr frame, SteadyTime since) {
  waiting_bytes_ += frame->wire().size;
  entries_.push_back({std::move(frame), since, false});
  drop_excess();
}

void SendQueue::drop(std::size_t index) {
  const auto at = entries_.begin() + static_cast<std::ptrdiff_t>(index);
  waiting_bytes_ -= at->frame->wire().size;
  entries_.erase(at);
}

void SendQueue::drop_excess() {
  const auto first = begun();
  const auto begun_bytes = first == 0 ? 0 : entries_.front().frame->wire().size;
  const auto max_waiting = std::max<std::size_t>(params_.queue, 1);
  while (entries_.size() > first + 1 &&
         (entries_.size() - first > max_waiting || waiting_bytes_ - begun_bytes > params_.queue_bytes)) {
    drop(first);
    ++stats_.dropped_queue;
  }
}

void SendQueue::drop_aged() {
  if (params_.max_age.count() <= 0 || entries_.empty()) return;
  const auto oldest = EventLoop::now() - params_.max_age;
  for (auto i = begun(); i < entries_.size();) {
    if (entries_[i].since >= oldest) {
      ++i;
      continue;
    }
    drop(i);
    ++stats_.dropped_age;
  }
}

SendQueue::Outcome SendQueue::write(int descriptor) {
  drop_aged();
  std::size_t done = 0;
  while (!entries_.empty()) {
    if (done >= kWriteAtOnce) return Outcome::kBlocked;
    const auto sent = write_some(descriptor);
    if (sent < 0) {
      if (errno == EINTR) continue;
      if (errno != EAGAIN && errno != EWOULDBLOCK) {
        problem_ = errno_text(errno);
        return Outcome::kBroken;
      }
      return Outcome::kBlocked;
    }
    advance(static_cast<std::size_t>(sent));
    done += static_cast<std::size_t>(sent);
  }
  return Outcome::kEmpty;
}

std::ptrdiff_t SendQueue::write_some(int descriptor) const {
  iovec parts[kPartsAtOnce];
  std::size_t count = 0;
  std::size_t offered = 0;
  auto skip = offset_;
  for (auto entry = entries_.begin(); entry != entries_.end() && count < kPartsAtOnce; ++entry) {
    const auto wire = entry->frame->wire();
    parts[count++] = {const_cast<std::uint8_t*>(wire.data) + skip, wire.size - skip};
    offered += wire.size - skip;
    skip = 0;
    if (offered >= kWriteAtOnce) break;
  }
  msghdr message{};
  message.msg_iov = parts;
  message.msg_iovlen = count;
  return ::sendmsg(descriptor, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
}

void SendQueue::advance(std::size_t count) {
  written_ += count;
  while (count > 0) {
    const auto& entry = entries_.front();
    const auto size = entry.frame->wire().size;
    const auto rest = size - offset_;
    if (count < rest) {
      offset_ += count;
      return;
    }
    count -= rest;
    offset_ = 0;
    waiting_bytes_ -= size;
    if (!entry.header) {
      ++stats_.messages;
      stats_.bytes += size - Frame::kPrefix;
    }
    entries_.pop_front();
  }
}

LinkStats SendQueue::stats() const {
  auto stats = stats_;
  stats.waiting = entries_.size();
  return stats;
}

}  // namespace extperfc::translate
