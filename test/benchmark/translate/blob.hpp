#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "extperfc/base/error.hpp"

#include "test/benchmark/translate/raw_message.hpp"

namespace extperfc::benchmark {

/// One version of a message type, as an advertisement needs it.
struct Definition {
  std::string type;
  std::string md5;
  std::string text;  ///< with what it embeds
};

/// The messages that are sent: a header and bytes. `Plain` is the same on both sides; `Grown` has one field
/// more on the workstation side, in front of the bytes.
struct Definitions {
  Definition plain;
  Definition grown_robot;
  Definition grown_workstation;
};
[[nodiscard]] Result<Definitions> make_definitions();
/// What the workstation side has more in `Grown` [bytes].
inline constexpr std::uint32_t kGrowth = 8;

/// Writes both sides' definitions as packages under `folder`/robot and `folder`/workstation.
[[nodiscard]] Result<void> write_packages(const std::filesystem::path& folder);

/// A message of the robot side with `size` bytes on the wire in total, without its length; 64 at least.
[[nodiscard]] boost::shared_ptr<RawMessage> make_blob(std::uint32_t size);
/// Number and time of sending, in the header: at the same place in every version.
void stamp_blob(RawMessage& blob, std::uint32_t number, std::int64_t monotonic_ns);
struct BlobStamp {
  std::uint32_t number{0};
  std::int64_t monotonic_ns{0};
};
/// Size and last bytes must be those of make_blob(), or of its conversion.
[[nodiscard]] bool blob_is_whole(const RawMessage& blob, std::uint32_t sent_size);
[[nodiscard]] BlobStamp stamp_of(const RawMessage& blob);

}  // namespace extperfc::benchmark
