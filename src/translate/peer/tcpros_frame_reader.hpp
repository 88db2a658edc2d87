#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "extperfc/translate/event_loop.hpp"
#include "extperfc/translate/frame.hpp"

namespace extperfc::translate {

/// Cuts a TCP stream into frames. Many small messages come with one system call and are copied once; a large
/// one is received straight into its frame. A reader waits for one frame at a time, so that its memory is
/// bounded by one message.
class FrameReader {
 public:
  struct Params {
    std::size_t message_bytes{0};  ///< a longer message breaks the stream
    bool status_byte{false};       ///< before each length, as in a service's response
    bool exact{false};             ///< never reads beyond a message, so that it can stop after each
  };
  enum class Outcome : std::uint8_t {
    kWaiting,  ///< nothing more now, or `at_most` was read
    kStopped,  ///< the sink wanted no more
    kClosed,   ///< the connection ended; problem() says how
    kBroken,   ///< the other end sent what cannot be taken; problem() says what
  };
  /// False stops. The frame is whole and sealed; `status` is 1 without status bytes.
  using Sink = std::function<bool(std::shared_ptr<Frame> frame, std::uint8_t status, SteadyTime received)>;

  /// `scratch` may be shared by all readers of one thread.
  FrameReader(FramePool& pool, ByteBuffer& scratch, Params params);

  /// Reads without blocking until nothing is left or about `at_most` bytes came.
  [[nodiscard]] Outcome read(int descriptor, std::size_t at_most, const Sink& sink);
  [[nodiscard]] const std::string& problem() const { return problem_; }

  static constexpr std::size_t kScratch = 64U << 10U;

 private:
  [[nodiscard]] std::size_t head_size() const { return params_.status_byte ? 5 : 4; }
  [[nodiscard]] std::size_t read_ahead() const;
  [[nodiscard]] std::ptrdiff_t receive(int descriptor, std::size_t into_frame, std::size_t into_scratch);
  [[nodiscard]] Outcome take(std::size_t into_frame, std::size_t got, const Sink& sink);
  [[nodiscard]] Outcome cut(const std::uint8_t* bytes, std::size_t count, const Sink& sink,
                            SteadyTime received);
  [[nodiscard]] Outcome closed(std::string problem);
  [[nodiscard]] bool begin_frame();
  [[nodiscard]] bool deliver(const Sink& sink, SteadyTime received);

  FramePool& pool_;
  ByteBuffer& scratch_;
  Params params_;
  std::array<std::uint8_t, 5> head_{};
  std::size_t head_filled_{0};
  std::shared_ptr<Frame> frame_;  ///< the message that is being received
  std::size_t size_{0}, filled_{0};
  std::string problem_;
};

}  // namespace extperfc::translate
