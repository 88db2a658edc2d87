#include "translate/peer/tcpros_handshake.hpp"

#include <algorithm>
#include <cerrno>

#include <sys/socket.h>
#include <sys/uio.h>

namespace extperfc::translate {
namespace {

/// Memory for a header grows with what arrives, not with what is promised.
constexpr std::size_t kStep = 16U << 10U;

}  // namespace

HeaderReader::Outcome HeaderReader::fail_with(std::string problem) {
  problem_ = std::move(problem);
  return Outcome::kFailed;
}

HeaderReader::Outcome HeaderReader::length_is_known() {
  size_ = 0;
  for (unsigned i = 0; i < length_.size(); ++i) size_ |= static_cast<std::size_t>(length_[i]) << (8U * i);
  if (size_ > max_bytes_) {
    return fail_with("its connection header has " + std::to_string(size_) + " bytes; the maximum is " +
                     std::to_string(max_bytes_));
  }
  return Outcome::kWaiting;
}

HeaderReader::Outcome HeaderReader::read(int descriptor) {
  for (;;) {
    if (have_ >= length_.size() && have_ == length_.size() + size_) {
      auto decoded = decode_header(body_.view());
      if (!decoded) return fail_with(decoded.error().message);
      header_ = std::move(*decoded);
      return Outcome::kDone;
    }
    const bool in_length = have_ < length_.size();
    const auto wanted = in_length ? length_.size() - have_ : std::min(kStep, length_.size() + size_ - have_);
    const auto before = body_.size();
    auto* const into = in_length ? length_.data() + have_ : body_.extend(wanted);
    const auto got = ::recv(descriptor, into, wanted, MSG_DONTWAIT);
    const auto error = errno;
    if (!in_length) body_.resize(before + static_cast<std::size_t>(std::max<std::ptrdiff_t>(got, 0)));
    if (got == 0) return fail_with("it closed the connection before its header was complete");
    if (got < 0 && error == EINTR) continue;
    if (got < 0 && (error == EAGAIN || error == EWOULDBLOCK)) return Outcome::kWaiting;
    if (got < 0) return fail_with(errno_text(error));
    have_ += static_cast<std::size_t>(got);
    if (in_length && have_ == length_.size() && length_is_known() == Outcome::kFailed)
      return Outcome::kFailed;
  }
}

BytesWriter::Outcome BytesWriter::write(int descriptor, ByteView head, ByteView body) {
  std::size_t sent = 0;
  if (empty()) {
    iovec parts[2] = {{const_cast<std::uint8_t*>(head.data), head.size},
                      {const_cast<std::uint8_t*>(body.data), body.size}};
    msghdr message{};
    message.msg_iov = parts;
    message.msg_iovlen = 2;
    const auto count = ::sendmsg(descriptor, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) return Outcome::kBroken;
    sent = static_cast<std::size_t>(std::max<std::ptrdiff_t>(count, 0));
    written_ += sent;
    rest_.clear();
    at_ = 0;
  }
  const auto of_head = std::min(sent, head.size);
  const auto of_body = sent - of_head;
  rest_.append(head.data + of_head, head.size - of_head);
  rest_.append(body.data + of_body, body.size - of_body);
  return empty() ? Outcome::kEmpty : Outcome::kBlocked;
}

BytesWriter::Outcome BytesWriter::flush(int descriptor) {
  while (!empty()) {
    const auto count =
        ::send(descriptor, rest_.data() + at_, rest_.size() - at_, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno == EAGAIN || errno == EWOULDBLOCK ? Outcome::kBlocked : Outcome::kBroken;
    at_ += static_cast<std::size_t>(count);
    written_ += static_cast<std::size_t>(count);
  }
  rest_ = ByteBuffer();
  at_ = 0;
  return Outcome::kEmpty;
}

}  // namespace extperfc::translate
