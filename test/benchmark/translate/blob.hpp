#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "extperfc/base/error.hpp"

#include "translate/raw_message.hpp"

namespace extperfc::benchmark {

/// One version of a message type, as an advertisement needs it.
struct Version {
  std::string type;
  std::string md5;
  std::string definition;  ///< with what it embeds
};

/// The messages that are sent: a header and bytes. `Plain` is the same on both sides; `Grown` has one field
/// more on the new side, in front of the bytes.
struct Versions {
  Version plain;
  Version grown_old;
  Version grown_new;
};
[[nodiscard]] Result<Versions> make_versions();
/// What the new side has more in `Grown` [bytes].
inline constexpr std::uint32_t kGrowth = 8;

/// Writes both sides' definitions as packages under `folder`/old and `folder`/new.
[[nodiscard]] Result<void> write_packages(const std::filesystem::path& folder);

/// A message of the old side with `size` bytes on the wire in total, without its length; 64 at least.
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
