#include "navigate/global/bucket_queue.hpp"

#include <algorithm>

namespace extperfc::navigate {

namespace {

constexpr float kMaxBuckets = 1 << 22;  // keys beyond share the last one
constexpr std::int32_t kEnd = -1;

}  // namespace

void BucketQueue::clear(float first_key, float width) {
  heads_.clear();
  links_.clear();
  unused_ = kEnd;
  cursor_ = size_ = 0;
  first_key_ = first_key;
  per_width_ = 1 / width;
}

void BucketQueue::push(float key, std::int32_t value) {
  const float wanted = std::clamp((key - first_key_) * per_width_, 0.0F, kMaxBuckets);
  const std::size_t bucket = std::max(static_cast<std::size_t>(wanted), cursor_);
  if (bucket >= heads_.size()) heads_.resize(bucket + bucket / 4 + 64, kEnd);
  std::int32_t link = unused_;
  if (link == kEnd) {
    link = static_cast<std::int32_t>(links_.size());
    links_.push_back({{key, value}, heads_[bucket]});
  } else {
    Link& reused = links_[static_cast<std::size_t>(link)];
    unused_ = reused.next;
    reused = {{key, value}, heads_[bucket]};
  }
  heads_[bucket] = link;
  ++size_;
}

BucketQueue::Entry BucketQueue::pop() {
  while (heads_[cursor_] == kEnd) ++cursor_;
  const std::int32_t index = heads_[cursor_];
  Link& link = links_[static_cast<std::size_t>(index)];
  heads_[cursor_] = link.next;
  link.next = unused_;
  unused_ = index;
  --size_;
  return link.entry;
}

}  // namespace extperfc::navigate
