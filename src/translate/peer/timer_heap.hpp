#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

namespace extperfc::translate {

/// Tasks by time. add and remove cost O(log n); removed entries leave the heap later, but never outnumber the
/// others by much.
class TimerHeap {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Task = std::function<void()>;

  std::uint64_t add(Time when, Task task) {
    const auto id = ++last_id_;
    tasks_.emplace(id, std::move(task));
    heap_.push_back({when, id});
    std::push_heap(heap_.begin(), heap_.end(), later);
    return id;
  }

  void remove(std::uint64_t id) {
    const auto found = tasks_.find(id);
    if (found == tasks_.end()) return;
    const auto task = std::move(found->second);  // dies last: what it owns may call us
    tasks_.erase(found);
    if (heap_.size() > 2 * tasks_.size() + 64) forget_removed();
  }

  /// When the first task is due; nothing when there is none.
  [[nodiscard]] std::optional<Time> next() {
    while (!heap_.empty() && tasks_.count(heap_.front().id) == 0) pop();
    return heap_.empty() ? std::nullopt : std::optional<Time>(heap_.front().when);
  }

  /// Runs, in order of time, what is due now; what those tasks add waits for the next call.
  void run_due(Time now) {
    const auto last = last_id_;
    std::vector<Entry> later_ones;
    for (auto due = next(); due && *due <= now; due = next()) {
      const auto entry = heap_.front();
      pop();
      if (entry.id > last) {
        later_ones.push_back(entry);
        continue;
      }
      const auto found = tasks_.find(entry.id);
      const auto task = std::move(found->second);
      tasks_.erase(found);
      task();
    }
    for (const auto& entry : later_ones) {
      heap_.push_back(entry);
      std::push_heap(heap_.begin(), heap_.end(), later);
    }
  }

  /// Forgets everything; how many tasks there were.
  std::size_t clear() {
    const auto tasks = std::exchange(tasks_, {});
    heap_.clear();
    return tasks.size();
  }

 private:
  struct Entry {
    Time when;
    std::uint64_t id;
  };
  static bool later(const Entry& a, const Entry& b) {
    return a.when != b.when ? a.when > b.when : a.id > b.id;
  }
  void pop() {
    std::pop_heap(heap_.begin(), heap_.end(), later);
    heap_.pop_back();
  }
  void forget_removed() {
    heap_.erase(std::remove_if(heap_.begin(), heap_.end(),
                               [this](const Entry& entry) { return tasks_.count(entry.id) == 0; }),
                heap_.end());
    std::make_heap(heap_.begin(), heap_.end(), later);
  }

  std::vector<Entry> heap_;
  std::unordered_map<std::uint64_t, Task> tasks_;
  std::uint64_t last_id_{0};
};

}  // namespace extperfc::translate
