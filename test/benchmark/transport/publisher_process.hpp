#pragma once

#include <string>

#include <sys/types.h>
#include <time.h>

#include "extperfc/base/error.hpp"

namespace extperfc::benchmark {

/// Another process of this program that publishes one pair on `ns` on request.
class PublisherProcess {
 public:
  [[nodiscard]] Result<void> start(const std::string& ns);

  PublisherProcess() = default;
  PublisherProcess(const PublisherProcess&) = delete;
  PublisherProcess& operator=(const PublisherProcess&) = delete;
  ~PublisherProcess();  ///< ends the process and waits for it

  [[nodiscard]] Result<void> publish();

  /// What the process has used so far.
  [[nodiscard]] double cpu_seconds() const;

 private:
  pid_t pid_{-1};
  int commands_{-1};  ///< one byte, one pair
  clockid_t cpu_clock_{};
};

/// The other process's side: publishes a pair per byte from standard input until that ends. Returns the exit
/// code.
int serve_as_publisher(const std::string& ns);

}  // namespace extperfc::benchmark
