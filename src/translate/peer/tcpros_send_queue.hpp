#pragma once

#include <cstdint>
#include <deque>
#include <string>

#include "extperfc/translate/event_loop.hpp"
#include "extperfc/translate/frame.hpp"
#include "extperfc/translate/tcpros.hpp"

namespace extperfc::translate {

/// Messages that wait for one subscriber: bounded, the oldest is dropped, several leave with one system call.
/// A message whose first byte has left is always finished.
class SendQueue {
 public:
  enum class Outcome : std::uint8_t { kEmpty, kBlocked, kBroken };

  void configure(const SendParams& params) { params_ = params; }
  [[nodiscard]] const SendParams& params() const { return params_; }

  /// The connection header, before all messages; never dropped, not counted.
  void push_header(FramePtr header);
  void push(FramePtr frame, SteadyTime since);
  /// Sends without blocking what is not too old.
  [[nodiscard]] Outcome write(int descriptor);

  [[nodiscard]] const std::string& problem() const { return problem_; }
  [[nodiscard]] bool empty() const { return entries_.empty(); }
  [[nodiscard]] std::uint64_t bytes_written() const { return written_; }  ///< ever, to see progress
  [[nodiscard]] LinkStats stats() const;

 private:
  struct Entry {
    FramePtr frame;
    SteadyTime since;
    bool header{false};
  };
  /// How many at the front must be sent to the end.
  [[nodiscard]] std::size_t begun() const;
  void drop(std::size_t index);
  void drop_excess();
  void drop_aged();
  [[nodiscard]] std::ptrdiff_t write_some(int descriptor) const;
  void advance(std::size_t count);

  SendParams params_;
  std::deque<Entry> entries_;
  std::size_t offset_{0};  ///< bytes of the first entry that have left
  std::size_t waiting_bytes_{0};
  std::uint64_t written_{0};
  LinkStats stats_;
  std::string problem_;
};

}  // namespace extperfc::translate
