#pragma once

#include <array>
#include <csignal>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/epoll.h>
#include <sys/wait.h>
#include <unistd.h>

#include "extperfc/translate/event_loop.hpp"

namespace extperfc::translate {

/// A program whose output is read on the loop. It is killed at the end.
class ChildProcess {
 public:
  ChildProcess(EventLoop& loop, const std::vector<std::string>& command) : loop_(loop) {
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), O_CLOEXEC) != 0) std::abort();
    std::vector<char*> arguments;
    arguments.reserve(command.size() + 1);
    for (const auto& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
    arguments.push_back(nullptr);
    pid_ = ::fork();
    if (pid_ == 0) {
      ::dup2(pipe[1], STDOUT_FILENO);
      ::dup2(pipe[1], STDERR_FILENO);
      ::execv(arguments[0], arguments.data());
      ::_exit(127);
    }
    ::close(pipe[1]);
    output_ = pipe[0];
    loop_.watch(output_, EPOLLIN, Priority::kNormal, [this](std::uint32_t) { read(); });
  }
  ~ChildProcess() {
    if (pid_ > 0) ::kill(pid_, SIGKILL);
    wait();
    if (output_ >= 0) close_output();
  }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] const std::string& output() const { return text_; }
  [[nodiscard]] bool ended() const { return output_ < 0; }
  void interrupt() const { ::kill(pid_, SIGINT); }
  /// Exit status; blocks until it ended.
  int wait() {
    if (pid_ > 0) ::waitpid(pid_, &status_, 0);
    pid_ = -1;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : -1;
  }

 private:
  void read() {
    std::array<char, 4096> bytes{};
    const auto count = ::read(output_, bytes.data(), bytes.size());
    if (count > 0)
      text_.append(bytes.data(), static_cast<std::size_t>(count));
    else
      close_output();
  }
  void close_output() {
    loop_.unwatch(output_);
    ::close(output_);
    output_ = -1;
  }

  EventLoop& loop_;
  pid_t pid_{-1};
  int output_{-1};
  int status_{0};
  std::string text_;
};

}  // namespace extperfc::translate
