#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>
#include <utility>

namespace extperfc::translate {

/// A view of bytes that another object owns, e.g. a serialized message.
struct ByteView {
  const std::uint8_t* data{nullptr};
  std::size_t size{0};
};

/// A growing buffer that does not initialise new bytes. Movable, not copyable.
class ByteBuffer {
 public:
  ByteBuffer() = default;
  explicit ByteBuffer(std::size_t capacity) { reserve(capacity); }
  ~ByteBuffer() { std::free(data_); }  // NOLINT(cppcoreguidelines-no-malloc): realloc moves without copying
  ByteBuffer(ByteBuffer&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)),
        size_(std::exchange(other.size_, 0)),
        capacity_(std::exchange(other.capacity_, 0)) {}
  ByteBuffer& operator=(ByteBuffer&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }
  ByteBuffer(const ByteBuffer&) = delete;
  ByteBuffer& operator=(const ByteBuffer&) = delete;

  [[nodiscard]] std::uint8_t* data() { return data_; }
  [[nodiscard]] const std::uint8_t* data() const { return data_; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  [[nodiscard]] ByteView view() const { return {data_, size_}; }

  void clear() { size_ = 0; }
  /// New bytes are uninitialised.
  void resize(std::size_t size) {
    if (size > capacity_) reserve(size + size / 2);
    size_ = size;
  }
  /// Appends `count` uninitialised bytes and returns a pointer to them.
  std::uint8_t* extend(std::size_t count) {
    const auto before = size_;
    resize(size_ + count);
    return data_ + before;
  }
  void append(const void* bytes, std::size_t count) {
    if (count != 0) std::memcpy(extend(count), bytes, count);
  }
  void reserve(std::size_t capacity) {
    if (capacity <= capacity_) return;
    void* moved = std::realloc(data_, capacity);  // NOLINT(cppcoreguidelines-no-malloc)
    if (moved == nullptr) throw std::bad_alloc();
    data_ = static_cast<std::uint8_t*>(moved);
    capacity_ = capacity;
  }

 private:
  std::uint8_t* data_{nullptr};
  std::size_t size_{0};
  std::size_t capacity_{0};
};

}  // namespace extperfc::translate
