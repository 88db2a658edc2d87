#include "translate/peer/http_message.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include "translate/peer/blanks.hpp"

namespace extperfc::translate {
namespace {

constexpr std::string_view kHeaderBlanks = " \t";
constexpr std::size_t kLongestSizeLine = 256;  ///< of a chunk, with extensions [bytes]

std::string lower(std::string_view text) {
  std::string out(text);
  for (auto& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

/// A whole number without sign; false if it is not a number or does not fit.
bool parse_size(std::string_view text, int base, std::size_t& size) {
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), size, base);
  return !text.empty() && problem == std::errc() && end == text.data() + text.size();
}

const char* phrase(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 400:
      return "Bad Request";
    case 405:
      return "Method Not Allowed";
    case 411:
      return "Length Required";
    case 413:
      return "Content Too Large";
    case 417:
      return "Expectation Failed";
    case 431:
      return "Request Header Fields Too Large";
    case 501:
      return "Not Implemented";
    case 503:
      return "Service Unavailable";
    default:
      return "Error";
  }
}

}  // namespace

HttpReader::Step HttpReader::read(std::string& bytes) {
  while (true) {
    const auto before = std::make_pair(part_, bytes.size());
    const auto step = read_part(bytes);
    if (step != Step::kMore || std::make_pair(part_, bytes.size()) == before) return step;
  }
}

HttpReader::Step HttpReader::read_part(std::string& bytes) {
  switch (part_) {
    case Part::kHeader:
      return read_header(bytes);
    case Part::kLength:
      return read_length(bytes);
    case Part::kUntilEnd:
      return read_until_end(bytes);
    case Part::kChunkSize:
      return read_chunk_size(bytes);
    case Part::kChunk:
      return read_chunk(bytes);
    case Part::kTrailer:
      return read_trailer(bytes);
    case Part::kDone:
      break;
  }
  return Step::kDone;
}

HttpReader::Step HttpReader::end_of_stream() {
  if (part_ == Part::kUntilEnd) {
    part_ = Part::kDone;
    return Step::kDone;
  }
  return broken(400, "the connection ended in the middle of a message");
}

HttpMessage HttpReader::take() {
  auto message = std::exchange(message_, {});
  part_ = Part::kHeader;
  missing_ = looked_at_ = trailer_ = 0;
  wants_continue_ = false;
  return message;
}

bool HttpReader::wants_continue() {
  return std::exchange(wants_continue_, false);
}

HttpReader::Step HttpReader::broken(int status, std::string problem) {
  problem_status_ = status;
  problem_ = std::move(problem);
  return Step::kBroken;
}

HttpReader::Step HttpReader::too_long() {
  return broken(413, "a body of more than " + std::to_string(limits_.body_bytes) + " bytes");
}

HttpReader::Step HttpReader::read_header(std::string& bytes) {
  while (looked_at_ == 0 && !bytes.empty() && (bytes[0] == '\r' || bytes[0] == '\n')) bytes.erase(0, 1);
  // The end is an empty line; lines may end without a carriage return.
  const auto from = looked_at_ > 3 ? looked_at_ - 3 : 0;
  const auto strict = bytes.find("\r\n\r\n", from);
  const auto loose = bytes.find("\n\n", from);
  const auto end = std::min(strict, loose);
  if (std::min(end, bytes.size()) > limits_.header_bytes)
    return broken(431, "a header of more than " + std::to_string(limits_.header_bytes) + " bytes");
  if (end == std::string::npos) {
    looked_at_ = bytes.size();
    return Step::kMore;
  }
  if (!parse_header(std::string_view(bytes).substr(0, end))) return broken(400, "not an HTTP header");
  bytes.erase(0, end + (strict <= loose ? 4 : 2));
  looked_at_ = 0;
  return choose_body();
}

bool HttpReader::parse_header(std::string_view header) {
  bool first = true;
  while (!header.empty()) {
    const auto end = header.find('\n');
    auto line = header.substr(0, end);
    header.remove_prefix(end == std::string_view::npos ? header.size() : end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (!(std::exchange(first, false) ? parse_first_line(line) : parse_field(line))) return false;
  }
  return !first;
}

bool HttpReader::parse_first_line(std::string_view line) {
  const auto space = line.find(' ');
  if (space == std::string_view::npos) return false;
  const auto last = line.rfind(' ');
  const auto version = kind_ == Kind::kRequest ? line.substr(last + 1) : line.substr(0, space);
  message_.http_1_1 = version == "HTTP/1.1";
  if (!message_.http_1_1 && version != "HTTP/1.0") return false;
  message_.keep_alive = message_.http_1_1;
  if (kind_ == Kind::kRequest) {
    message_.method = std::string(line.substr(0, space));
    return last > space;
  }
  std::size_t status = 0;
  if (!parse_size(line.substr(space + 1, 3), 10, status) || status < 100) return false;
  message_.status = static_cast<int>(status);
  return true;
}

bool HttpReader::parse_field(std::string_view line) {
  const auto colon = line.find(':');
  if (colon == std::string_view::npos || colon == 0) return false;
  const auto name = lower(line.substr(0, colon));
  const auto value = std::string(trimmed(line.substr(colon + 1), kHeaderBlanks));
  const auto [place, is_new] = message_.headers.emplace(name, value);
  if (!is_new && name == "content-length" && place->second != value) return false;
  if (name == "connection") {
    const auto options = lower(value);
    if (options.find("close") != std::string::npos) message_.keep_alive = false;
    if (options.find("keep-alive") != std::string::npos) message_.keep_alive = true;
  }
  return true;
}

HttpReader::Step HttpReader::choose_body() {
  if (kind_ == Kind::kResponse && message_.status < 200) {  // 100 Continue: the answer follows
    take();
    return Step::kMore;
  }
  const auto& headers = message_.headers;
  if (kind_ == Kind::kRequest && message_.method != "POST") return broken(405, "not a POST request");
  if (const auto coding = headers.find("transfer-encoding"); coding != headers.end()) {
    if (kind_ == Kind::kRequest || lower(coding->second) != "chunked" || headers.count("content-length") != 0)
      return broken(501, "an unsupported transfer encoding");
    part_ = Part::kChunkSize;
  } else if (const auto length = headers.find("content-length"); length != headers.end()) {
    if (const auto step = choose_length(length->second); step != Step::kMore) return step;
  } else if (kind_ == Kind::kRequest) {
    return broken(411, "a request without a Content-Length");
  } else {
    part_ = Part::kUntilEnd;
    message_.keep_alive = false;
  }
  const auto expect = headers.find("expect");
  wants_continue_ = expect != headers.end() && lower(expect->second) == "100-continue";
  return Step::kMore;
}

HttpReader::Step HttpReader::choose_length(const std::string& text) {
  if (!parse_size(text, 10, missing_)) return broken(400, "Content-Length is not a number");
  if (missing_ > limits_.body_bytes) return too_long();
  part_ = Part::kLength;
  return Step::kMore;
}

HttpReader::Step HttpReader::read_length(std::string& bytes) {
  if (message_.body.empty() && bytes.size() == missing_) {
    message_.body = std::exchange(bytes, {});
    missing_ = 0;
  } else {
    const auto count = std::min(missing_, bytes.size());
    message_.body.append(bytes, 0, count);
    bytes.erase(0, count);
    missing_ -= count;
  }
  if (missing_ != 0) return Step::kMore;
  part_ = Part::kDone;
  return Step::kDone;
}

HttpReader::Step HttpReader::read_until_end(std::string& bytes) {
  if (bytes.size() > limits_.body_bytes - message_.body.size()) return too_long();
  message_.body += bytes;
  bytes.clear();
  return Step::kMore;
}

HttpReader::Step HttpReader::read_chunk_size(std::string& bytes) {
  const auto end = bytes.find('\n');
  if (end == std::string::npos)
    return bytes.size() > kLongestSizeLine ? broken(400, "a chunk without a size") : Step::kMore;
  auto line = std::string_view(bytes).substr(0, end);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  if (!parse_size(trimmed(line.substr(0, line.find(';')), kHeaderBlanks), 16, missing_))
    return broken(400, "a chunk without a size");
  if (missing_ > limits_.body_bytes - message_.body.size()) return too_long();
  bytes.erase(0, end + 1);
  part_ = missing_ == 0 ? Part::kTrailer : Part::kChunk;
  return Step::kMore;
}

HttpReader::Step HttpReader::read_chunk(std::string& bytes) {
  const auto count = std::min(missing_, bytes.size());
  message_.body.append(bytes, 0, count);
  bytes.erase(0, count);
  missing_ -= count;
  if (missing_ != 0 || bytes.size() < 2) return Step::kMore;
  if (bytes[0] != '\r' || bytes[1] != '\n') return broken(400, "a chunk longer than its size");
  bytes.erase(0, 2);
  part_ = Part::kChunkSize;
  return Step::kMore;
}

/// Fields after the last chunk are passed over, up to an empty line.
HttpReader::Step HttpReader::read_trailer(std::string& bytes) {
  const auto end = bytes.find('\n');
  const auto length = end == std::string::npos ? bytes.size() : end + 1;
  if (trailer_ + length > limits_.header_bytes) return broken(431, "a trailer that is too long");
  if (end == std::string::npos) return Step::kMore;
  const bool empty = end == 0 || (end == 1 && bytes[0] == '\r');
  trailer_ += length;
  bytes.erase(0, length);
  if (!empty) return Step::kMore;
  part_ = Part::kDone;
  return Step::kDone;
}

std::string http_request(const std::string& host, const std::string& path, const std::string& body) {
  // One blank after the colon and these names: xmlrpcpp looks for them literally.
  return "POST " + path + " HTTP/1.1\r\nHost: " + host +
         "\r\nUser-Agent: extperfc\r\nContent-Type: text/xml\r\nContent-Length: " +
         std::to_string(body.size()) + "\r\n\r\n" + body;
}

std::string http_response(int status, bool keep_alive, const std::string& body) {
  return "HTTP/1.1 " + std::to_string(status) + ' ' + phrase(status) +
         "\r\nServer: extperfc\r\nConnection: " + (keep_alive ? "keep-alive" : "close") +
         "\r\nContent-Type: text/xml\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
}

}  // namespace extperfc::translate
