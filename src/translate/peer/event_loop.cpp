#include "extperfc/translate/event_loop.hpp"

#include <array>
#include <atomic>
#include <cerrno>
#include <deque>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include "translate/peer/timer_heap.hpp"

namespace extperfc::translate {
namespace {

using std::chrono::nanoseconds;

constexpr int kFetched = 1024;  ///< events of one epoll_wait
/// How long normal and bulk handlers go on before control descriptors are looked at again.
constexpr std::chrono::microseconds kHandlingTime{100};
constexpr std::size_t kPriorities = 3;
constexpr std::uint32_t kAlways = EPOLLERR | EPOLLHUP;

/// What epoll hands back for our own descriptors; watches begin at generation 1.
constexpr std::uint64_t kWakeTag = 0;
constexpr std::uint64_t kTimerTag = 1;

struct Watch {
  std::uint32_t generation{0};
  std::uint32_t events{0};
  Priority priority{Priority::kNormal};
  bool pending{false};     ///< stands in a queue of ready ones
  std::uint32_t ready{0};  ///< events that wait to be handled
  EventLoop::Handler handler;
};

struct Ready {
  int descriptor;
  std::uint32_t generation;
};

std::uint64_t tag_of(int descriptor, std::uint32_t generation) {
  return (static_cast<std::uint64_t>(generation) << 32U) | static_cast<std::uint32_t>(descriptor);
}

int checked(int result, const char* what) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), what);
  return result;
}

/// Milliseconds for epoll, rounded up so that nothing comes early.
int milliseconds_up(nanoseconds time) {
  constexpr std::int64_t kLongest = 3'600'000;
  if (time <= nanoseconds::zero()) return 0;
  const auto ms = (time.count() - 1) / 1'000'000 + 1;
  return static_cast<int>(ms < kLongest ? ms : kLongest);
}

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { ::close(number_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return number_; }

 private:
  int number_;
};

}  // namespace

struct EventLoop::State {
  State()
      : epoll(checked(::epoll_create1(EPOLL_CLOEXEC), "epoll_create1")),
        wake(checked(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK), "eventfd")),
        timer(checked(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK), "timerfd_create")) {
    add_own(wake.get(), kWakeTag);
    add_own(timer.get(), kTimerTag);
  }

  void add_own(int descriptor, std::uint64_t tag) const {
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.u64 = tag;
    checked(::epoll_ctl(epoll.get(), EPOLL_CTL_ADD, descriptor, &event), "epoll_ctl");
  }

  [[nodiscard]] Watch* find(int descriptor) {
    const auto index = static_cast<std::size_t>(descriptor);
    return descriptor >= 0 && index < watches.size() ? watches[index].get() : nullptr;
  }
  [[nodiscard]] Watch* find(const Ready& ready) {
    auto* watch = find(ready.descriptor);
    return watch != nullptr && watch->generation == ready.generation ? watch : nullptr;
  }

  /// Handlers live until the round's end, because the one that is running may have removed itself.
  void bury(std::unique_ptr<Watch>& watch) {
    if (watch) removed.push_back(std::move(watch));
  }
  void clear_removed() {
    while (!removed.empty()) {  // what a handler owned may remove others
      const auto gone = std::exchange(removed, {});
    }
  }

  bool update_epoll(int descriptor, const Watch& watch) const {
    epoll_event event{};
    event.events = watch.events;
    event.data.u64 = tag_of(descriptor, watch.generation);
    if (::epoll_ctl(epoll.get(), EPOLL_CTL_ADD, descriptor, &event) == 0) return true;
    return errno == EEXIST && ::epoll_ctl(epoll.get(), EPOLL_CTL_MOD, descriptor, &event) == 0;
  }

  void mark_ready(int descriptor, Watch& watch, std::uint32_t events) {
    watch.ready |= events;
    if (std::exchange(watch.pending, true)) return;
    pending[static_cast<std::size_t>(watch.priority)].push_back({descriptor, watch.generation});
  }

  [[nodiscard]] bool work_waits() {
    for (const auto& queue : pending)
      if (!queue.empty()) return true;
    const std::lock_guard lock(mutex);
    return !posted.empty();
  }

  void arm_timer() {
    const auto next = timers.next();
    if (!next || (armed && *armed <= *next)) return;
    const auto since_boot = std::chrono::duration_cast<nanoseconds>(next->time_since_epoch()).count();
    itimerspec when{};
    when.it_value.tv_sec = since_boot / 1'000'000'000;
    when.it_value.tv_nsec = since_boot > 0 ? since_boot % 1'000'000'000 : 1;
    if (::timerfd_settime(timer.get(), TFD_TIMER_ABSTIME, &when, nullptr) == 0) armed = next;
  }

  void wait(nanoseconds at_most) {
    arm_timer();
    const int timeout = work_waits() || stopping ? 0 : milliseconds_up(at_most);
    const int count = ::epoll_wait(epoll.get(), fetched.data(), kFetched, timeout);
    for (int i = 0; i < count; ++i) sort_in(fetched[static_cast<std::size_t>(i)]);
  }

  void sort_in(const epoll_event& event) {
    std::uint64_t ignored = 0;
    if (event.data.u64 == kWakeTag) {
      [[maybe_unused]] const auto read = ::read(wake.get(), &ignored, sizeof ignored);
    } else if (event.data.u64 == kTimerTag) {
      [[maybe_unused]] const auto read = ::read(timer.get(), &ignored, sizeof ignored);
      armed.reset();
    } else {
      const Ready ready{static_cast<int>(event.data.u64 & 0xffffffffU),
                        static_cast<std::uint32_t>(event.data.u64 >> 32U)};
      if (auto* watch = find(ready)) mark_ready(ready.descriptor, *watch, event.events);
    }
  }

  /// Handles the first of a queue.
  void handle_one(std::deque<Ready>& queue) {
    const auto ready = queue.front();
    queue.pop_front();
    auto* watch = find(ready);
    if (watch == nullptr) return;
    watch->pending = false;
    const auto events = std::exchange(watch->ready, 0U) & (watch->events | kAlways);
    if (events != 0) watch->handler(events);
  }

  /// Control first, all of it; then normal and bulk for kHandlingTime, at least one of each.
  void handle_ready() {
    auto& [control, normal, bulk] = pending;
    for (auto left = control.size(); left > 0 && !control.empty(); --left) handle_one(control);
    const auto end = now() + kHandlingTime;
    for (auto* queue : {&normal, &bulk})
      for (auto left = queue->size(); left > 0 && !queue->empty(); --left) {
        handle_one(*queue);
        if (now() >= end) break;
      }
  }

  void run_posted() {
    std::vector<std::function<void()>> tasks;
    {
      const std::lock_guard lock(mutex);
      tasks.swap(posted);
    }
    for (auto& task : tasks) task();
  }

  void wake_up() const {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(wake.get(), &one, sizeof one);
  }

  Descriptor epoll, wake, timer;
  std::vector<std::unique_ptr<Watch>> watches;  ///< by descriptor
  std::vector<std::unique_ptr<Watch>> removed;
  std::array<std::deque<Ready>, kPriorities> pending;
  std::array<epoll_event, kFetched> fetched{};
  std::uint32_t generations{0};
  TimerHeap timers;
  std::optional<SteadyTime> armed;  ///< when the timer descriptor becomes ready
  unsigned depth{0};                ///< rounds within rounds
  std::atomic<bool> stopping{false};
  std::atomic<std::thread::id> thread;  ///< of the round that runs now
  std::mutex mutex;                     ///< of `posted`
  std::vector<std::function<void()>> posted;
};

EventLoop::EventLoop() : state_(std::make_unique<State>()) {}

EventLoop::~EventLoop() {
  // What the tasks and handlers own may call back while it is destroyed: everything goes while we still
  // stand.
  while (true) {
    std::vector<std::function<void()>> posted;
    {
      const std::lock_guard lock(state_->mutex);
      posted.swap(state_->posted);
    }
    auto watches = std::exchange(state_->watches, {});
    const bool idle = posted.empty() && watches.empty() && state_->timers.clear() == 0;
    posted.clear();
    watches.clear();
    state_->clear_removed();
    if (idle) break;
  }
}

void EventLoop::watch(int descriptor, std::uint32_t epoll_events, Priority priority, Handler handler) {
  if (descriptor < 0) throw std::invalid_argument("EventLoop::watch: a negative descriptor");
  const auto index = static_cast<std::size_t>(descriptor);
  if (index >= state_->watches.size()) state_->watches.resize(index + 1);
  auto watch = std::make_unique<Watch>();
  if (++state_->generations == 0) ++state_->generations;  // 0 marks our own descriptors
  watch->generation = state_->generations;
  watch->events = epoll_events;
  watch->priority = priority;
  watch->handler = std::move(handler);
  state_->bury(state_->watches[index]);
  auto& placed = state_->watches[index];
  placed = std::move(watch);
  if (!state_->update_epoll(descriptor, *placed)) state_->mark_ready(descriptor, *placed, EPOLLERR);
  if (state_->depth == 0) state_->clear_removed();
}

void EventLoop::change(int descriptor, std::uint32_t epoll_events) {
  auto* watch = state_->find(descriptor);
  if (watch == nullptr || watch->events == epoll_events) return;
  watch->events = epoll_events;
  if (!state_->update_epoll(descriptor, *watch)) state_->mark_ready(descriptor, *watch, EPOLLERR);
}

void EventLoop::set_priority(int descriptor, Priority priority) {
  if (auto* watch = state_->find(descriptor)) watch->priority = priority;
}

void EventLoop::unwatch(int descriptor) {
  if (state_->find(descriptor) == nullptr) return;
  ::epoll_ctl(state_->epoll.get(), EPOLL_CTL_DEL, descriptor, nullptr);  // fails when it was closed before
  state_->bury(state_->watches[static_cast<std::size_t>(descriptor)]);
  if (state_->depth == 0) state_->clear_removed();
}

EventLoop::TimerId EventLoop::after(nanoseconds delay, std::function<void()> task) {
  return state_->timers.add(now() + (delay > nanoseconds::zero() ? delay : nanoseconds::zero()),
                            std::move(task));
}

void EventLoop::cancel(TimerId timer) {
  state_->timers.remove(timer);
}

void EventLoop::post(std::function<void()> task) {
  bool first = false;
  {
    const std::lock_guard lock(state_->mutex);
    first = state_->posted.empty();
    state_->posted.push_back(std::move(task));
  }
  // The loop's own thread looks at the queue before it waits.
  if (first && state_->thread.load() != std::this_thread::get_id()) state_->wake_up();
}

void EventLoop::run() {
  while (!state_->stopping.load()) run_once(std::chrono::hours(1));
  state_->stopping = false;
}

void EventLoop::stop() {
  state_->stopping = true;
  state_->wake_up();
}

void EventLoop::run_once(nanoseconds at_most) {
  struct Round {
    explicit Round(State& of) : state(of) {
      ++state.depth;
      state.thread = std::this_thread::get_id();
    }
    ~Round() {
      if (--state.depth != 0) return;
      state.clear_removed();
      state.thread = std::thread::id();
    }
    Round(const Round&) = delete;
    Round& operator=(const Round&) = delete;
    State& state;
  };
  const Round round(*state_);
  state_->wait(at_most);
  state_->run_posted();
  state_->timers.run_due(now());
  state_->handle_ready();
}

}  // namespace extperfc::translate
