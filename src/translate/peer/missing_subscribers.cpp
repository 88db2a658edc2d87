#include "translate/peer/missing_subscribers.hpp"

#include <algorithm>
#include <utility>

namespace extperfc::translate {

void MissingSubscribers::expect(const std::string& name) {
  const bool was_empty = names_.empty();
  if (names_.size() < kMax) names_.insert(name);
  if (!was_empty) return;
  calls_ = 0;
  delay_ = first_;
  arm(delay_);
}

void MissingSubscribers::forget(const std::string& name) {
  names_.erase(name);
  if (names_.empty()) clear();
}

void MissingSubscribers::clear() {
  names_.clear();
  loop_.cancel(std::exchange(timer_, 0));
}

void MissingSubscribers::hurry() {
  if (names_.empty()) return;
  calls_ = 0;
  delay_ = std::min(kSoon, first_);
  arm(delay_);
}

void MissingSubscribers::arm(std::chrono::milliseconds delay) {
  loop_.cancel(timer_);
  timer_ = loop_.after(delay, [this] { call(); });
}

void MissingSubscribers::call() {
  timer_ = 0;
  ++calls_;
  delay_ = delay_ < first_ ? first_ : std::min(2 * delay_, last_);
  arm(delay_);
  call_();
}

}  // namespace extperfc::translate
