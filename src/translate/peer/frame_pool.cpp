#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "extperfc/translate/frame.hpp"

namespace extperfc::translate {
namespace {

constexpr std::size_t kBuffers = 256;  ///< kept at most, so that the search stays short

/// The next size of a row with eight steps for each doubling: messages of slightly different size share
/// buffers.
std::size_t round_up(std::size_t size) {
  std::size_t step = 1024;
  while (step < size / 16 && step < (std::size_t{1} << 60U)) step *= 2;
  return (size + step - 1) / step * step;
}

}  // namespace

struct FramePool::Shelf {
  Params params;
  std::size_t bytes{0};
  std::vector<ByteBuffer> buffers;  ///< the one that came last stands last

  /// The smallest that is large enough; not one of more than twice the size, which would waste memory in
  /// queues.
  ByteBuffer get(std::size_t size) {
    auto best = buffers.end();
    for (auto it = buffers.begin(); it != buffers.end(); ++it)
      if (it->capacity() >= size && (best == buffers.end() || it->capacity() <= best->capacity())) best = it;
    if (best == buffers.end() || best->capacity() / 2 > size) return ByteBuffer(round_up(size));
    return remove(best);
  }

  void put(ByteBuffer buffer) {
    const auto size = buffer.capacity();
    if (size < params.smallest_kept || size > params.kept_bytes) return;
    while (!buffers.empty() && (buffers.size() >= kBuffers || size > params.kept_bytes - bytes))
      remove(buffers.begin());
    bytes += size;
    buffer.clear();
    buffers.push_back(std::move(buffer));
  }

  ByteBuffer remove(std::vector<ByteBuffer>::iterator which) {
    bytes -= which->capacity();
    auto taken = std::move(*which);
    std::rotate(which, which + 1, buffers.end());
    buffers.pop_back();
    return taken;
  }
};

FramePool::FramePool(Params params) : shelf_(std::make_shared<Shelf>()) {
  shelf_->params = params;
  shelf_->buffers.reserve(kBuffers);
}

std::shared_ptr<Frame> FramePool::take(std::size_t payload_bytes) {
  const auto size = payload_bytes + Frame::kPrefix;
  if (size < shelf_->params.smallest_kept) return std::make_shared<Frame>(ByteBuffer(size));
  auto frame = std::make_unique<Frame>(shelf_->get(size));
  return {frame.release(), [shelf = shelf_](Frame* done) {
            const std::unique_ptr<Frame> owner(done);
            shelf->put(std::move(owner->buffer()));
          }};
}

std::size_t FramePool::kept_bytes() const {
  return shelf_->bytes;
}

}  // namespace extperfc::translate
