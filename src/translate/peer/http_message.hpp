#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/rpc.hpp"

/// HTTP/1.0 and 1.1 as far as XML-RPC needs it. Source: RFC 9112.
namespace extperfc::translate {

inline constexpr std::size_t kReadAtOnce = 64U << 10U;  ///< bytes taken from a connection in one call

struct HttpMessage {
  std::string method;  ///< of a request
  int status{0};       ///< of a response
  bool http_1_1{false};
  bool keep_alive{false};                      ///< the sender leaves the connection open afterwards
  std::map<std::string, std::string> headers;  ///< names in lower case
  std::string body;
};

/// Reads messages from a stream of bytes, one at a time.
class HttpReader {
 public:
  enum class Kind { kRequest, kResponse };
  enum class Step { kMore, kDone, kBroken };

  HttpReader(Kind kind, const RpcLimits& limits) : kind_(kind), limits_(limits) {}

  /// Takes what it needs from the front of `bytes`; after kDone the rest belongs to the next message.
  Step read(std::string& bytes);
  /// The stream ended: that completes a response without a length.
  Step end_of_stream();
  /// After kDone; begins anew.
  HttpMessage take();

  /// The header is complete, the body is not.
  [[nodiscard]] bool in_body() const { return part_ != Part::kHeader && part_ != Part::kDone; }
  /// What was read of the message's body [bytes].
  [[nodiscard]] std::size_t buffered() const { return message_.body.size(); }
  /// The request waits for "100 Continue" before it sends its body; true once.
  [[nodiscard]] bool wants_continue();
  /// After kBroken: the status for the sender and the reason.
  [[nodiscard]] int problem_status() const { return problem_status_; }
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  enum class Part { kHeader, kLength, kUntilEnd, kChunkSize, kChunk, kTrailer, kDone };

  Step read_part(std::string& bytes);
  Step read_header(std::string& bytes);
  bool parse_header(std::string_view header);
  bool parse_first_line(std::string_view line);
  bool parse_field(std::string_view line);
  Step choose_body();
  Step choose_length(const std::string& text);
  Step read_length(std::string& bytes);
  Step read_until_end(std::string& bytes);
  Step read_chunk_size(std::string& bytes);
  Step read_chunk(std::string& bytes);
  Step read_trailer(std::string& bytes);
  Step broken(int status, std::string problem);
  Step too_long();

  Kind kind_;
  RpcLimits limits_;
  Part part_{Part::kHeader};
  HttpMessage message_;
  std::size_t missing_{0};    ///< of the body or chunk [bytes]
  std::size_t looked_at_{0};  ///< of the header without its end [bytes]
  std::size_t trailer_{0};
  bool wants_continue_{false};
  int problem_status_{0};
  std::string problem_;
};

[[nodiscard]] std::string http_request(const std::string& host, const std::string& path,
                                       const std::string& body);
/// `status` 200 with XML, else an error without a body.
[[nodiscard]] std::string http_response(int status, bool keep_alive, const std::string& body);

}  // namespace extperfc::translate
