#include "translate/bridge/latched_store.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "translate/bridge/little_endian.hpp"

namespace extperfc::translate {

void LatchedStore::keep(const std::string& origin, const MessageDefinition& definition, FramePtr frame) {
  forget(origin);
  entries_.push_back({origin, definition, std::move(frame)});
}

void LatchedStore::forget(const std::string& origin) {
  entries_.erase(std::remove_if(entries_.begin(), entries_.end(),
                                [&](const Entry& entry) { return entry.origin == origin; }),
                 entries_.end());
}

std::optional<LatchedStore::Entry> LatchedStore::merged_transforms(FramePool& frames) const {
  if (entries_.size() < 2) return std::nullopt;
  std::size_t bytes = sizeof(std::uint32_t);
  std::uint64_t count = 0;
  for (const auto& entry : entries_) {
    const auto payload = entry.frame->payload();
    if (payload.size < sizeof(std::uint32_t) || entry.definition.md5 != entries_.front().definition.md5)
      return std::nullopt;
    count += load_u32(payload.data);
    bytes += payload.size - sizeof(std::uint32_t);
  }
  if (count > UINT32_MAX) return std::nullopt;
  auto frame = frames.take(bytes);
  auto* out = frame->resize_payload(bytes);
  store_u32(out, static_cast<std::uint32_t>(count));
  out += sizeof(std::uint32_t);
  for (const auto& entry : entries_) {
    const auto payload = entry.frame->payload();
    std::memcpy(out, payload.data + sizeof(std::uint32_t), payload.size - sizeof(std::uint32_t));
    out += payload.size - sizeof(std::uint32_t);
  }
  return Entry{"", entries_.front().definition, std::move(frame)};
}

}  // namespace extperfc::translate
