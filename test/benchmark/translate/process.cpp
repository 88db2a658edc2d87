#include "test/benchmark/translate/process.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <utility>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "extperfc/base/stopwatch.hpp"

namespace extperfc::benchmark {

namespace {

constexpr double kInputPatienceS = 2.0;
constexpr double kSignalPatienceS = 5.0;
constexpr int kMaxDescriptors = 4096;

tl::unexpected<Error> system_error(const std::string& what) {
  return fail(ErrorCode::kFailed, what + ": " + std::strerror(errno));
}

void close_open(int descriptor) {
  if (descriptor >= 0) close(descriptor);
}

bool ended_within(pid_t pid, double seconds) {
  const Stopwatch watch;
  while (waitpid(pid, nullptr, WNOHANG) == 0) {
    if (watch.seconds() > seconds) return false;
    usleep(5'000);
  }
  return true;
}

}  // namespace

Process::Process(Process&& other) noexcept {
  *this = std::move(other);
}

Process& Process::operator=(Process&& other) noexcept {
  std::swap(pid_, other.pid_);
  std::swap(input_, other.input_);
  std::swap(records_, other.records_);
  std::swap(cpu_clock_, other.cpu_clock_);
  return *this;
}

Process::~Process() {
  end();
}

Result<Process> Process::start_part(const std::vector<std::string>& arguments) {
  std::array<int, 2> input{-1, -1};
  std::array<int, 2> records{-1, -1};
  if (pipe2(input.data(), O_CLOEXEC) != 0 || pipe2(records.data(), O_CLOEXEC) != 0)
    return system_error("pipe");
  Process process;
  process.input_ = input[1];
  process.records_ = records[0];
  fcntl(records[0], F_SETFL, O_NONBLOCK);
  std::vector<std::string> command{"/proc/self/exe", "--part"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  const auto started = process.run(command, {input[0], -1, records[1]});
  close(input[0]);
  close(records[1]);
  if (!started) return tl::unexpected(started.error());
  return process;
}

Result<Process> Process::start_program(const std::vector<std::string>& command, const std::string& output) {
  const int file = open(output.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0) return system_error(output);
  Process process;
  const auto started = process.run(command, {-1, file, -1});
  close(file);
  if (!started) return tl::unexpected(started.error());
  return process;
}

// fork() and not posix_spawn(): the child asks for a signal at our death.
Result<void> Process::run(const std::vector<std::string>& command, const Descriptors& descriptors) {
  std::vector<char*> arguments;
  arguments.reserve(command.size() + 1);
  for (const auto& argument : command)
    arguments.push_back(const_cast<char*>(argument.c_str()));  // NOLINT: exec's type
  arguments.push_back(nullptr);
  pid_ = fork();
  if (pid_ < 0) return system_error("starting " + command.front());
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (descriptors.input >= 0) dup2(descriptors.input, STDIN_FILENO);
    if (descriptors.records >= 0) {
      dup2(descriptors.records, kRecordDescriptor);
      fcntl(kRecordDescriptor, F_SETFD, 0);
    }
    if (descriptors.output >= 0) {
      dup2(descriptors.output, STDOUT_FILENO);
      dup2(descriptors.output, STDERR_FILENO);
    }
    for (int other = kRecordDescriptor + 1; other < kMaxDescriptors; ++other)
      close(other);  // roscpp's sockets
    execvp(arguments.front(), arguments.data());
    _exit(127);
  }
  if (clock_getcpuclockid(pid_, &cpu_clock_) != 0) return system_error("CPU clock of " + command.front());
  return {};
}

void Process::end() {
  close_open(std::exchange(input_, -1));
  const pid_t pid = std::exchange(pid_, -1);
  if (pid > 0) {
    if (!ended_within(pid, records_ >= 0 ? kInputPatienceS : 0.0)) {
      kill(pid, SIGTERM);
      if (!ended_within(pid, kSignalPatienceS)) {
        kill(pid, SIGKILL);
        waitpid(pid, nullptr, 0);
      }
    }
  }
  close_open(std::exchange(records_, -1));
}

bool Process::alive() const {
  return pid_ > 0 && kill(pid_, 0) == 0 && waitpid(pid_, nullptr, WNOHANG) == 0;
}

double Process::cpu_seconds() const {
  timespec t{};
  clock_gettime(cpu_clock_, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::size_t Process::resident_bytes() const {
  std::ifstream file("/proc/" + std::to_string(pid_) + "/statm");
  std::size_t total_pages = 0;
  std::size_t resident_pages = 0;
  file >> total_pages >> resident_pages;
  return resident_pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

void wait_for_end_of_input() {
  std::array<char, 64> ignored{};
  while (read(STDIN_FILENO, ignored.data(), ignored.size()) > 0) {
  }
}

std::int64_t monotonic_ns() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

}  // namespace extperfc::benchmark
