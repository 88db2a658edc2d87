#pragma once

#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <string>

#include "extperfc/base/error.hpp"

namespace extperfc::sources {

/// A file as text, plain or packed by gzip or bzip2, recognised by its first bytes (not by its name).
class PackedFile {
 public:
  /// kNotFound when there is no such file or it cannot be opened.
  [[nodiscard]] static Result<PackedFile> open(const std::filesystem::path& file);
  PackedFile(PackedFile&&) noexcept;
  PackedFile& operator=(PackedFile&&) noexcept;
  ~PackedFile();

  enum class Line { kRead, kTooLong, kEnd, kBroken };
  /// The next line without its end. Of a line of more than `max_bytes` the rest is skipped. kBroken: the
  /// packed data are damaged or break off.
  [[nodiscard]] Line next_line(std::string& line, std::size_t max_bytes);
  /// Up to `bytes` from here.
  [[nodiscard]] std::string read(std::size_t bytes);
  /// The fraction of the file's bytes that were read, [0, 1].
  [[nodiscard]] double progress() const;

 private:
  struct Stream;
  explicit PackedFile(std::unique_ptr<Stream> stream);
  std::unique_ptr<Stream> stream_;
};

}  // namespace extperfc::sources
