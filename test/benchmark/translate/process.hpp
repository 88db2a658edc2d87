#pragma once

#include <cstddef>
#include <ctime>
#include <string>
#include <vector>

#include <sys/types.h>

#include "extperfc/base/error.hpp"

namespace extperfc::benchmark {

/// Descriptor on which a part of this program writes records to its parent; see Process::start_part().
inline constexpr int kRecordDescriptor = 3;

/// A process of our own, ended with this object; it also ends when we die.
class Process {
 public:
  Process() = default;
  Process(Process&& other) noexcept;
  Process& operator=(Process&& other) noexcept;
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  /// Closes its input, asks it to end with SIGTERM after 2 s, and makes it after 5 s more.
  ~Process();

  /// This program again, as `--part arguments...`. Its standard input ends when it shall end.
  [[nodiscard]] static Result<Process> start_part(const std::vector<std::string>& arguments);
  /// Another program, found on the PATH; its output goes to a file.
  [[nodiscard]] static Result<Process> start_program(const std::vector<std::string>& command,
                                                     const std::string& output);

  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] bool alive() const;
  /// What it wrote to kRecordDescriptor; non-blocking.
  [[nodiscard]] int records() const { return records_; }
  /// CPU time of all its threads so far [s].
  [[nodiscard]] double cpu_seconds() const;
  [[nodiscard]] std::size_t resident_bytes() const;

 private:
  struct Descriptors {
    int input{-1}, output{-1}, records{-1};  ///< of the child; -1 leaves it as it is
  };
  [[nodiscard]] Result<void> run(const std::vector<std::string>& command, const Descriptors& descriptors);
  void end();

  pid_t pid_{-1};
  int input_{-1};
  int records_{-1};
  clockid_t cpu_clock_{};
};

/// Blocks until standard input ends.
void wait_for_end_of_input();

/// The monotonic clock, which all processes of a machine share [ns].
[[nodiscard]] std::int64_t monotonic_ns();

}  // namespace extperfc::benchmark
