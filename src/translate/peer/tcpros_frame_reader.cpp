#include "translate/peer/tcpros_frame_reader.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>

#include <sys/uio.h>

#include "translate/peer/tcpros_socket.hpp"

namespace extperfc::translate {
namespace {

/// After a message of this size the next one is expected to be large too: only its length is read ahead, and
/// all of its content goes into its frame without a copy.
constexpr std::size_t kLarge = 32U << 10U;

}  // namespace

FrameReader::FrameReader(FramePool& pool, ByteBuffer& scratch, Params params)
    : pool_(pool), scratch_(scratch), params_(params) {
  scratch_.resize(std::max(scratch_.size(), kScratch));
}

std::size_t FrameReader::read_ahead() const {
  if (params_.exact) return frame_ ? 0 : head_size() - head_filled_;
  return size_ >= kLarge ? head_size() - head_filled_ : kScratch;
}

std::ptrdiff_t FrameReader::receive(int descriptor, std::size_t into_frame, std::size_t into_scratch) {
  iovec parts[2];
  int count = 0;
  if (into_frame > 0) parts[count++] = {frame_->buffer().data() + Frame::kPrefix + filled_, into_frame};
  if (into_scratch > 0) parts[count++] = {scratch_.data(), into_scratch};
  for (;;) {
    const auto got = ::readv(descriptor, parts, count);
    if (got >= 0 || errno != EINTR) return got;
  }
}

FrameReader::Outcome FrameReader::read(int descriptor, std::size_t at_most, const Sink& sink) {
  for (std::size_t done = 0; done < at_most;) {
    const auto rest = frame_ ? size_ - filled_ : 0;
    const auto into_frame = std::min(rest, at_most - done);
    const auto into_scratch = into_frame == rest ? read_ahead() : 0;
    const auto got = receive(descriptor, into_frame, into_scratch);
    if (got == 0) return closed("the other end closed the connection");
    if (got < 0)
      return errno == EAGAIN || errno == EWOULDBLOCK ? Outcome::kWaiting : closed(errno_text(errno));
    done += static_cast<std::size_t>(got);
    const auto outcome = take(into_frame, static_cast<std::size_t>(got), sink);
    if (outcome != Outcome::kWaiting) return outcome;
    if (static_cast<std::size_t>(got) < into_frame + into_scratch) return Outcome::kWaiting;
  }
  return Outcome::kWaiting;
}

FrameReader::Outcome FrameReader::closed(std::string problem) {
  const bool amid = frame_ != nullptr || head_filled_ > 0;
  problem_ = std::move(problem) + (amid ? " in the middle of a message" : "");
  return Outcome::kClosed;
}

FrameReader::Outcome FrameReader::take(std::size_t into_frame, std::size_t got, const Sink& sink) {
  const auto received = EventLoop::now();
  const auto here = std::min(got, into_frame);
  filled_ += here;
  if (frame_ && filled_ == size_ && !deliver(sink, received)) return Outcome::kStopped;
  return cut(scratch_.data(), got - here, sink, received);
}

FrameReader::Outcome FrameReader::cut(const std::uint8_t* bytes, std::size_t count, const Sink& sink,
                                      SteadyTime received) {
  while (count > 0) {
    if (!frame_) {
      const auto part = std::min(count, head_size() - head_filled_);
      std::memcpy(head_.data() + head_filled_, bytes, part);
      head_filled_ += part;
      bytes += part;
      count -= part;
      if (head_filled_ < head_size()) return Outcome::kWaiting;
      if (!begin_frame()) return Outcome::kBroken;
    }
    const auto part = std::min(count, size_ - filled_);
    if (part > 0) std::memcpy(frame_->buffer().data() + Frame::kPrefix + filled_, bytes, part);
    filled_ += part;
    bytes += part;
    count -= part;
    if (filled_ == size_ && !deliver(sink, received)) return Outcome::kStopped;
  }
  return Outcome::kWaiting;
}

bool FrameReader::begin_frame() {
  const auto* at = head_.data() + (head_size() - Frame::kPrefix);
  std::uint32_t size = 0;
  for (unsigned i = 0; i < Frame::kPrefix; ++i) size |= static_cast<std::uint32_t>(at[i]) << (8U * i);
  if (size > params_.message_bytes) {
    problem_ = "it sent a message of " + std::to_string(size) + " bytes; the maximum is " +
               std::to_string(params_.message_bytes);
    return false;
  }
  try {
    frame_ = pool_.take(size);
    frame_->resize_payload(size);
  } catch (const std::bad_alloc&) {
    problem_ = "no memory for a message of " + std::to_string(size) + " bytes";
    return false;
  }
  size_ = size;
  filled_ = 0;
  return true;
}

bool FrameReader::deliver(const Sink& sink, SteadyTime received) {
  const auto status = params_.status_byte ? head_[0] : std::uint8_t{1};
  head_filled_ = 0;
  return sink(std::move(frame_), status, received);
}

}  // namespace extperfc::translate
