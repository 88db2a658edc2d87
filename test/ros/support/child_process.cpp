#include "test/ros/support/child_process.hpp"

#include <csignal>
#include <stdexcept>

#include <sys/wait.h>
#include <unistd.h>

#include "test/ros/support/wait.hpp"

namespace extperfc::ros_test {

ChildProcess::ChildProcess(const std::vector<std::string>& command) {
  std::vector<char*> arguments;
  for (const auto& argument : command)
    arguments.push_back(const_cast<char*>(argument.c_str()));  // execvp's old signature
  arguments.push_back(nullptr);
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("cannot fork");
  if (pid_ == 0) {
    (void)setpgid(0, 0);
    (void)execvp(arguments[0], arguments.data());
    _exit(127);
  }
  (void)setpgid(pid_, pid_);  // both sides, so that it holds whoever runs first
}

ChildProcess::~ChildProcess() {
  for (const int signal : {SIGINT, SIGKILL}) {
    if (!running()) break;
    (void)kill(-pid_, signal);
    (void)wait_for([this] { return !running(); }, 5.0);
  }
}

bool ChildProcess::running() {
  if (!ended_ && waitpid(pid_, &status_, WNOHANG) == pid_) ended_ = true;
  return !ended_;
}

int ChildProcess::wait_for_end() {
  if (!wait_for([this] { return !running(); }) || !WIFEXITED(status_)) return -1;
  return WEXITSTATUS(status_);
}

}  // namespace extperfc::ros_test
