#include "translate/plan/runner.hpp"

#include <algorithm>
#include <cstring>
#include <functional>

#include "translate/plan/numbers.hpp"
#include "translate/plan/pose.hpp"
#include "translate/plan/scratch.hpp"

namespace extperfc::translate {

namespace {

constexpr std::size_t kCount = sizeof(std::uint32_t);

std::uint32_t load_count(const std::uint8_t* bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes, kCount);
  return count;
}

constexpr std::size_t kStampSize = 8;
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

/// A time or duration is shown by its seconds.
std::string value_text(Primitive primitive, const std::uint8_t* bytes) {
  if (primitive == Primitive::kTime) return number_text(Primitive::kUint32, bytes) + " s";
  if (primitive == Primitive::kDuration) return number_text(Primitive::kInt32, bytes) + " s";
  return number_text(primitive, bytes);
}

}  // namespace

Runner::Runner(const Code& code, ByteView source, Output& out, std::int64_t time_shift_ns, Failure& failure)
    : code_(code),
      at_(source.data),
      anchor_(source.data),
      end_(source.data + source.size),
      out_(out),
      time_shift_ns_(time_shift_ns),
      failure_(failure) {
}  // NOLINT(cppcoreguidelines-pro-type-member-init): slots are written before they are read

bool Runner::run() {
  static const Op kEnd{};
  const auto* first = code_.ops.data();
  const auto run_all = [&] {
    if (!run(first, first + code_.ops.size())) return false;
    if (at_ != end_) return fail(Failure::Kind::kTrailing, kEnd, left());
    return flush(kEnd);
  };
  bool done = false;
  if (code_.slots <= kInlineSlots) {
    slots_ = inline_slots_.data();
    done = run_all();
  } else {
    ScratchLease lease;
    lease.buffer().reserve(code_.slots * sizeof(const std::uint8_t*));
    slots_ = reinterpret_cast<const std::uint8_t**>(lease.buffer().data());
    done = run_all();
  }
  if (!done) fill_indices();
  return done;
}

bool Runner::run(const Op* op, const Op* last) {
  for (; op < last; ++op)
    if (!step(op)) return false;
  return true;
}

/// Instructions that scan, and those that change which one is next.
inline bool Runner::step(const Op*& op) {
  const Op& now = *op;
  switch (now.code) {
    case OpCode::kSkip:
      return skip(now.size, now);
    case OpCode::kSkipArray:
      return skip_array(now);
    case OpCode::kSkipStrings:
      return skip_strings(now);
    case OpCode::kLoop:
      op += now.body;
      return loop(now);
    case OpCode::kRepeat:
      op += now.body;
      return repeat(now, now.size);
    case OpCode::kFlush:
      return flush(now);
    case OpCode::kAnchor:
      anchor_ = at_;
      return true;
    case OpCode::kMark:
      slots_[now.extra] = at_;
      return true;
    case OpCode::kSeek:
      return seek(now);
    case OpCode::kIndex:
      return index(op);
    case OpCode::kJump:
      op = code_.ops.data() + now.extra - 1;
      return true;
    case OpCode::kMap:
      return map(op);
    case OpCode::kChain:
      op += now.body;
      return chain(now);
    default:
      return write(now);
  }
}

/// Instructions that write something else than they read.
bool Runner::write(const Op& op) {
  std::uint32_t count = 0;
  switch (op.code) {
    case OpCode::kEmit:
      return emit(op, code_.constants.data() + op.extra, op.size);
    case OpCode::kZero:
      return zero(op, op.size);
    case OpCode::kZeroArray:
      return zero_array(op);
    case OpCode::kExpectCount:
      return expect_count(op);
    case OpCode::kNumbers:
      return flush(op) && numbers(op, op.size);
    case OpCode::kNumbersArray:
      return open_array(op, *size_of(op.from), count) && numbers(op, count);
    case OpCode::kShift:
      return flush(op) && shift(op, op.size);
    case OpCode::kShiftArray:
      return open_array(op, *size_of(op.from), count) && shift(op, count);
    case OpCode::kSlash:
      return slash(op);
    case OpCode::kSignedTime:
      return flush(op) && signed_time(op);
    case OpCode::kPoses:
      return flush(op) && poses(op, op.size);
    case OpCode::kPosesArray:
      return open_array(op, kPoseSize, count) && poses(op, count);
    default:
      return fail(Failure::Kind::kValue, op);  // no such code: the compiler writes none
  }
}

inline bool Runner::skip(std::size_t bytes, const Op& op) {
  if (left() < bytes) return fail(Failure::Kind::kEnds, op, left(), bytes);
  at_ += bytes;
  return true;
}

inline bool Runner::read_count(std::size_t min_size, const Op& op, std::uint32_t& count) {
  if (left() < kCount) return fail(Failure::Kind::kEnds, op, left(), kCount);
  count = load_count(at_);
  at_ += kCount;
  if (static_cast<std::uint64_t>(count) * min_size > left())
    return fail(Failure::Kind::kCount, op, count, left());
  return true;
}

inline bool Runner::skip_array(const Op& op) {
  std::uint32_t count = 0;
  if (!read_count(op.size, op, count)) return false;
  at_ += static_cast<std::size_t>(count) * op.size;
  return true;
}

inline bool Runner::skip_strings(const Op& op) {
  std::uint32_t count = 0;
  if (!read_count(kCount, op, count)) return false;
  const auto* at = at_;
  const auto* end = end_;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto available = static_cast<std::size_t>(end - at);
    const std::size_t size = available < kCount ? 0 : load_count(at);
    if (available < kCount || size > available - kCount) {
      indices_.push_back(i);
      return fail(Failure::Kind::kEnds, op, available, size + kCount);
    }
    at += kCount + size;
  }
  at_ = at;
  return true;
}

bool Runner::loop(const Op& op) {
  std::uint32_t count = 0;
  if (!read_count(op.size, op, count)) return false;
  if (op.extra != 0 && static_cast<std::uint64_t>(count) * op.extra > out_.max_bytes())
    return fail(Failure::Kind::kTooLong, op, 0, out_.max_bytes());
  return repeat(op, count);
}

bool Runner::repeat(const Op& op, std::uint32_t count) {
  const Op* body = &op + 1;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (run(body, body + op.body)) continue;
    indices_.push_back(i);
    return false;
  }
  return true;
}

bool Runner::index(const Op*& op) {
  const Op& now = *op;
  std::uint32_t count = 0;
  if (!read_count(0, now, count)) return false;
  if (now.size >= count) {
    if (now.extra == 0) return fail(Failure::Kind::kIndex, now, count, now.size);
    op = code_.ops.data() + now.extra - 1;
    return true;
  }
  op += now.body;
  return repeat(now, now.size);
}

inline bool Runner::flush(const Op& op) {
  const auto size = static_cast<std::size_t>(at_ - anchor_);
  if (size == 0) return true;
  if (!out_.fits(size)) return fail(Failure::Kind::kTooLong, op, 0, out_.max_bytes());
  std::memcpy(out_.take(size), anchor_, size);
  anchor_ = at_;
  return true;
}

inline bool Runner::seek(const Op& op) {
  if (!flush(op)) return false;
  at_ = anchor_ = slots_[op.extra];
  return true;
}

bool Runner::emit(const Op& op, const void* bytes, std::size_t size) {
  if (!flush(op)) return false;
  if (!out_.fits(size)) return fail(Failure::Kind::kTooLong, op, 0, out_.max_bytes());
  if (size != 0) std::memcpy(out_.take(size), bytes, size);
  return true;
}

inline bool Runner::zero(const Op& op, std::size_t size) {
  if (!flush(op)) return false;
  if (!out_.fits(size)) return fail(Failure::Kind::kTooLong, op, 0, out_.max_bytes());
  if (size != 0) std::memset(out_.take(size), 0, size);
  return true;
}

bool Runner::zero_array(const Op& op) {
  std::uint32_t count = 0;
  return read_count(0, op, count) && zero(op, static_cast<std::size_t>(count) * op.size);
}

bool Runner::expect_count(const Op& op) {
  std::uint32_t count = 0;
  if (!flush(op) || !read_count(0, op, count)) return false;
  anchor_ = at_;
  return count == op.size || fail(Failure::Kind::kLength, op, count, op.size);
}

bool Runner::open_array(const Op& op, std::size_t size, std::uint32_t& count) {
  return read_count(size, op, count) && flush(op);
}

const std::uint8_t* Runner::replace(std::size_t bytes, const Op& op) {
  const auto* begin = at_;
  if (!skip(bytes, op)) return nullptr;
  anchor_ = at_;
  return begin;
}

bool Runner::numbers(const Op& op, std::size_t count) {
  const auto size = *size_of(op.from);
  const auto* source = replace(count * size, op);
  if (source == nullptr) return count == 0 && failure_.kind == Failure::Kind::kNone;
  const auto bytes = count * *size_of(op.to);
  if (!out_.fits(bytes)) return fail(Failure::Kind::kTooLong, op, 0, out_.max_bytes());
  auto* target = out_.take(bytes);
  const bool saturate = (op.flags & kSaturate) != 0;
  const auto fitted =
      (op.flags & kScaled) != 0
          ? scale_numbers(op.from, op.to, saturate, code_.scales[op.extra], source, target, count)
          : convert_numbers(op.from, op.to, saturate, source, target, count);
  return fitted == count || fail_value(op, source + fitted * size, fitted);
}

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

/// Copies a string without its leading slashes, or with one where none was (`kAddSlash`; an empty one stays
/// empty). What was wanted before it is copied first. False after a failure: the bytes end too early, or the
/// output is full.
bool Runner::slash(const Op& op) {
  std::uint32_t count = 0;
  if (!flush(op) || !read_count(1, op, count)) return false;
  const auto* text = at_;
  at_ += count;
  anchor_ = at_;
  const bool add = (op.flags & kAddSlash) != 0;
  std::uint32_t leading = 0;
  if (!add)
    while (leading < count && text[leading] == '/') ++leading;
  const std::uint32_t added = add && count != 0 && text[0] != '/' ? 1 : 0;
  const std::uint32_t size = count - leading + added;
  if (!out_.fits(kCount + size)) return fail(Failure::Kind::kTooLong, op, 0, out_.max_bytes());
  auto* target = out_.take(kCount + size);
  std::memcpy(target, &size, kCount);
  if (added != 0) target[kCount] = '/';
  if (count != leading) std::memcpy(target + kCount + added, text + leading, count - leading);
  return true;
}

bool Runner::map(const Op*& op) {
  const Op& now = *op;
  const bool text = now.from == Primitive::kString;
  const auto* value = at_;
  std::size_t size = text ? kCount : *size_of(now.from);
  if (left() < size) return fail(Failure::Kind::kEnds, now, left(), size);
  if (text) size += load_count(at_);
  if (left() < size) return fail(Failure::Kind::kEnds, now, left(), size);
  constexpr std::uint8_t kTrue = 1;
  if (now.from == Primitive::kBool && *value != 0) value = &kTrue;  // any other bits mean the same
  for (const auto& [key, mapped] : code_.maps[now.extra].entries) {
    if (key.size() != size || std::memcmp(key.data(), value, size) != 0) continue;
    if (!emit(now, mapped.data(), mapped.size())) return false;
    at_ += size;
    anchor_ = at_;
    op += now.body;
    return true;
  }
  return true;
}

bool Runner::poses(const Op& op, std::size_t count) {
  const auto* source = replace(count * kPoseSize, op);
  if (source == nullptr) return count == 0 && failure_.kind == Failure::Kind::kNone;
  if (!out_.fits(count * kPoseSize)) return fail(Failure::Kind::kTooLong, op, 0, out_.max_bytes());
  compose_poses(slots_[op.extra], source, out_.take(count * kPoseSize), count);
  return true;
}

bool Runner::chain(const Op& op) {
  if (!flush(op)) return false;
  const auto* first = at_;
  const Op* body = &op + 1;
  if (!run(body, body + op.body)) return false;
  anchor_ = at_;
  const ByteView part{first, static_cast<std::size_t>(at_ - first)};
  if (run_stages(code_.chains[op.extra], part, out_, time_shift_ns_, failure_)) return true;
  const auto& around = code_.remarks[static_cast<std::size_t>(&op - code_.ops.data())].first;
  failure_.path = failure_.path.empty() ? around : around + "." + failure_.path;
  return false;
}

bool Runner::fail(Failure::Kind kind, const Op& op, std::uint64_t number, std::uint64_t limit) {
  failure_.kind = kind;
  failure_.number = number;
  failure_.limit = limit;
  const auto* first = code_.ops.data();
  const auto* last = first + code_.ops.size();
  if (std::less_equal<>()(first, &op) && std::less<>()(&op, last)) {
    const auto& remark = code_.remarks[static_cast<std::size_t>(&op - first)];
    failure_.path = remark.last.empty() ? remark.first : remark.first + " ... " + remark.last;
  }
  return false;
}

bool Runner::fail_value(const Op& op, const std::uint8_t* value, std::size_t index) {
  failure_.value = value_text(op.from, value) + " does not fit " + to_string(op.to);
  if ((op.flags & kListed) != 0) indices_.push_back(index);
  return fail(Failure::Kind::kValue, op);
}

/// Writes the indices into the brackets of the path, outermost first.
void Runner::fill_indices() {
  auto& path = failure_.path;
  std::size_t from = 0;
  while (!indices_.empty()) {
    const auto brackets = path.find("[]", from);
    if (brackets == std::string::npos) return;
    const auto number = std::to_string(indices_.back());
    path.insert(brackets + 1, number);
    from = brackets + number.size() + 2;
    indices_.pop_back();
  }
}

bool run_stages(const Stages& stages, ByteView source, Output& out, std::int64_t time_shift_ns,
                Failure& failure) {
  if (stages.size() == 1) return Runner(stages.front(), source, out, time_shift_ns, failure).run();
  ScratchLease one;
  ScratchLease other;
  std::array<ByteBuffer*, 2> buffers{&one.buffer(), &other.buffer()};
  for (std::size_t i = 0; i + 1 < stages.size(); ++i) {
    auto& buffer = *buffers[i % 2];
    buffer.clear();
    Output between(buffer, out.max_bytes(), source.size + stages[i].growth);
    if (!Runner(stages[i], source, between, time_shift_ns, failure).run()) return false;
    between.finish();
    source = buffer.view();
  }
  return Runner(stages.back(), source, out, time_shift_ns, failure).run();
}

}  // namespace extperfc::translate
