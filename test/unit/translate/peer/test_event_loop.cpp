#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/translate/event_loop.hpp"

#include "test/unit/translate/peer/loop_until.hpp"

namespace extperfc::translate {
namespace {

using namespace std::chrono_literals;

/// Two connected sockets; what is written to `far` makes `near` ready.
struct Pair {
  Pair() {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends.data()) != 0) std::abort();
    near = ends[0];
    far = ends[1];
  }
  ~Pair() {
    close_near();
    ::close(far);
  }
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;
  void write() const { ASSERT_EQ(::write(far, "x", 1), 1); }
  void drain() const {
    std::array<char, 64> bytes{};
    while (::read(near, bytes.data(), bytes.size()) > 0) continue;
  }
  void close_near() {
    if (near >= 0) ::close(near);
    near = -1;
  }
  int near{-1}, far{-1};
};

TEST(EventLoop, HandsReadyDescriptorsOverByPriority) {
  EventLoop loop;
  const Pair bulk, normal, control;
  std::string order;
  const auto watch = [&](const Pair& pair, Priority priority, char name) {
    loop.watch(pair.near, EPOLLIN, priority, [&order, &pair, name](std::uint32_t) {
      order += name;
      pair.drain();
    });
    pair.write();
  };
  watch(bulk, Priority::kBulk, 'b');
  watch(normal, Priority::kNormal, 'n');
  watch(control, Priority::kControl, 'c');
  loop.run_once(1s);
  EXPECT_EQ(order, "cnb");
  loop.set_priority(bulk.near, Priority::kControl);
  loop.set_priority(control.near, Priority::kBulk);
  for (const auto* pair : {&bulk, &normal, &control}) pair->write();
  loop.run_once(1s);
  EXPECT_EQ(order, "cnbbnc");
}

TEST(EventLoop, ControlDoesNotWaitBehindManySlowBulkHandlers) {
  EventLoop loop;
  const std::vector<Pair> bulk(20);
  const Pair control;
  int bulk_before_control = 0;
  bool control_ran = false;
  for (const auto& pair : bulk) {
    loop.watch(pair.near, EPOLLIN, Priority::kBulk, [&](std::uint32_t) {
      pair.drain();
      if (!control_ran) ++bulk_before_control;
      if (bulk_before_control == 1) control.write();  // comes while the others wait
      const auto end = EventLoop::now() + 1ms;
      while (EventLoop::now() < end) continue;
    });
    pair.write();
  }
  loop.watch(control.near, EPOLLIN, Priority::kControl, [&](std::uint32_t) {
    control.drain();
    control_ran = true;
  });
  EXPECT_TRUE(loop_until(loop, [&] { return control_ran; }));
  EXPECT_LE(bulk_before_control, 3);
}

TEST(EventLoop, EveryBulkDescriptorHasItsTurn) {
  EventLoop loop;
  const std::vector<Pair> pairs(10);
  std::vector<int> calls(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    loop.watch(pairs[i].near, EPOLLIN, Priority::kBulk, [&calls, i](std::uint32_t) {
      ++calls[i];  // stays ready
      const auto end = EventLoop::now() + 150us;
      while (EventLoop::now() < end) continue;
    });
    pairs[i].write();
  }
  for (int round = 0; round < 50; ++round) loop.run_once(1s);
  for (const int count : calls) EXPECT_NEAR(count, 5, 1);
}

TEST(EventLoop, ARemovedHandlerNeverRunsThoughItsEventWasFetched) {
  EventLoop loop;
  const Pair first, second;
  int ran = 0;
  for (const auto& [mine, other] : {std::pair(&first, &second), std::pair(&second, &first)}) {
    loop.watch(mine->near, EPOLLIN, Priority::kNormal, [&ran, &loop, other = other](std::uint32_t) {
      ++ran;
      loop.unwatch(other->near);
    });
    mine->write();
  }
  loop.run_once(1s);
  loop.run_once(0s);
  EXPECT_EQ(ran, 2) << "one handler, twice, because its descriptor stays ready";
}

TEST(EventLoop, ADescriptorNumberThatIsUsedAgainGetsNoOldEvents) {
  EventLoop loop;
  Pair first, second;
  auto fresh = std::unique_ptr<Pair>();
  bool fresh_ran = false;
  const auto replace = [&](Pair& victim) {
    const int number = victim.near;
    loop.unwatch(number);
    victim.close_near();
    fresh = std::make_unique<Pair>();
    ASSERT_EQ(fresh->near, number) << "the system gives the lowest free number";
    loop.watch(fresh->near, EPOLLIN, Priority::kNormal, [&](std::uint32_t) { fresh_ran = true; });
  };
  bool replaced = false;
  const auto watch = [&](Pair& mine, Pair& other) {
    loop.watch(mine.near, EPOLLIN, Priority::kNormal, [&](std::uint32_t) {
      mine.drain();
      if (!std::exchange(replaced, true)) replace(other);
    });
    mine.write();
  };
  watch(first, second);
  watch(second, first);
  loop.run_once(1s);
  loop.run_once(0s);
  EXPECT_TRUE(replaced);
  EXPECT_FALSE(fresh_ran);
  fresh->write();
  loop.run_once(1s);
  EXPECT_TRUE(fresh_ran);
  loop.unwatch(fresh->near);
}

TEST(EventLoop, AHandlerMayRemoveAndReplaceItself) {
  EventLoop loop;
  const Pair pair;
  std::string order;
  const auto owned = std::make_shared<int>(7);
  loop.watch(pair.near, EPOLLIN, Priority::kNormal, [&, owned](std::uint32_t) {
    loop.watch(pair.near, EPOLLIN, Priority::kNormal, [&](std::uint32_t) {
      order += '2';
      loop.unwatch(pair.near);
      loop.unwatch(pair.near);
    });
    order += std::to_string(*owned);  // our own captures still stand
  });
  pair.write();
  for (int i = 0; i < 3; ++i) loop.run_once(0s);
  EXPECT_EQ(order, "72");
  EXPECT_EQ(owned.use_count(), 1);
}

TEST(EventLoop, ChangeAndReplacedInterestsCount) {
  EventLoop loop;
  const Pair pair;
  std::uint32_t seen = 0;
  loop.watch(pair.near, EPOLLIN, Priority::kNormal, [&](std::uint32_t events) { seen |= events; });
  loop.run_once(0s);
  EXPECT_EQ(seen, 0U);
  loop.change(pair.near, EPOLLIN | EPOLLOUT);
  loop.run_once(1s);
  EXPECT_EQ(seen, static_cast<std::uint32_t>(EPOLLOUT));
}

TEST(EventLoop, AFileThatCannotBeWatchedGetsAnErrorEvent) {
  EventLoop loop;
  std::uint32_t seen = 0;
  constexpr int kNoSuchDescriptor = 900;
  loop.watch(kNoSuchDescriptor, EPOLLIN, Priority::kNormal, [&](std::uint32_t events) {
    seen = events;
    loop.unwatch(kNoSuchDescriptor);
  });
  loop.run_once(1s);
  EXPECT_EQ(seen, static_cast<std::uint32_t>(EPOLLERR));
  EXPECT_THROW(loop.watch(-1, EPOLLIN, Priority::kNormal, [](std::uint32_t) {}), std::invalid_argument);
}

TEST(EventLoop, TimersRunInOrderAndNeverEarly) {
  struct Due {
    SteadyTime first;  // asked for between the two
    SteadyTime last;
  };
  EventLoop loop;
  Rng rng(4);
  constexpr std::size_t kTimers = 200;
  std::vector<Due> due(kTimers);
  std::vector<std::size_t> ran;
  int early = 0;
  for (std::size_t i = 0; i < kTimers; ++i) {
    const auto delay = std::chrono::microseconds(rng.integer(0, 30'000));
    due[i].first = EventLoop::now() + delay;
    loop.after(delay, [&, i] {
      if (EventLoop::now() < due[i].first) ++early;
      ran.push_back(i);
    });
    due[i].last = EventLoop::now() + delay;
  }
  ASSERT_TRUE(loop_until(loop, [&] { return ran.size() == kTimers; }));
  EXPECT_EQ(early, 0);
  for (std::size_t i = 1; i < kTimers; ++i) EXPECT_LE(due[ran[i - 1]].first, due[ran[i]].last);
}

TEST(EventLoop, CancelledTimersDoNotRunAndLeaveNothingBehind) {
  EventLoop loop;
  int ran = 0;
  const auto owned = std::make_shared<int>();
  for (int i = 0; i < 10'000; ++i) loop.cancel(loop.after(1h, [&ran, owned] { ++ran; }));
  EXPECT_EQ(owned.use_count(), 1);
  EventLoop::TimerId second = 0;
  loop.after(0s, [&] { loop.cancel(second); });
  second = loop.after(0s, [&] { ++ran; });
  loop.cancel(0);
  loop_for(loop, 20ms);
  EXPECT_EQ(ran, 0);
}

TEST(EventLoop, ATimerThatStartsAnotherAtOnceDoesNotKeepOthersWaiting) {
  EventLoop loop;
  const Pair pair;
  bool handled = false;
  loop.watch(pair.near, EPOLLIN, Priority::kBulk, [&](std::uint32_t) { handled = true; });
  pair.write();
  std::function<void()> again = [&] { loop.after(0s, again); };
  again();
  std::function<void()> post_again = [&] { loop.post(post_again); };
  post_again();
  EXPECT_TRUE(loop_until(
      loop, [&] { return handled; }, 2s));
}

TEST(EventLoop, PostsOfManyThreadsAllRunOnTheLoopsThread) {
  EventLoop loop;
  constexpr int kThreads = 4, kPosts = 5'000;
  int ran = 0, elsewhere = 0;
  const auto own = std::this_thread::get_id();
  std::vector<std::thread> threads;
  threads.reserve(kThreads);
  for (int t = 0; t < kThreads; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < kPosts; ++i)
        loop.post([&] {
          if (std::this_thread::get_id() != own) ++elsewhere;
          if (++ran == kThreads * kPosts) loop.stop();
        });
    });
  loop.run();
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(ran, kThreads * kPosts);
  EXPECT_EQ(elsewhere, 0);
}

TEST(EventLoop, APostFromElsewhereWakesASleepingLoop) {
  EventLoop loop;
  std::atomic<bool> ran{false};
  std::thread runner([&] { loop.run(); });
  for (int i = 0; i < 100; ++i) {
    ran = false;
    loop.post([&] { ran = true; });
    const auto end = EventLoop::now() + 10s;
    while (!ran && EventLoop::now() < end) std::this_thread::yield();
    ASSERT_TRUE(ran) << "post " << i;
  }
  loop.stop();
  runner.join();
}

TEST(EventLoop, StopBeforeRunEndsItAtOnceAndOnce) {
  EventLoop loop;
  loop.stop();
  loop.run();
  bool ran = false;
  loop.post([&] {
    ran = true;
    loop.stop();
  });
  loop.run();
  EXPECT_TRUE(ran);
}

TEST(EventLoop, WhatItOwnsMayCallItWhileItEnds) {
  struct Owner {
    explicit Owner(EventLoop& on) : loop(on) {}
    ~Owner() {
      loop.unwatch(pair.near);
      loop.post([] {});
      loop.cancel(loop.after(1h, [] {}));
    }
    Owner(const Owner&) = delete;
    Owner& operator=(const Owner&) = delete;
    EventLoop& loop;
    Pair pair;
  };
  auto loop = std::make_unique<EventLoop>();
  const auto keep = [&](const std::shared_ptr<Owner>& owner) {
    loop->watch(owner->pair.near, EPOLLIN, Priority::kNormal, [owner](std::uint32_t) {});
  };
  keep(std::make_shared<Owner>(*loop));
  loop->after(1h, [owner = std::make_shared<Owner>(*loop)] {});
  loop->post([owner = std::make_shared<Owner>(*loop)] {});
  loop.reset();
}

}  // namespace
}  // namespace extperfc::translate
