#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "extperfc/translate/bytes.hpp"

namespace extperfc::translate {

/// One message as it travels in TCPROS: its length (uint32, little endian), then the serialized message.
/// Filled once, then shared: the same frame goes from the socket that received it to every socket that sends
/// it, without a copy in user space.
class Frame {
 public:
  static constexpr std::size_t kPrefix = 4;

  Frame() { buffer_.resize(kPrefix); }
  explicit Frame(ByteBuffer buffer) : buffer_(std::move(buffer)) { buffer_.resize(kPrefix); }

  /// Makes room for a payload of that size (uninitialised) and writes the prefix.
  std::uint8_t* resize_payload(std::size_t size) {
    buffer_.resize(kPrefix + size);
    seal();
    return buffer_.data() + kPrefix;
  }
  /// For writers that append: what they append is the payload; seal() afterwards writes the prefix.
  [[nodiscard]] ByteBuffer& buffer() { return buffer_; }
  void seal() {
    const auto size = static_cast<std::uint32_t>(buffer_.size() - kPrefix);
    for (unsigned i = 0; i < kPrefix; ++i) buffer_.data()[i] = static_cast<std::uint8_t>(size >> (8U * i));
  }

  [[nodiscard]] ByteView payload() const { return {buffer_.data() + kPrefix, buffer_.size() - kPrefix}; }
  [[nodiscard]] ByteView wire() const { return buffer_.view(); }

 private:
  ByteBuffer buffer_;
};

using FramePtr = std::shared_ptr<const Frame>;

/// Frames whose memory is used again, so that a stream of large messages does not map and fault fresh pages
/// for each. Not thread-safe: of one event loop. A frame may outlive the pool.
class FramePool {
 public:
  struct Params {
    std::size_t kept_bytes{64U << 20U};  ///< capacity that is kept for later at most [bytes]
    std::size_t smallest_kept{
        16U << 10U};  ///< smaller buffers go back to the heap, which is quick enough [bytes]
  };

  FramePool() : FramePool(Params{}) {}
  explicit FramePool(Params params);

  /// An empty frame with room for `payload_bytes` at least.
  [[nodiscard]] std::shared_ptr<Frame> take(std::size_t payload_bytes);
  /// Capacity that waits to be used again now [bytes].
  [[nodiscard]] std::size_t kept_bytes() const;

 private:
  struct Shelf;
  std::shared_ptr<Shelf> shelf_;
};

}  // namespace extperfc::translate
