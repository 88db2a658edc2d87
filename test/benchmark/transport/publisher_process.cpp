#include "test/benchmark/transport/publisher_process.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "extperfc/base/stopwatch.hpp"

#include "test/benchmark/transport/pair_sender.hpp"

namespace extperfc::benchmark {

namespace {

constexpr double kEndDeadlineS = 5.0;

tl::unexpected<Error> system_error(const char* what, int code) {
  return fail(ErrorCode::kFailed, std::string(what) + ": " + std::strerror(code));
}

/// Starts this program again with `input` as its standard input.
Result<pid_t> spawn_self(const std::string& ns, int input) {
  std::string program = "/proc/self/exe";
  std::string option = "--child";
  std::string name = ns;
  std::array<char*, 4> arguments{program.data(), option.data(), name.data(), nullptr};
  posix_spawn_file_actions_t actions{};
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  pid_t pid = -1;
  const int failed = posix_spawn(&pid, program.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) return system_error("starting the other process", failed);
  return pid;
}

}  // namespace

Result<void> PublisherProcess::start(const std::string& ns) {
  std::signal(SIGPIPE, SIG_IGN);  // a publisher that died is an error of write()
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return system_error("pipe", errno);
  commands_ = ends[1];
  const auto pid = spawn_self(ns, ends[0]);
  close(ends[0]);
  if (!pid) return tl::unexpected(pid.error());
  pid_ = *pid;
  if (const int failed = clock_getcpuclockid(pid_, &cpu_clock_); failed != 0)
    return system_error("CPU clock of the other process", failed);
  return {};
}

PublisherProcess::~PublisherProcess() {
  if (commands_ >= 0) close(commands_);  // the end of its input ends the process
  if (pid_ < 0) return;
  const Stopwatch watch;
  while (waitpid(pid_, nullptr, WNOHANG) == 0) {
    if (watch.seconds() > kEndDeadlineS) kill(pid_, SIGKILL);
    ros::WallDuration(0.01).sleep();
  }
}

Result<void> PublisherProcess::publish() {
  if (write(commands_, "p", 1) != 1) return system_error("the other process is gone", errno);
  return {};
}

double PublisherProcess::cpu_seconds() const {
  timespec t{};
  clock_gettime(cpu_clock_, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

int serve_as_publisher(const std::string& ns) {
  PairSender sender(ns);
  const ImagePair pair = make_pair();
  while (std::getchar() != EOF) sender.send_references(pair);
  return 0;
}

}  // namespace extperfc::benchmark
