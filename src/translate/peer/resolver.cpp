#include <array>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <netdb.h>

#include "extperfc/translate/rpc.hpp"

namespace extperfc::translate {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kThreads = 4;     ///< so that one dead name does not hold up the others
constexpr std::size_t kNames = 256;     ///< looked up or waiting at once
constexpr std::size_t kWaiting = 4096;  ///< callbacks at once
constexpr std::size_t kRemembered = 1024;
constexpr milliseconds kFreshFor{10'000};  ///< an address that was found
constexpr milliseconds kFailedFor{2'000};  ///< a name that was not

bool is_numeric(const std::string& host) {
  in6_addr buffer{};
  return ::inet_pton(AF_INET, host.c_str(), &buffer) == 1 ||
         ::inet_pton(AF_INET6, host.c_str(), &buffer) == 1;
}

std::string text_of(const addrinfo& info) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const int failed =
      ::getnameinfo(info.ai_addr, info.ai_addrlen, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST);
  return failed == 0 ? text.data() : std::string();
}

/// Blocks, perhaps for many seconds. IPv4 first: nodes of ROS 1 listen there.
Result<std::string> look_up(const std::string& host) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* list = nullptr;
  if (const int problem = ::getaddrinfo(host.c_str(), nullptr, &hints, &list); problem != 0)
    return fail(ErrorCode::kNotFound,
                "the name '" + host + "' has no address (" + ::gai_strerror(problem) + ")");
  std::string any;
  std::string v4;
  for (const auto* info = list; info != nullptr; info = info->ai_next) {
    if (any.empty()) any = text_of(*info);
    if (v4.empty() && info->ai_family == AF_INET) v4 = text_of(*info);
  }
  ::freeaddrinfo(list);
  if (any.empty()) return fail(ErrorCode::kNotFound, "the name '" + host + "' has no usable address");
  return v4.empty() ? any : v4;
}

/// What the threads share with the loop. It outlives a thread that hangs in a look-up.
struct Work {
  using Found = std::function<void(const std::string& host, const Result<std::string>& address)>;

  std::mutex mutex;
  std::condition_variable changed;
  std::deque<std::string> names;
  std::size_t idle{0};
  bool finished{false};
  EventLoop* loop{nullptr};  ///< null when the resolver is gone
  Found found;               ///< run on the loop
};

void run_thread(const std::shared_ptr<Work>& work, const std::shared_ptr<bool>& busy) {
  std::unique_lock lock(work->mutex);
  while (true) {
    ++work->idle;
    work->changed.wait(lock, [&] { return work->finished || !work->names.empty(); });
    --work->idle;
    if (work->finished) return;
    const auto host = std::move(work->names.front());
    work->names.pop_front();
    *busy = true;
    lock.unlock();
    auto address = look_up(host);
    lock.lock();
    *busy = false;
    if (work->loop != nullptr)
      work->loop->post([work, host, address = std::move(address)] {
        if (work->found) work->found(host, address);
      });
  }
}

}  // namespace

struct Resolver::State {
  struct Remembered {
    Result<std::string> address;
    SteadyTime until;
  };
  struct Thread {
    std::thread thread;
    std::shared_ptr<bool> busy;  ///< guarded by Work::mutex
  };

  EventLoop& loop;
  std::map<std::string, std::string> table;
  std::shared_ptr<Work> work{std::make_shared<Work>()};
  std::vector<Thread> threads;
  std::map<std::string, std::vector<Done>> waiting;
  std::size_t waiting_count{0};
  std::map<std::string, Remembered> remembered;

  State(EventLoop& on, std::map<std::string, std::string> hosts, std::string remedy)
      : loop(on), table(std::move(hosts)) {
    work->loop = &loop;
    work->found = [this, remedy = std::move(remedy)](const std::string& host, Result<std::string> address) {
      if (!address) address.error().message += "; " + remedy;
      found(host, address);
    };
  }

  ~State() {
    std::vector<Thread*> hanging;
    {
      const std::lock_guard lock(work->mutex);
      work->finished = true;
      work->loop = nullptr;
      for (auto& thread : threads)
        if (*thread.busy) hanging.push_back(&thread);
    }
    work->found = nullptr;  // of the loop's thread
    work->changed.notify_all();
    for (auto* thread : hanging) thread->thread.detach();
    for (auto& thread : threads)
      if (thread.thread.joinable()) thread.thread.join();
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void found(const std::string& host, const Result<std::string>& address) {
    if (remembered.size() >= kRemembered) remembered.clear();
    const auto until = EventLoop::now() + (address ? kFreshFor : kFailedFor);
    remembered.insert_or_assign(host, Remembered{address, until});
    const auto node = waiting.extract(host);
    if (node.empty()) return;
    waiting_count -= node.mapped().size();
    const auto kept = work;  // a callback may end the resolver: no member is touched afterwards
    for (const auto& done : node.mapped()) {
      if (!kept->found) return;
      done(address);
    }
  }

  void look_up_soon(const std::string& host) {
    bool more = false;
    {
      const std::lock_guard lock(work->mutex);
      work->names.push_back(host);
      more = work->idle < work->names.size() && threads.size() < kThreads;
    }
    if (more) {
      auto busy = std::make_shared<bool>(false);
      threads.push_back({std::thread(run_thread, work, busy), busy});
    }
    work->changed.notify_one();
  }
};

Resolver::Resolver(EventLoop& loop, std::map<std::string, std::string> table, std::string remedy)
    : state_(std::make_shared<State>(loop, std::move(table), std::move(remedy))) {}

Resolver::~Resolver() = default;

void Resolver::resolve(const std::string& host, Done done) {
  const auto listed = state_->table.find(host);
  const auto name = listed == state_->table.end() ? host : listed->second;
  if (is_numeric(name)) return done(name);
  const auto known = state_->remembered.find(name);
  if (known != state_->remembered.end() && known->second.until > EventLoop::now())
    return done(Result<std::string>(known->second.address));
  if (state_->waiting_count >= kWaiting ||
      (state_->waiting.count(name) == 0 && state_->waiting.size() >= kNames))
    return done(fail(ErrorCode::kFailed, "too many pending name lookups: ignoring '" + name + "'"));
  auto& callbacks = state_->waiting[name];
  callbacks.push_back(std::move(done));
  ++state_->waiting_count;
  if (callbacks.size() == 1) state_->look_up_soon(name);
}

}  // namespace extperfc::translate
