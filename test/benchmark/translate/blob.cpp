#include "test/benchmark/translate/blob.hpp"

#include <array>
#include <cstring>

#include <boost/make_shared.hpp>

#include "extperfc/base/atomic_file.hpp"
#include "extperfc/translate/schema.hpp"

namespace extperfc::benchmark {

namespace {

constexpr char kHeader[] = "uint32 seq\ntime stamp\nstring frame_id\n";
constexpr char kPlain[] = "std_msgs/Header header\nuint8[] data\n";
constexpr char kGrown[] = "std_msgs/Header header\nfloat64 scale\nuint8[] data\n";
constexpr char kFrame[] = "camera";

constexpr std::uint32_t kNumberAt = 0;
constexpr std::uint32_t kSecondsAt = 4;
constexpr std::uint32_t kNanosecondsAt = 8;
constexpr std::uint32_t kFrameAt = 12;
constexpr std::uint32_t kCountAt = kFrameAt + 4 + sizeof kFrame - 1;
constexpr std::uint32_t kDataAt = kCountAt + 4;
constexpr std::int64_t kNsPerSecond = 1'000'000'000;
constexpr std::uint32_t kTail = 16;  // bytes at the end that are compared

void put(RawMessage& blob, std::uint32_t at, std::uint32_t value) {  // little endian
  for (unsigned i = 0; i < 4; ++i) blob.bytes[at + i] = static_cast<std::uint8_t>(value >> (8U * i));
}

std::uint32_t get(const RawMessage& blob, std::uint32_t at) {
  std::uint32_t value = 0;
  for (unsigned i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(blob.bytes[at + i]) << (8U * i);
  return value;
}

/// Of the byte that is `from_end` bytes before the end.
std::uint8_t pattern(std::uint32_t from_end) {
  return static_cast<std::uint8_t>(from_end * 31U + 7U);
}

Result<Definition> make_definition(const std::string& type, const char* text) {
  const std::string full = text + std::string(80, '=') + "\nMSG: std_msgs/Header\n" + kHeader;
  const auto schema = translate::parse_full_text(type, full);
  if (!schema) return tl::unexpected(schema.error());
  return Definition{type, (*schema)->md5(), full};
}

}  // namespace

Result<Definitions> make_definitions() {
  auto plain = make_definition("bench_msgs/Plain", kPlain);
  if (!plain) return tl::unexpected(plain.error());
  auto grown_robot = make_definition("bench_msgs/Grown", kPlain);
  if (!grown_robot) return tl::unexpected(grown_robot.error());
  auto grown_workstation = make_definition("bench_msgs/Grown", kGrown);
  if (!grown_workstation) return tl::unexpected(grown_workstation.error());
  return Definitions{std::move(*plain), std::move(*grown_robot), std::move(*grown_workstation)};
}

Result<void> write_packages(const std::filesystem::path& folder) {
  for (const char* side : {"robot", "workstation"}) {
    const bool is_workstation = std::string(side) == "workstation";
    const auto msg = folder / side / "bench_msgs" / "msg";
    if (auto done = write_text_atomically(folder / side / "std_msgs" / "msg" / "Header.msg", kHeader); !done)
      return done;
    if (auto done = write_text_atomically(msg / "Plain.msg", kPlain); !done) return done;
    if (auto done = write_text_atomically(msg / "Grown.msg", is_workstation ? kGrown : kPlain); !done)
      return done;
  }
  return {};
}

boost::shared_ptr<RawMessage> make_blob(std::uint32_t size) {
  auto blob = boost::make_shared<RawMessage>();
  blob->resize(size);
  put(*blob, kFrameAt, sizeof kFrame - 1);
  std::memcpy(blob->bytes.get() + kFrameAt + 4, kFrame, sizeof kFrame - 1);
  put(*blob, kCountAt, size - kDataAt);
  for (std::uint32_t i = kDataAt; i < size; ++i) blob->bytes[i] = pattern(size - i);
  stamp_blob(*blob, 0, 0);
  return blob;
}

void stamp_blob(RawMessage& blob, std::uint32_t number, std::int64_t monotonic_ns) {
  put(blob, kNumberAt, number);
  put(blob, kSecondsAt, static_cast<std::uint32_t>(monotonic_ns / kNsPerSecond));
  put(blob, kNanosecondsAt, static_cast<std::uint32_t>(monotonic_ns % kNsPerSecond));
}

BlobStamp stamp_of(const RawMessage& blob) {
  return {get(blob, kNumberAt), get(blob, kSecondsAt) * kNsPerSecond + get(blob, kNanosecondsAt)};
}

bool blob_is_whole(const RawMessage& blob, std::uint32_t sent_size) {
  if (blob.size != sent_size && blob.size != sent_size + kGrowth) return false;
  for (std::uint32_t from_end = 1; from_end <= kTail; ++from_end)
    if (blob.bytes[blob.size - from_end] != pattern(from_end)) return false;
  return true;
}

}  // namespace extperfc::benchmark
