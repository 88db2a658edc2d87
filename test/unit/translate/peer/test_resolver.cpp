#include <atomic>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netdb.h>

#include "extperfc/translate/rpc.hpp"

#include "test/unit/translate/peer/loop_until.hpp"

namespace {

/// Stands in for the system's name service: names that begin with "slow" hang until released.
struct FakeNames {
  std::mutex mutex;
  std::condition_variable changed;
  bool released{false};
  int hanging{0};
  std::map<std::string, int> asked;

  void reset() {
    const std::lock_guard lock(mutex);
    released = false;
    asked.clear();
  }
  void release() {
    {
      const std::lock_guard lock(mutex);
      released = true;
    }
    changed.notify_all();
  }
  int count(const std::string& name) {
    const std::lock_guard lock(mutex);
    return asked[name];
  }
  int hanging_now() {
    const std::lock_guard lock(mutex);
    return hanging;
  }
  void hang(std::unique_lock<std::mutex>& lock) {
    ++hanging;
    changed.wait(lock, [this] { return released; });
    --hanging;
    changed.notify_all();
  }
  void wait_until_none_hangs() {
    std::unique_lock lock(mutex);
    changed.wait(lock, [this] { return hanging == 0; });
  }
};
FakeNames& names() {
  static FakeNames fake;
  return fake;
}

struct Entry {
  addrinfo info;
  sockaddr_in v4;
  sockaddr_in6 v6;
};

addrinfo* make_entry(int family, addrinfo* next) {
  auto* entry = new Entry{};
  entry->info.ai_family = family;
  entry->info.ai_next = next;
  if (family == AF_INET) {
    entry->v4.sin_family = AF_INET;
    ::inet_pton(AF_INET, "127.0.0.5", &entry->v4.sin_addr);
    entry->info.ai_addr = reinterpret_cast<sockaddr*>(&entry->v4);
    entry->info.ai_addrlen = sizeof entry->v4;
  } else {
    entry->v6.sin6_family = AF_INET6;
    ::inet_pton(AF_INET6, "::5", &entry->v6.sin6_addr);
    entry->info.ai_addr = reinterpret_cast<sockaddr*>(&entry->v6);
    entry->info.ai_addrlen = sizeof entry->v6;
  }
  return &entry->info;
}

}  // namespace

// These take the place of the C library's in this program.
extern "C" int getaddrinfo(const char* name, const char* /*service*/, const addrinfo* /*hints*/,
                           addrinfo** list) {
  const std::string host(name);
  std::unique_lock lock(names().mutex);
  ++names().asked[host];
  if (host.rfind("slow", 0) == 0) names().hang(lock);
  if (host.rfind("missing", 0) == 0) return EAI_NONAME;
  auto* last = host == "only6.test" ? nullptr : make_entry(AF_INET, nullptr);
  *list = make_entry(AF_INET6, last);
  return 0;
}

extern "C" void freeaddrinfo(addrinfo* list) {
  while (list != nullptr) {
    auto* next = list->ai_next;
    delete reinterpret_cast<Entry*>(list);
    list = next;
  }
}

namespace extperfc::translate {
namespace {

using namespace std::chrono_literals;

class ResolverTest : public ::testing::Test {
 protected:
  void SetUp() override { names().reset(); }
  void TearDown() override {
    names().release();
    names().wait_until_none_hangs();
  }

  static std::string text(const Result<std::string>& address) {
    return address ? *address : "error: " + address.error().message;
  }
  std::string resolve(Resolver& resolver, const std::string& host) {
    std::vector<std::string> found;
    resolver.resolve(host, [&](const Result<std::string>& address) { found.push_back(text(address)); });
    EXPECT_TRUE(loop_until(loop_, [&] { return !found.empty(); }));
    return found.empty() ? "" : found[0];
  }
  static bool at_once(Resolver& resolver, const std::string& host) {
    const auto ran = std::make_shared<bool>(false);  // it may run later
    resolver.resolve(host, [ran](const Result<std::string>&) { *ran = true; });
    return *ran;
  }

  EventLoop loop_;
};

TEST_F(ResolverTest, TheTableAndNumbersComeFirstAndAtOnce) {
  Resolver resolver(loop_, {{"robot.local", "10.0.0.7"}, {"alias", "real.test"}});
  EXPECT_TRUE(at_once(resolver, "robot.local"));
  EXPECT_EQ(resolve(resolver, "robot.local"), "10.0.0.7");
  EXPECT_EQ(resolve(resolver, "192.168.1.2"), "192.168.1.2");
  EXPECT_EQ(resolve(resolver, "fe80::1"), "fe80::1");
  EXPECT_TRUE(names().asked.empty());
  EXPECT_EQ(resolve(resolver, "alias"), "127.0.0.5");
  EXPECT_EQ(names().count("real.test"), 1);
}

TEST_F(ResolverTest, PrefersIPv4AndRemembers) {
  Resolver resolver(loop_, {});
  EXPECT_FALSE(at_once(resolver, "a.test"));
  EXPECT_EQ(resolve(resolver, "a.test"), "127.0.0.5");
  EXPECT_TRUE(at_once(resolver, "a.test"));
  EXPECT_EQ(names().count("a.test"), 1);
  EXPECT_EQ(resolve(resolver, "only6.test"), "::5");
}

TEST_F(ResolverTest, AMissingNameIsAnErrorThatNamesIt) {
  Resolver resolver(loop_, {});
  EXPECT_NE(resolve(resolver, "missing.test").find("missing.test"), std::string::npos);
  EXPECT_TRUE(at_once(resolver, "missing.test")) << "for a short time";
  EXPECT_EQ(names().count("missing.test"), 1);
}

TEST_F(ResolverTest, TheErrorNamesTheRemedyOnce) {
  Resolver resolver(loop_, {}, "add it to the parameter /translator/robot/hosts");
  for (int i = 0; i < 2; ++i) {
    const auto error = resolve(resolver, "missing.test");
    const auto at = error.find("; add it to the parameter /translator/robot/hosts");
    ASSERT_NE(at, std::string::npos) << error;
    EXPECT_EQ(error.find("add it", at + 5), std::string::npos) << error;
  }
}

TEST_F(ResolverTest, AHangingNameHoldsUpNeitherTheLoopNorOthers) {
  Resolver resolver(loop_, {});
  int answered = 0;
  for (const char* host : {"slow1", "slow1", "slow2"})
    resolver.resolve(host, [&](const Result<std::string>&) { ++answered; });
  ASSERT_TRUE(loop_until(loop_, [] { return names().hanging_now() == 2; }));
  EXPECT_EQ(resolve(resolver, "quick.test"), "127.0.0.5");
  EXPECT_EQ(answered, 0);
  names().release();
  EXPECT_TRUE(loop_until(loop_, [&] { return answered == 3; }));
  EXPECT_EQ(names().count("slow1"), 1) << "asked once for both";
}

TEST_F(ResolverTest, EndsAtOnceWhileANameHangs) {
  bool ended = false;
  bool ran_after_end = false;
  const auto done = [&](const Result<std::string>&) { ran_after_end = ran_after_end || ended; };
  auto resolver = std::make_unique<Resolver>(loop_, std::map<std::string, std::string>{});
  resolver->resolve("slow", done);
  resolver->resolve("quick.test", done);
  ASSERT_TRUE(loop_until(loop_, [] { return names().hanging_now() == 1; }));
  const auto before = EventLoop::now();
  resolver.reset();
  ended = true;
  EXPECT_LT(EventLoop::now() - before, 2s);
  names().release();
  loop_for(loop_, 30ms);
  EXPECT_FALSE(ran_after_end);
}

TEST_F(ResolverTest, EndsBeforeALoopThatEndsWhileANameHangs) {
  auto loop = std::make_unique<EventLoop>();
  auto resolver = std::make_unique<Resolver>(*loop, std::map<std::string, std::string>{});
  resolver->resolve("slow", [](const Result<std::string>&) {});
  ASSERT_TRUE(loop_until(*loop, [] { return names().hanging_now() == 1; }));
  resolver.reset();
  loop.reset();
  names().release();
  names().wait_until_none_hangs();
}

TEST_F(ResolverTest, BoundsWhatWaits) {
  Resolver resolver(loop_, {});
  int refused = 0;
  for (int i = 0; i < 1'000; ++i)
    resolver.resolve("slow" + std::to_string(i),
                     [&](const Result<std::string>& address) { refused += address ? 0 : 1; });
  EXPECT_EQ(refused, 1'000 - 256);
  for (int i = 0; i < 10'000; ++i)
    resolver.resolve("slow0", [&](const Result<std::string>& address) { refused += address ? 0 : 1; });
  EXPECT_EQ(refused, 1'000 - 256 + 10'000 - (4'096 - 256));
}

TEST_F(ResolverTest, ACallbackMayEndTheResolver) {
  auto resolver = std::make_unique<Resolver>(loop_, std::map<std::string, std::string>{});
  int ran = 0;
  for (int i = 0; i < 3; ++i)
    resolver->resolve("a.test", [&](const Result<std::string>&) {
      ++ran;
      resolver.reset();
    });
  ASSERT_TRUE(loop_until(loop_, [&] { return ran != 0; }));
  loop_for(loop_, 20ms);
  EXPECT_EQ(ran, 1);
}

}  // namespace
}  // namespace extperfc::translate
