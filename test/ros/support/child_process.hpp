#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

namespace extperfc::ros_test {

/// A program that runs beside the test, in a process group of its own; interrupted (SIGINT) and awaited at
/// the end.
class ChildProcess {
 public:
  /// `command[0]` is looked up on the PATH. A program that cannot be started exits with 127.
  explicit ChildProcess(const std::vector<std::string>& command);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] bool running();
  /// Exit status when it has ended within the tests' patience, otherwise -1.
  [[nodiscard]] int wait_for_end();

 private:
  pid_t pid_;
  bool ended_{false};
  int status_{-1};
};

}  // namespace extperfc::ros_test
