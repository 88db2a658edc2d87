#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <optional>
#include <utility>

namespace extperfc {

/// Pairs items of a slow stream (results) with the item of a fast stream (images) nearest in time.
///
/// Unlike a symmetric approximate synchroniser it never waits for a later image once one lies within the
/// tolerance, so a pair leaves as soon as both halves are there. Both sides are bounded; what falls out
/// unmatched is counted. One thread at a time. Stamps are nanoseconds.
template <typename Slow, typename Fast>
class StampMatcher {
 public:
  struct Limits {
    std::int64_t tolerance_ns{0};
    std::size_t fast_kept{30};  ///< images remembered: delay of the slow stream x image rate, with a margin
    std::size_t slow_kept{5};   ///< results that wait for their image
  };
  using Pair = std::pair<Slow, Fast>;

  explicit StampMatcher(Limits limits) : limits_(limits) {}

  /// A result: returned with its image when that is known; otherwise kept while its image may still come.
  std::optional<Pair> add_slow(std::int64_t stamp_ns, Slow item) {
    reset_if_backwards(stamp_ns, newest_slow_ns_);
    newest_slow_ns_ = stamp_ns;
    if (const Fast* match = nearest(stamp_ns)) return Pair(std::move(item), *match);
    if (newest_fast_ns_ && *newest_fast_ns_ > stamp_ns + limits_.tolerance_ns) {
      ++unmatched_;  // images are already past it
      return std::nullopt;
    }
    waiting_.push_back({stamp_ns, std::move(item)});
    if (waiting_.size() > limits_.slow_kept) drop_oldest_waiting();
    return std::nullopt;
  }

  /// An image: returns the waiting result that it completes, if any.
  std::optional<Pair> add_fast(std::int64_t stamp_ns, Fast item) {
    reset_if_backwards(stamp_ns, newest_fast_ns_);
    newest_fast_ns_ = stamp_ns;
    std::optional<Pair> completed;
    while (!waiting_.empty() && waiting_.front().stamp_ns <= stamp_ns + limits_.tolerance_ns) {
      if (!completed && within(waiting_.front().stamp_ns, stamp_ns)) {
        completed.emplace(std::move(waiting_.front().item), item);
        waiting_.pop_front();
      } else if (waiting_.front().stamp_ns + limits_.tolerance_ns < stamp_ns) {
        drop_oldest_waiting();
      } else {
        break;
      }
    }
    recent_.push_back({stamp_ns, std::move(item)});
    if (recent_.size() > limits_.fast_kept) recent_.pop_front();
    return completed;
  }

  /// Results that no image was found for.
  [[nodiscard]] std::uint64_t unmatched() const { return unmatched_; }

 private:
  template <typename T>
  struct Stamped {
    std::int64_t stamp_ns;
    T item;
  };

  [[nodiscard]] bool within(std::int64_t a, std::int64_t b) const {
    return std::llabs(a - b) <= limits_.tolerance_ns;
  }

  const Fast* nearest(std::int64_t stamp_ns) const {
    const Stamped<Fast>* best = nullptr;
    for (const auto& candidate : recent_)
      if (within(candidate.stamp_ns, stamp_ns) &&
          (!best || std::llabs(candidate.stamp_ns - stamp_ns) < std::llabs(best->stamp_ns - stamp_ns)))
        best = &candidate;
    return best ? &best->item : nullptr;
  }

  void drop_oldest_waiting() {
    waiting_.pop_front();
    ++unmatched_;
  }

  /// Time that jumps back by more than a second is a bag that starts again: what is remembered belongs to
  /// another time.
  void reset_if_backwards(std::int64_t stamp_ns, const std::optional<std::int64_t>& newest) {
    constexpr std::int64_t kJumpNs = 1'000'000'000;
    if (!newest || stamp_ns >= *newest - kJumpNs) return;
    unmatched_ += waiting_.size();
    waiting_.clear();
    recent_.clear();
    newest_fast_ns_.reset();
    newest_slow_ns_.reset();
  }

  Limits limits_;
  std::deque<Stamped<Fast>> recent_;
  std::deque<Stamped<Slow>> waiting_;
  std::optional<std::int64_t> newest_fast_ns_;
  std::optional<std::int64_t> newest_slow_ns_;
  std::uint64_t unmatched_{0};
};

}  // namespace extperfc
