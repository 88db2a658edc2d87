#include <algorithm>
#include <cstring>

#include "translate/plan/runner.hpp"

namespace extperfc::translate::plan {

namespace {

constexpr std::size_t kStampSize = 8;
constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
constexpr std::int64_t kMaxSeconds = 0xFFFFFFFF;
constexpr std::int64_t kMaxNanoseconds = kMaxSeconds * kNanosecondsPerSecond + kNanosecondsPerSecond - 1;

struct Stamp {
  std::uint32_t seconds{0};
  std::uint32_t nanoseconds{0};
};
static_assert(sizeof(Stamp) == kStampSize);

/// The stamp later by `by_ns`, within what a stamp can say. Zero means "no time" and stays.
Stamp shifted(Stamp stamp, std::int64_t by_ns) {
  if (stamp.seconds == 0 && stamp.nanoseconds == 0) return stamp;
  const std::int64_t before = stamp.seconds * kNanosecondsPerSecond + stamp.nanoseconds;
  std::int64_t after = 0;
  if (__builtin_add_overflow(before, by_ns, &after)) after = by_ns > 0 ? kMaxNanoseconds : 0;
  after = std::clamp<std::int64_t>(after, 0, kMaxNanoseconds);
  return {static_cast<std::uint32_t>(after / kNanosecondsPerSecond),
          static_cast<std::uint32_t>(after % kNanosecondsPerSecond)};
}

}  // namespace

bool Runner::shift(const Op& op, std::size_t count) {
  const auto size = count * kStampSize;
  if (left() < size) return fail(Failure::Kind::kEnds, op, left(), size);
  if (!out_.fits(size)) return fail(Failure::Kind::kTooLong, op, 0, out_.max_bytes());
  auto* target = out_.take(size);
  if (time_shift_ns_ == 0) {
    if (size != 0) std::memcpy(target, at_, size);
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      Stamp stamp;
      std::memcpy(&stamp, at_ + i * kStampSize, kStampSize);
      stamp = shifted(stamp, time_shift_ns_);
      std::memcpy(target + i * kStampSize, &stamp, kStampSize);
    }
  }
  at_ += size;
  anchor_ = at_;
  return true;
}

/// Both are two numbers of 32 bits; a time has no sign, so each may lack the other's values.
bool Runner::signed_time(const Op& op) {
  const auto* source = replace(kStampSize, op);
  if (source == nullptr) return false;
  if ((source[3] & 0x80U) != 0) {  // the seconds' sign, or more seconds than a duration has
    if ((op.flags & kSaturate) == 0) return fail_value(op, source, 0);
    const bool to_time = op.to == Primitive::kTime;
    const Stamp nearest = to_time ? Stamp{} : Stamp{0x7FFFFFFF, kNanosecondsPerSecond - 1};
    return emit(op, &nearest, kStampSize);
  }
  return emit(op, source, kStampSize);
}

}  // namespace extperfc::translate::plan
