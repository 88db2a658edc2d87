#include "translate/plan/scratch.hpp"

#include <memory>
#include <vector>

namespace extperfc::translate {

namespace {

constexpr std::size_t kKeptBytes =
    4U << 20U;  // of one buffer: a rare large message does not hold memory for good

struct Stack {
  std::vector<std::unique_ptr<ByteBuffer>> buffers;
  std::size_t used{0};
};

Stack& stack() {
  thread_local Stack of_thread;
  return of_thread;
}

}  // namespace

ScratchLease::ScratchLease() {
  auto& all = stack();
  if (all.used == all.buffers.size()) all.buffers.push_back(std::make_unique<ByteBuffer>());
  buffer_ = all.buffers[all.used++].get();
  buffer_->clear();
}

ScratchLease::~ScratchLease() {
  --stack().used;
  if (buffer_->capacity() > kKeptBytes) *buffer_ = ByteBuffer();
}

}  // namespace extperfc::translate
